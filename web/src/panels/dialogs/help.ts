/** The list of shortcuts, in groups, to be searched; and how the mouse turns the stage. */

import { make, setText } from "../../dom";
import { type Shortcut, shownKey } from "../../shortcuts";
import { NAVIGATIONS, type Navigation } from "../../stage/navigation";
import type { Store } from "../../store";
import { choice } from "../fields";
import { closeButton, form, makeDialog } from "./dialog";

interface Entry {
  readonly root: HTMLElement;
  readonly words: string;
}

export class HelpDialog {
  readonly root = makeDialog("Keyboard shortcuts");
  private readonly search = make("input", {
    class: "field",
    type: "search",
    placeholder: "Search: a key, or what it does",
    "aria-label": "Search shortcuts",
    autocomplete: "off",
    spellcheck: "false",
  });
  private readonly none = make("p", { class: "note", role: "status", hidden: true });
  private groups: { readonly root: HTMLElement; readonly entries: readonly Entry[] }[] = [];

  constructor(private readonly store: Store) {
    this.root.classList.add("wide");
    this.search.addEventListener("input", () => this.filter());
  }

  /** Show what keys do, and what is done by hand. */
  show(shortcuts: readonly Shortcut[], byHand: readonly (readonly [string, string])[]): void {
    const keysOf = ({ keys }: Shortcut): (Node | string)[] =>
      keys.slice(0, 2).flatMap((key, i) => [...(i > 0 ? [" "] : []), make("kbd", {}, shownKey(key))]);
    const names = [...new Set(shortcuts.map((one) => one.group))];
    this.groups = [
      ...names.map((name) =>
        group(
          name,
          shortcuts
            .filter((one) => one.group === name)
            .map((one) => entry(keysOf(one), one.does, `${name} ${one.keys.map(shownKey).join(" ")}`)),
        ),
      ),
      group(
        "By hand",
        byHand.map(([how, does]) => entry([how], does, "By hand")),
      ),
    ];
    const navigation = choice<Navigation>("Turn the stage as in", "Which mouse buttons turn the stage", (name) => {
      this.store.look({ navigation: name });
      how();
    });
    navigation.show(
      NAVIGATIONS.map(({ name, text }) => ({ value: name, text })),
      this.store.view.navigation,
    );
    const told = make("span", { class: "note" });
    const how = (): void =>
      setText(told, NAVIGATIONS.find(({ name }) => name === this.store.view.navigation)?.how ?? "");
    how();
    navigation.row.classList.add("navigation");
    navigation.row.append(told);
    const title = make("h3", { tabindex: -1 }, "Keyboard shortcuts");
    const list = make("div", { class: "shortcutgroups", tabindex: 0, role: "group", "aria-label": "Shortcuts" });
    list.append(...this.groups.map((one) => one.root), this.none);
    this.root.replaceChildren(form(title, [this.search, list, navigation.row], [closeButton(this.root)]));
    this.search.value = "";
    this.filter();
    this.root.showModal();
    this.search.focus();
  }

  /** Show those that all words stand in. */
  private filter(): void {
    const words = this.search.value.toLowerCase().split(/\s+/u).filter(Boolean);
    let count = 0;
    for (const { root, entries } of this.groups) {
      let shown = 0;
      for (const one of entries) {
        one.root.hidden = !words.every((word) => one.words.includes(word));
        if (!one.root.hidden) shown++;
      }
      root.hidden = shown === 0;
      count += shown;
    }
    this.none.hidden = count > 0;
    setText(this.none, count > 0 ? "" : `Nothing is called “${this.search.value}”.`);
  }
}

function entry(keys: (Node | string)[], does: string, more: string): Entry {
  const root = make("div", {}, make("dt", {}, ...keys), make("dd", {}, does));
  return { root, words: `${root.textContent ?? ""} ${does} ${more}`.toLowerCase() };
}

function group(name: string, entries: readonly Entry[]): { root: HTMLElement; entries: readonly Entry[] } {
  const list = make("dl", { class: "shortcuts" }, ...entries.map((one) => one.root));
  return { root: make("section", { class: "shortcutgroup", "aria-label": name }, make("h4", {}, name), list), entries };
}
