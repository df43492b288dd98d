/** The frame around keytimes that are chosen together: each of its sides scales them about the one across. */

import { make } from "../../dom";
import type { Document } from "../../messages";
import { clamp } from "../../scale";
import { type Extent, extentOf, type Ids, keysOf, type Scaling, scaleKeys } from "../../together";
import { said } from "../../units";
import { inputTimeAt, inputY, outputTimeAt, outputX } from "../layout";
import { describe, move } from "./elements";
import { type Hand, MARGIN } from "./hand";

/** Pixels between the frame and the outermost keytimes. */
const ROOM = 13;

type Side = "left" | "right" | "bottom" | "top";

const SIDES: readonly Side[] = ["left", "right", "bottom", "top"];
const LABELS: Record<Side, string> = {
  left: "Scale the chosen keytimes' output times about the last",
  right: "Scale the chosen keytimes' output times about the first",
  bottom: "Scale the chosen keytimes' input times about the last",
  top: "Scale the chosen keytimes' input times about the first",
};

export class ChosenFrame {
  readonly elements: readonly HTMLElement[];
  private readonly frame = make("div", { class: "chosenframe", "aria-hidden": true, hidden: true });
  private readonly sides: readonly HTMLElement[];

  constructor(private readonly hand: Hand) {
    this.sides = SIDES.map((side) => this.make(side));
    this.elements = [this.frame, ...this.sides];
  }

  place(): void {
    const { hand, extent, frame, sides } = this;
    const { layout, scales } = hand;
    const { map } = layout;
    frame.hidden = extent === null;
    if (!extent) {
      for (const side of sides) move(side, 0, 0, false);
      return;
    }
    const left = outputX(layout, scales, extent.outputStart) - map.x + MARGIN - ROOM;
    const right = outputX(layout, scales, extent.outputEnd) - map.x + MARGIN + ROOM;
    const top = clamp(inputY(layout, scales, extent.inputEnd) - ROOM, map.y, map.y + map.height);
    const bottom = clamp(inputY(layout, scales, extent.inputStart) + ROOM, map.y, map.y + map.height);
    move(frame, left, top, true);
    frame.style.width = `${right - left}px`;
    frame.style.height = `${Math.max(bottom - top, 0)}px`;
    const places: Record<Side, [x: number, y: number, wide: number]> = {
      left: [left, (top + bottom) / 2, extent.outputEnd - extent.outputStart],
      right: [right, (top + bottom) / 2, extent.outputEnd - extent.outputStart],
      bottom: [(left + right) / 2, bottom, extent.inputEnd - extent.inputStart],
      top: [(left + right) / 2, top, extent.inputEnd - extent.inputStart],
    };
    sides.forEach((handle, i) => {
      const [x, y, wide] = places[SIDES[i] as Side];
      // What has no extent can't be made longer.
      move(handle, x, y, wide > 0.5 / hand.store.rate && x > 0 && x < map.width + 24);
      describe(handle, wide, 0, 10 * wide, said(hand.store, wide));
    });
  }

  /** Where the chosen keytimes lie; null where they are fewer than two. */
  private get extent(): Extent | null {
    const { chosenKeys } = this.hand.store;
    return chosenKeys.size > 1 ? extentOf(keysOf(this.hand.document, chosenKeys)) : null;
  }

  private make(side: Side): HTMLElement {
    const { hand } = this;
    const { store } = hand;
    const axis = side === "left" || side === "right" ? "output" : "input";
    const isStart = side === "left" || side === "bottom";
    const ends = (extent: Extent): [held: number, pulled: number] => {
      const start = axis === "output" ? extent.outputStart : extent.inputStart;
      const end = axis === "output" ? extent.outputEnd : extent.inputEnd;
      return isStart ? [end, start] : [start, end];
    };
    const scaled = (before: Document, ids: Ids, about: number, factor: number, snap: boolean): Document => {
      const scaling: Scaling = { about, factor };
      const room = { inputEnd: store.inputEnd, rate: store.rate, outputEnd: hand.outputEnd };
      return scaleKeys(before, ids, { [axis]: scaling }, room, snap);
    };
    const handle = hand.slider(
      "handle side",
      LABELS[side],
      () => {
        const { extent } = this;
        const before = store.document;
        if (!extent || !before) return null;
        const ids = store.chosenKeys;
        const [held, pulled] = ends(extent);
        const { layout, scales } = hand;
        return hand.gesture("scale keys", (dx, dy, event) => {
          const wanted =
            axis === "output"
              ? outputTimeAt(layout, scales, outputX(layout, scales, pulled) + dx)
              : inputTimeAt(layout, scales, inputY(layout, scales, pulled) + dy);
          // Pulled past the side that is held they would run backward.
          const factor = Math.max((hand.onFrame(wanted, event) - held) / (pulled - held), 0);
          return scaled(before, ids, held, factor, store.view.snap !== event.altKey);
        });
      },
      (by) => {
        const { extent } = this;
        if (!extent) return;
        const [held, pulled] = ends(extent);
        const factor = (pulled + by / store.rate - held) / (pulled - held);
        if (factor > 0) {
          const next = scaled(hand.document, store.chosenKeys, held, factor, store.view.snap);
          hand.nudge(`scale ${side}`, next, "scale keys");
        }
      },
    );
    handle.dataset.axis = axis;
    return handle;
  }
}
