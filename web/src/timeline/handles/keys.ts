/** Keytimes on the map: chosen, dragged, or moved by the arrows, one or several. */

import { deleteSelected } from "../../deleting";
import { changeKey, findKey, keyPlace, keysInOrder, type Room } from "../../document";
import { make, setAttribute } from "../../dom";
import { snapToBeat } from "../../media/beat_snap";
import type { Document, Key } from "../../messages";
import { clamp } from "../../scale";
import type { Store } from "../../store";
import { moveKeys, type Shift } from "../../together";
import { said } from "../../units";
import { type Drag, draggable } from "../drag";
import { inputTimeAt, inputY, outputTimeAt, outputX } from "../layout";
import { keep, move } from "./elements";
import { type Hand, isDelete, keepFocus, take } from "./hand";

export class KeyHandles {
  private readonly made = new Map<string, HTMLButtonElement>();

  constructor(
    private readonly hand: Hand,
    private readonly overlay: HTMLElement,
  ) {}

  place(): void {
    const { hand } = this;
    const { layout, scales, store } = hand;
    const { map } = layout;
    const { chosenKeys, problem } = store;
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
      setAttribute(button, "aria-label", `Keytime ${i + 1} of ${ordered.length}: ${described(store, key)}`);
      setAttribute(button, "aria-pressed", String(chosenKeys.has(key.id)));
      button.classList.toggle("faulty", problem?.key === key.id);
    });
  }

  /** Move the keytimes that are chosen by some frames; quick moves in a row are one step to undo. */
  nudge(frames: Shift): void {
    const { hand, room } = this;
    const { store } = hand;
    const { chosenKeys, view, selection } = store;
    const by = { output: frames.output / store.rate, input: frames.input / store.rate };
    const [id] = chosenKeys;
    const key = chosenKeys.size === 1 && id !== undefined ? findKey(hand.document, id) : null;
    if (key && !view.ripple) {
      const wanted = { outputTime: key.output_time + by.output, inputTime: key.input_time + by.input };
      const place = keyPlace(hand.document, key.id, wanted, room, view.snap);
      hand.nudge(key.id, changeKey(hand.document, key.id, place), "move key");
    } else if (chosenKeys.size > 0 && selection?.kind === "key") {
      hand.nudge([...chosenKeys].join(), moveKeys(hand.document, chosenKeys, by, room, view.ripple), "move keys");
    }
  }

  private make({ id }: Key): HTMLButtonElement {
    const { store } = this.hand;
    const button = make("button", { type: "button", class: "handle key" });
    button.addEventListener("focus", () => {
      if (store.chosenKeys.has(id)) store.chooseKeys(store.chosenKeys, id);
      else store.select({ kind: "key", id });
    });
    keepFocus(button);
    draggable(button, (down) => {
      if (down.button !== 0) return null;
      return this.drag(id, down);
    });
    button.addEventListener("keydown", (event) => this.press(id, event));
    return button;
  }

  private get room(): Room {
    const { store, outputEnd } = this.hand;
    return { inputEnd: store.inputEnd, rate: store.rate, outputEnd };
  }

  private drag(id: string, down: PointerEvent): Drag | null {
    const { hand, room } = this;
    const { store } = hand;
    const before = store.document;
    const key = before && findKey(before, id);
    if (!key) return null;
    const together = store.chosenKeys.has(id) && store.chosenKeys.size > 1;
    // With shift a click chooses it beside the others, and a drag goes straight.
    if (!down.shiftKey && !together) store.select({ kind: "key", id });
    const grabX = outputX(hand.layout, hand.scales, key.output_time);
    const grabY = inputY(hand.layout, hand.scales, key.input_time);
    const { ripple } = store.view;
    const moved = (dx: number, dy: number, event: PointerEvent): Document => {
      if (!store.chosenKeys.has(id)) store.select({ kind: "key", id });
      // With shift along one axis only: a key's pose or its time, not both.
      const straight = event.shiftKey ? (Math.abs(dx) > Math.abs(dy) ? "time" : "pose") : null;
      const wanted = {
        outputTime: straight === "pose" ? key.output_time : outputTimeAt(hand.layout, hand.scales, grabX + dx),
        inputTime: straight === "time" ? key.input_time : inputTimeAt(hand.layout, hand.scales, grabY + dy),
      };
      const onBeat = event.altKey ? {} : snapToBeat(store, hand.layout, hand.scales, wanted, straight);
      if (!together && !ripple) {
        const place = keyPlace(hand.document, id, { ...wanted, ...onBeat }, room, hand.snap(event), onBeat);
        return changeKey(hand.document, id, place);
      }
      const by = {
        output: (onBeat.outputTime ?? hand.snapOutput(wanted.outputTime, event)) - key.output_time,
        input: (onBeat.inputTime ?? hand.snapInput(wanted.inputTime, event)) - key.input_time,
      };
      if (straight === "pose") by.output = 0;
      if (straight === "time") by.input = 0;
      return moveKeys(before, store.chosenKeys, by, room, ripple);
    };
    const clicked = (): void => {
      if (down.shiftKey) store.toggleKey(id);
      else store.select({ kind: "key", id });
    };
    return hand.gesture(together ? "move keys" : "move key", moved, clicked, id);
  }

  private press(id: string, event: KeyboardEvent): void {
    const { hand } = this;
    const { store } = hand;
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const many = event.shiftKey ? 10 : 1;
    const moves: Record<string, Shift> = {
      ArrowLeft: { output: -many, input: 0 },
      ArrowRight: { output: many, input: 0 },
      ArrowUp: { output: 0, input: many },
      ArrowDown: { output: 0, input: -many },
    };
    const by = moves[event.key];
    if (!by && !isDelete(event)) return;
    take(event);
    if (!store.chosenKeys.has(id)) store.select({ kind: "key", id });
    if (by) this.nudge(by);
    else deleteSelected(store, hand.connection);
  }
}

function described(store: Store, { input_time, output_time, speed }: Key): string {
  const tangent = speed === null ? "" : `, speed ${speed.toFixed(2)}`;
  return `input ${said(store, input_time, 3)} at output ${said(store, output_time, 3)}${tangent}`;
}
