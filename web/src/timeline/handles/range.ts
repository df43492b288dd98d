/** The ends of the stretch of the reference that is imitated. */

import type { Document } from "../../messages";
import { setReferenceRange } from "../../references";
import { clamp, toPixels, toValue } from "../../scale";
import { saidTime, unitsOf } from "../../units";
import { referenceView } from "../layout";
import { frameRange, referenceSpan } from "../reference_span";
import { describe, move } from "./elements";
import { type Hand, MARGIN } from "./hand";

type Side = "start" | "end";

const SIDES: readonly Side[] = ["start", "end"];
const LABELS: Record<Side, string> = {
  start: "First frame of the reference that is imitated",
  end: "Last frame of the reference that is imitated",
};

/** Seconds of a reference that are imitated at least: less is no motion to imitate. */
const SHORTEST = 1 / 3;

export class RangeHandles {
  readonly elements: readonly HTMLElement[];

  constructor(private readonly hand: Hand) {
    this.elements = SIDES.map((side) => this.make(side));
  }

  place(): void {
    const { hand } = this;
    const { reference } = hand.layout;
    const span = referenceSpan(this.hand.store);
    this.elements.forEach((handle, i) => {
      const time = span ? span[SIDES[i] as Side] : 0;
      const x = span ? toPixels(referenceView(hand.scales, span.lastTime), reference.width, time) + MARGIN : 0;
      handle.style.height = `${reference.height}px`;
      move(handle, x, reference.y, span !== null && x > MARGIN - 2 && x < reference.width + MARGIN + 2);
      describe(handle, time, 0, span?.lastTime ?? 0, saidTime(time, span?.clip.rate ?? 30, unitsOf(hand.store)));
    });
  }

  private make(side: Side): HTMLElement {
    const { hand } = this;
    const change = (time: number): Document | null => {
      const span = referenceSpan(hand.store);
      if (!span || !hand.store.document) return null;
      const least = Math.min(SHORTEST, span.lastTime);
      const start = side === "start" ? clamp(time, 0, span.end - least) : span.start;
      const end = side === "end" ? clamp(time, span.start + least, span.lastTime) : span.end;
      return setReferenceRange(hand.document, Math.max(span.source, 0), frameRange(span, start, end));
    };
    return hand.slider(
      "handle span",
      LABELS[side],
      () => {
        const span = referenceSpan(hand.store);
        if (!span) return null;
        const whole = referenceView(hand.scales, span.lastTime);
        const start = toPixels(whole, hand.layout.reference.width, span[side]);
        return hand.gesture("choose reference range", (dx) =>
          change(toValue(whole, hand.layout.reference.width, start + dx)),
        );
      },
      (by) => {
        const span = referenceSpan(hand.store);
        const next = span && change(span[side] + by / span.clip.rate);
        if (next) hand.nudge("reference", next, "choose reference range");
      },
    );
  }
}
