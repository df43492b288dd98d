/** Buttons as the panels have them. */

import { make } from "../dom";
import { type IconName, icon } from "../icons";

export function button(text: string, title: string, action: () => void, symbol?: IconName): HTMLButtonElement {
  const made = make("button", { type: "button", class: "button", title }, symbol && icon(symbol), text);
  made.addEventListener("click", action);
  return made;
}

/** A button that shows a symbol alone; `label` is what a screen reader says, `title` what stands under the pointer. */
export function iconButton(symbol: IconName, label: string, action: () => void, title = label): HTMLButtonElement {
  const made = make("button", { type: "button", class: "button bare", "aria-label": label, title }, icon(symbol));
  made.addEventListener("click", action);
  return made;
}
