/** Which line is which. */

import { make } from "../dom";
import type { Layout } from "./layout";

export class Legend {
  readonly root = make(
    "div",
    { class: "tools", "aria-hidden": true },
    swatch("output", "", "Guided"),
    swatch("spline", "dotted", "Spline"),
    swatch("muted", "dashed", "Linear"),
    swatch("reference", "", "In the air"),
  );

  place({ map }: Layout): void {
    this.root.style.left = `${map.x + 8}px`;
    this.root.style.top = `${map.y + 5}px`;
  }
}

function swatch(color: string, dash: string, text: string): HTMLElement {
  const line = make("i", { class: dash });
  line.style.color = `var(--${color})`;
  if (color === "reference") {
    line.style.borderTopWidth = "8px";
    line.style.opacity = "0.3";
  }
  return make("span", { class: "swatch" }, line, text);
}
