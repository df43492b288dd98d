/** Keytimes on the map: dragged, or moved by the arrows. */

import { deleteItem } from "../../deleting";
import { changeKey, findKey, keyPlace, keysInOrder, type Room } from "../../document";
import { make, setAttribute } from "../../dom";
import type { Key } from "../../messages";
import { clamp } from "../../scale";
import { type Drag, draggable } from "../drag";
import { inputTimeAt, inputY, outputTimeAt, outputX } from "../layout";
import { keep, move } from "./elements";
import { type Hand, isDelete, take } from "./hand";

export class KeyHandles {
  private readonly made = new Map<string, HTMLButtonElement>();

  constructor(
    private readonly hand: Hand,
    private readonly overlay: HTMLElement,
  ) {}

  focus(id: string): void {
    this.made.get(id)?.focus({ preventScroll: true });
  }

  place(): void {
    const { hand } = this;
    const { layout, scales, store } = hand;
    const { map } = layout;
    const { selection, problem } = store;
    const ordered = keysInOrder(hand.document);
    keep(
      this.made,
      ordered,
      (key) => this.make(key),
      (button) => [button],
      this.overlay,
    );
    ordered.forEach((key, i) => {
      const button = this.made.get(key.id) as HTMLButtonElement;
      const x = hand.overlayX(key.output_time);
      const y = inputY(layout, scales, key.input_time);
      const inView = x > 4 && x < map.width + 22 && y > map.y - 8 && y < map.y + map.height + 8;
      move(button, x, clamp(y, map.y, map.y + map.height), inView);
      setAttribute(button, "aria-label", `Keytime ${i + 1} of ${ordered.length}: ${described(key)}`);
      setAttribute(button, "aria-pressed", String(selection?.kind === "key" && selection.id === key.id));
      button.classList.toggle("faulty", problem?.key === key.id);
    });
  }

  private make({ id }: Key): HTMLButtonElement {
    const { store } = this.hand;
    const button = make("button", { type: "button", class: "handle key" });
    button.addEventListener("focus", () => store.select({ kind: "key", id }));
    draggable(button, (down) => {
      if (down.button !== 0) return null;
      return this.drag(id, button);
    });
    button.addEventListener("keydown", (event) => this.press(id, event));
    return button;
  }

  private get room(): Room {
    const { store, outputEnd } = this.hand;
    return { inputEnd: store.inputEnd, rate: store.rate, outputEnd };
  }

  private drag(id: string, button: HTMLElement): Drag | null {
    const { hand } = this;
    const key = hand.store.document && findKey(hand.store.document, id);
    if (!key) return null;
    button.focus({ preventScroll: true });
    const { room } = this;
    const grabX = outputX(hand.layout, hand.scales, key.output_time);
    const grabY = inputY(hand.layout, hand.scales, key.input_time);
    return hand.gesture("move key", (dx, dy, event) => {
      // With shift along one axis only: a key's pose or its time, not both.
      const straight = event.shiftKey ? (Math.abs(dx) > Math.abs(dy) ? "time" : "pose") : null;
      const wanted = {
        outputTime: straight === "pose" ? key.output_time : outputTimeAt(hand.layout, hand.scales, grabX + dx),
        inputTime: straight === "time" ? key.input_time : inputTimeAt(hand.layout, hand.scales, grabY + dy),
      };
      const snap = hand.store.view.snap !== event.altKey;
      return changeKey(hand.document, id, keyPlace(hand.document, id, wanted, room, snap));
    });
  }

  private press(id: string, event: KeyboardEvent): void {
    const { hand } = this;
    const { store } = hand;
    const key = store.document && findKey(store.document, id);
    if (!key || event.ctrlKey || event.metaKey || event.altKey) return;
    if (isDelete(event)) {
      take(event);
      deleteItem(store, hand.connection, { kind: "key", id });
      return;
    }
    const by = (event.shiftKey ? 10 : 1) / store.rate;
    const wanted = { outputTime: key.output_time, inputTime: key.input_time };
    if (event.key === "ArrowLeft") wanted.outputTime -= by;
    else if (event.key === "ArrowRight") wanted.outputTime += by;
    else if (event.key === "ArrowUp") wanted.inputTime += by;
    else if (event.key === "ArrowDown") wanted.inputTime -= by;
    else return;
    take(event);
    const place = keyPlace(hand.document, id, wanted, this.room, store.view.snap);
    hand.nudge(id, changeKey(hand.document, id, place), "move key");
  }
}

function described({ input_time, output_time, speed }: Key): string {
  const tangent = speed === null ? "" : `, speed ${speed.toFixed(2)}`;
  return `input ${input_time.toFixed(3)} s at output ${output_time.toFixed(3)} s${tangent}`;
}
