/** Which line is which, and which colour: in a row under the timeline, off the curves. */

import { make, setText } from "../dom";
import type { Document } from "../messages";
import type { Store } from "../store";
import { scoreRange } from "./paint/heat";
import { referenceSpan } from "./reference_span";

const METHODS: Record<Document["method"], string> = {
  guided: "Guided",
  align: "In step",
  linear: "Linear",
  spline: "Spline",
};

export class Legend {
  private readonly method = make("span");
  private readonly flight = swatch("reference", "wide", "In the air");
  private readonly example = [swatch("key", "dotted", "Example"), swatch("muted", "hatched", "Example is silent")];
  private readonly range = make("span");
  private readonly score = swatch("ink", "scores", this.range);
  private readonly reference = [swatch("reference", "wide", "Imitated"), swatch("reference", "ticks", "Matched")];
  private scored: Float64Array | null = null;
  readonly root = make(
    "div",
    { class: "legend", "aria-hidden": true },
    swatch("output", "", this.method),
    swatch("spline", "dotted", "Spline"),
    swatch("muted", "dashed", "Linear"),
    ...this.example,
    this.flight,
    this.score,
    ...this.reference,
  );

  update(store: Store): void {
    const { document, clips, why } = store;
    const propagated = document?.example != null;
    setText(this.method, propagated ? "Propagated" : METHODS[document?.method ?? "guided"]);
    for (const one of this.example) one.hidden = !propagated;
    // Only figures fly.
    this.flight.hidden = !clips.some((clip) => clip.holds === "motion");
    const isScored = why !== null && why.n_output > 2;
    this.score.hidden = !isScored;
    if (isScored && why.scores !== this.scored) {
      this.scored = why.scores;
      const { low, high } = scoreRange(why.scores);
      setText(this.range, `Score ${brief(low)} to ${brief(high)}`);
    }
    for (const one of this.reference) one.hidden = referenceSpan(store) === null;
  }
}

/** Two digits of a number, without an exponent where it has a usual size. */
function brief(value: number): string {
  return String(Number(value.toPrecision(2)));
}

function swatch(color: string, kind: string, text: string | HTMLElement): HTMLElement {
  const line = make("i", { class: kind });
  line.style.color = `var(--${color})`;
  return make("span", { class: "swatch" }, line, text);
}
