/** The end of the output: pulled, it makes the clip longer or shorter. */

import { lengthInFrames, setOption } from "../../document";
import { clamp } from "../../scale";
import { said } from "../../units";
import type { Drag } from "../drag";
import { inputY } from "../layout";
import { describe, move } from "./elements";
import type { Hand } from "./hand";

export class EndHandle {
  readonly element: HTMLElement;

  constructor(private readonly hand: Hand) {
    this.element = hand.slider(
      "handle key end",
      "End of the output",
      () => this.drag(),
      (by) => this.nudge(by),
    );
    this.element.addEventListener("focus", () => hand.store.select({ kind: "end" }));
  }

  place(): void {
    const { hand, element } = this;
    const { layout, scales, store, outputEnd } = hand;
    const { map } = layout;
    const x = hand.overlayX(outputEnd);
    const y = inputY(layout, scales, store.inputEnd);
    // In step with a reference, how long it lasts is the reference's to say.
    const pullable = store.knots !== null && (hand.document.method !== "align" || hand.document.example !== null);
    move(element, x, clamp(y, map.y, map.y + map.height), pullable && x > 4 && x < map.width + 23);
    describe(element, outputEnd, 0, 10 * Math.max(outputEnd, 1), said(store, outputEnd, 3));
    element.classList.toggle("selected", store.selection?.kind === "end");
  }

  /** A length that the search has chosen becomes one that is given. */
  private drag(): Drag | null {
    const { hand } = this;
    if (!hand.store.knots) return null;
    const start = hand.outputEnd;
    return hand.gesture("set length", (dx) => {
      const { from, to } = hand.scales.output;
      const seconds = (dx / hand.layout.map.width) * (to - from);
      return setOption(hand.document, "length", lengthInFrames(start + seconds, hand.store.rate));
    });
  }

  private nudge(by: number): void {
    const { hand } = this;
    const { rate, knots } = hand.store;
    if (!knots) return;
    hand.nudge(
      "end",
      setOption(hand.document, "length", lengthInFrames(hand.outputEnd + by / rate, rate)),
      "set length",
    );
  }
}
