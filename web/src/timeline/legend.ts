/** Which line is which. */

import { make, setText } from "../dom";
import type { Document } from "../messages";
import type { Store } from "../store";
import type { Layout } from "./layout";

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
  readonly root = make(
    "div",
    { class: "tools", "aria-hidden": true },
    swatch("output", "", this.method),
    swatch("spline", "dotted", "Spline"),
    swatch("muted", "dashed", "Linear"),
    this.flight,
    ...this.example,
  );

  update({ map }: Layout, { document, clips }: Store): void {
    this.root.style.left = `${map.x + 8}px`;
    this.root.style.top = `${map.y + 5}px`;
    const propagated = document?.example != null;
    setText(this.method, propagated ? "Propagated" : METHODS[document?.method ?? "guided"]);
    for (const one of this.example) one.hidden = !propagated;
    // Only figures fly.
    this.flight.hidden = !clips.some((clip) => clip.holds === "motion");
  }
}

function swatch(color: string, kind: string, text: string | HTMLElement): HTMLElement {
  const line = make("i", { class: kind });
  line.style.color = `var(--${color})`;
  return make("span", { class: "swatch" }, line, text);
}
