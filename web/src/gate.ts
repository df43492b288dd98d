/**
 * Changes on their way to the server. They go in order, each when the one before is answered; of a drag that waits,
 * only the newest position goes.
 *
 * A change goes at once: waiting for the next frame would show its effect a frame later. Only changes that follow each
 * other faster than anyone can see wait for the next frame; some mice report a thousand of them a second.
 */

export interface Change<T> {
  readonly value: T;
  /** Changes of one gesture replace each other while they wait; others never do. */
  readonly gesture: string;
  /** When the person moved, as `performance.now()` counts: of this change, and of those that it replaced. */
  readonly moves: readonly number[];
}

/** Runs a callback once, at the next animation frame. */
export type AtNextFrame = (callback: () => void) => void;

/** Half a frame. If changes went out faster than this, the answers to many of them would never be seen. */
const SPACING_MS = 8;

export class Gate<T> {
  private waiting: Change<T>[] = [];
  private unanswered: Change<T> | null = null;
  private asked = false;
  private sent = -Infinity;

  /** `send` returns whether it could send; a change that could not be sent stays first in line. */
  constructor(
    private readonly send: (change: Change<T>) => boolean,
    private readonly atNextFrame: AtNextFrame,
    private readonly now: () => number = () => performance.now(),
  ) {}

  /** Whether a change waits or has no answer yet. */
  get busy(): boolean {
    return this.waiting.length > 0 || this.unanswered !== null;
  }

  /** Whether a change waits that was not sent. */
  get waits(): boolean {
    return this.waiting.length > 0;
  }

  /** Offer a change; it replaces one of the same gesture that still waits. */
  offer(value: T, gesture: string, moved: number): void {
    const last = this.waiting.at(-1);
    const replaced = last?.gesture === gesture ? this.waiting.pop() : undefined;
    this.waiting.push({ value, gesture, moves: [...(replaced?.moves ?? []), moved] });
    this.ask();
  }

  /** The server has answered the change that was sent last: the next one may go. */
  answered(): void {
    this.unanswered = null;
    this.ask();
  }

  /** Drop all changes: the server has refused one, or is gone. */
  reset(): void {
    this.waiting = [];
    this.unanswered = null;
  }

  private ask(): void {
    if (this.asked || this.unanswered || this.waiting.length === 0) return;
    if (this.now() - this.sent >= SPACING_MS) return this.sendNext();
    this.asked = true;
    this.atNextFrame(() => {
      this.asked = false;
      this.sendNext();
    });
  }

  private sendNext(): void {
    const next = this.waiting[0];
    if (!next || this.unanswered || !this.send(next)) return;
    this.waiting.shift();
    this.unanswered = next;
    this.sent = this.now();
  }
}
