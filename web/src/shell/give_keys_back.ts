/** Whatever was used by the mouse gives the keys back: space plays, it does not press the same thing again. */

/** What is used by keys too, and is no field to type in. Handles keep the focus: the arrows move them. */
const USED = "button:not(.handle), summary, select, input[type=checkbox], input[type=range]";

export function giveKeysBack(root: HTMLElement): void {
  // A choice, a box behind its label and a slider are done with when they change; what only has been clicked as well.
  for (const kind of ["click", "change"]) {
    root.addEventListener(kind, ({ target }) => {
      const used = target instanceof Element ? target.closest<HTMLElement>(USED) : null;
      if (!used || used.closest("dialog") || !used.matches(":focus")) return;
      // A list of choices opens by a click, and is done with when one is taken.
      if (kind === "click" && used.matches("select")) return;
      // Who came by the keyboard goes on by it.
      if (!used.matches(":focus-visible")) used.blur();
    });
  }
}
