/** A menu where the right mouse button was pressed; the arrow keys move in it. */

import { make } from "../dom";

export interface MenuItem {
  readonly text: string;
  /** What does the same, as it is shown to a person. */
  readonly keys?: string;
  readonly action: () => void;
  readonly disabled?: boolean;
  /** Of what is on or off, or one of several. */
  readonly checked?: boolean;
}

/** Items, in groups with a line between them; empty groups are left out. */
export type MenuGroups = readonly (readonly MenuItem[])[];

/** Pixels that it keeps from the edges. */
const EDGE = 6;

export class Menu {
  readonly root = make("div", { class: "menu", role: "menu", hidden: true, "aria-label": "What can be done here" });
  private before: Element | null = null;

  constructor() {
    const { root } = this;
    root.addEventListener("keydown", (event) => {
      event.stopPropagation();
      const step = { ArrowDown: 1, ArrowUp: -1 }[event.key];
      if (event.key === "Escape" || event.key === "Tab") this.close();
      else if (step !== undefined) this.go(step);
      else if (event.key === "Home" || event.key === "End") this.go(event.key === "Home" ? 1 : -1, true);
      else return;
      event.preventDefault();
    });
    root.addEventListener("contextmenu", (event) => event.preventDefault());
  }

  get isOpen(): boolean {
    return !this.root.hidden;
  }

  open(x: number, y: number, groups: MenuGroups): void {
    const { root } = this;
    if (!this.isOpen) this.before = document.activeElement;
    const parts = groups.filter((group) => group.length > 0).map((group) => group.map((item) => this.entry(item)));
    root.replaceChildren(
      ...parts.flatMap((part, i) => (i > 0 ? [make("div", { class: "line", role: "separator" }), ...part] : part)),
    );
    root.hidden = false;
    const within = (root.parentElement as Element).getBoundingClientRect();
    const [width, height] = [root.offsetWidth, root.offsetHeight];
    root.style.left = `${Math.max(EDGE, Math.min(x - within.left, within.width - width - EDGE))}px`;
    root.style.top = `${Math.max(EDGE, Math.min(y - within.top, within.height - height - EDGE))}px`;
    this.go(1, true);
  }

  close(): void {
    if (!this.isOpen) return;
    this.root.hidden = true;
    if (this.before instanceof HTMLElement) this.before.focus({ preventScroll: true });
  }

  private entry({ text, keys, action, disabled = false, checked }: MenuItem): HTMLButtonElement {
    const made = make(
      "button",
      {
        type: "button",
        class: "item",
        tabindex: -1,
        disabled,
        role: checked === undefined ? "menuitem" : "menuitemcheckbox",
        "aria-checked": checked === undefined ? null : String(checked),
      },
      make("span", {}, text),
      keys !== undefined && make("kbd", {}, keys),
    );
    made.addEventListener("click", () => {
      this.close();
      action();
    });
    made.addEventListener("pointerenter", () => made.focus());
    return made;
  }

  /** Move the focus on, or to one of the ends. */
  private go(step: number, fromEnd = false): void {
    const items = [...this.root.querySelectorAll<HTMLButtonElement>("button:not(:disabled)")];
    const now = fromEnd ? -1 : items.indexOf(document.activeElement as HTMLButtonElement);
    const next = now < 0 ? (step > 0 ? 0 : items.length - 1) : (now + step + items.length) % items.length;
    items[next]?.focus();
  }
}
