/** Of several references: which one is shown on the lowest strip, and ranged there. */

import { make } from "../dom";
import type { Store } from "../store";
import type { Layout } from "./layout";
import { referenceNames } from "./reference_span";

export class ReferenceChooser {
  readonly root = make("select", { class: "field chooser", "aria-label": "Reference shown", hidden: true });
  private shown = "";

  constructor(private readonly store: Store) {
    this.root.addEventListener("change", () => store.look({ reference: Number(this.root.value) }));
  }

  update({ reference }: Layout): void {
    const { store, root } = this;
    const names = referenceNames(store);
    const now = JSON.stringify([names, store.reference, reference]);
    if (now === this.shown) return;
    this.shown = now;
    root.hidden = names.length < 2;
    root.replaceChildren(...names.map((name, i) => make("option", { value: i }, name)));
    root.value = String(store.reference);
    root.title = `Reference shown: ${names[store.reference] ?? ""}`;
    root.style.top = `${reference.y + (reference.height - 24) / 2}px`;
    root.style.width = `${reference.x - 14}px`;
  }
}
