/** What is imitated: the references, listed, and all that one can say about the one that is looked at. */

import type { Connection } from "../../connection";
import { make } from "../../dom";
import { addReference, removeReference } from "../../references";
import type { Store } from "../../store";
import { referenceNames } from "../../timeline/reference_span";
import { button, iconButton } from "../buttons";
import { ReferenceDetails } from "./reference_details";
import { documentOf, frame, type Section, type Side } from "./section";

export function referencesSection({ store, connection, dialogs }: Side): Section {
  const add = (path: string | null): void => {
    const next = addReference(documentOf(store), path);
    store.look({ reference: next.references.length - 1 });
    connection.edit(next, "add reference");
  };
  const file = button(
    "File…",
    "Imitate another clip too",
    () => dialogs.showOpen({ title: "Add a reference", holds: "clip", take: add }),
    "plus",
  );
  const itself = button("Itself", "Imitate the clip itself too, or a stretch of it", () => add(null), "plus");
  const { root, body } = frame("References", file, itself);
  const list = new ReferenceList(store, connection);
  const details = new ReferenceDetails(store, connection, dialogs);
  const output = button(
    "This output as a reference",
    "Keep the output as it is now, and imitate it: what was retimed by hand leads what comes after",
    () => void dialogs.keepOutput?.(add),
  );
  output.classList.add("framed", "wide");
  body.append(list.root, details.root, output);
  return {
    root,
    update() {
      list.update();
      details.update();
      output.hidden = dialogs.keepOutput === null;
      output.disabled = store.curve === null || store.problem !== null;
      // The clip itself is what is imitated already, where nothing else is.
      itself.hidden = documentOf(store).references.length === 0;
    },
  };
}

/** The names of all references, one of which is looked at. */
class ReferenceList {
  readonly root = make("div", { role: "group", "aria-label": "References" });
  private shown = "";

  constructor(
    private readonly store: Store,
    private readonly connection: Connection,
  ) {}

  update(): void {
    const { root, store } = this;
    const names = referenceNames(store);
    const { references } = documentOf(store);
    const faulty = store.problem?.reference ?? -1;
    const now = JSON.stringify([names, store.reference, faulty, references.map((one) => [one.weight, one.path])]);
    if (now === this.shown) return;
    this.shown = now;
    const focused = [...root.children].findIndex((row) => row.contains(document.activeElement));
    root.replaceChildren(...names.map((name, i) => this.makeRow(name, i, i === faulty)));
    // Whoever got here by the keyboard keeps the focus in the list.
    if (focused >= 0) root.children[Math.min(focused, names.length - 1)]?.querySelector("button")?.focus();
  }

  private makeRow(name: string, i: number, faulty: boolean): HTMLElement {
    const { store, connection } = this;
    const file = documentOf(store).references[i];
    const pick = button(name, file?.path ?? "Nothing else is imitated", () => store.look({ reference: i }));
    pick.classList.add("pick");
    pick.setAttribute("aria-pressed", String(i === store.reference));
    if (faulty) pick.classList.add("faulty");
    const weight = make("span", { class: "note" }, file && file.weight !== 1 ? `×${file.weight}` : "");
    const remove = iconButton(
      "trash",
      `Remove ${name}`,
      () => connection.edit(removeReference(documentOf(store), i), "remove reference"),
      "Remove this reference",
    );
    remove.hidden = !file;
    return make("div", { class: "refrow" }, pick, weight, remove);
  }
}
