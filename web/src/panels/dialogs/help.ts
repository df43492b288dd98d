/** The list of shortcuts. */

import { make } from "../../dom";
import { type Shortcut, shownKey } from "../../shortcuts";
import { closeButton, form, makeDialog } from "./dialog";

export class HelpDialog {
  readonly root = makeDialog("Keyboard shortcuts");

  constructor() {
    this.root.classList.add("wide");
  }

  /** Show what keys do, and what is done by hand. */
  show(shortcuts: readonly Shortcut[], byHand: readonly (readonly [string, string])[]): void {
    const entry = (keys: (Node | string)[], does: string): HTMLElement =>
      make("div", {}, make("dt", {}, ...keys), make("dd", {}, does));
    const keysOf = ({ keys }: Shortcut): (Node | string)[] =>
      keys.slice(0, 2).flatMap((key, i) => [...(i > 0 ? [" "] : []), make("kbd", {}, shownKey(key))]);
    const list = make(
      "dl",
      { class: "shortcuts" },
      ...shortcuts.map((one) => entry(keysOf(one), one.does)),
      ...byHand.map(([how, does]) => entry([how], does)),
    );
    const title = make("h3", { tabindex: -1 }, "Keyboard shortcuts");
    this.root.replaceChildren(form(title, [list], [closeButton(this.root)]));
    this.root.showModal();
    title.focus();
  }
}
