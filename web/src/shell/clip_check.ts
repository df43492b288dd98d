/** Whether a file can be one more clip or reference: the server reads it, before the document names it. */

import type { Connection } from "../connection";
import type { Found } from "../messages";

interface Asked {
  readonly path: string;
  readonly take: (place: string) => void;
  readonly refuse: (reason: string) => void;
}

export class ClipCheck {
  private waiting: readonly Asked[] = [];

  constructor(private readonly connection: Pick<Connection, "find">) {}

  /** Ask; one of the two is called with the answer, neither where the server is gone meanwhile. */
  ask(path: string, take: (place: string) => void, refuse: (reason: string) => void): void {
    this.waiting = [...this.waiting, { path, take, refuse }];
    this.connection.find(path, { asClip: true });
  }

  /** The server has answered; whether that was asked here. */
  found({ path, place, refused }: Found): boolean {
    const asked = this.waiting.find((one) => one.path === path);
    if (!asked) return false;
    this.waiting = this.waiting.filter((one) => one !== asked);
    if (refused === null) asked.take(place);
    else asked.refuse(refused);
    return true;
  }

  /** The server is gone: nothing is heard any more of what it was asked. */
  lost(): void {
    this.waiting = [];
  }
}
