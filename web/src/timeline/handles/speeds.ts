/** The dots on the speed curve: the speed at each keytime, set or free. */

import { changeKey, findKey, keysInOrder } from "../../document";
import { setAttribute } from "../../dom";
import type { Document, Key } from "../../messages";
import { speedAtY, speedY } from "../layout";
import { describe, keep, move } from "./elements";
import { type Hand, isDelete, take } from "./hand";
import { FASTEST, roundSpeed, SLOWEST, stepSpeed } from "./speed_range";

export class SpeedHandles {
  private readonly made = new Map<string, HTMLElement>();

  constructor(
    private readonly hand: Hand,
    private readonly overlay: HTMLElement,
  ) {}

  place(): void {
    const { hand } = this;
    const { layout, scales, store } = hand;
    const { chosenKeys } = store;
    const ordered = keysInOrder(hand.document);
    keep(
      this.made,
      ordered,
      (key) => this.make(key),
      (handle) => [handle],
      this.overlay,
    );
    ordered.forEach((key, i) => {
      const handle = this.made.get(key.id) as HTMLElement;
      const x = hand.overlayX(key.output_time);
      const shown = key.speed ?? hand.curveSpeed(key.output_time);
      move(handle, x, speedY(layout, scales, shown), x > 4 && x < layout.map.width + 22);
      handle.classList.toggle("set", key.speed !== null);
      handle.classList.toggle("selected", chosenKeys.has(key.id));
      setAttribute(handle, "aria-label", `Speed at keytime ${i + 1}`);
      describe(handle, shown, SLOWEST, FASTEST, `${shown.toFixed(2)} times${key.speed === null ? ", free" : ", set"}`);
    });
  }

  private make({ id }: Key): HTMLElement {
    const { hand } = this;
    const key = (): Key | null => hand.store.document && findKey(hand.store.document, id);
    const shown = (): number => {
      const now = key();
      return now?.speed ?? (now ? hand.curveSpeed(now.output_time) : 1);
    };
    const set = (speed: number): Document => changeKey(hand.document, id, { speed });
    const handle = hand.slider(
      "handle speed",
      "Speed",
      () => {
        const start = speedY(hand.layout, hand.scales, shown());
        return hand.gesture("set speed at key", (_dx, dy) =>
          set(roundSpeed(speedAtY(hand.layout, hand.scales, start + dy))),
        );
      },
      (by) => hand.nudge(`${id} speed`, set(stepSpeed(shown(), by)), "set speed at key"),
    );
    handle.addEventListener("focus", () => hand.store.select({ kind: "key", id }));
    const free = (): void => {
      if (typeof key()?.speed !== "number") return;
      hand.connection.edit(changeKey(hand.document, id, { speed: null }), "free speed at key");
    };
    handle.addEventListener("dblclick", free);
    handle.addEventListener("keydown", (event) => {
      if (!isDelete(event)) return;
      take(event);
      free();
    });
    return handle;
  }
}
