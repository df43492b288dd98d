/** The handles' elements: where they stand, what a screen reader says of them, and which there are. */

import { setAttribute } from "../../dom";

export function move(element: HTMLElement, x: number, y: number, shown: boolean): void {
  element.hidden = !shown;
  if (shown) element.style.transform = `translate(${x.toFixed(2)}px, ${y.toFixed(2)}px)`;
}

/** Say the value of a slider, the range that it is in, and how it is said. */
export function describe(element: HTMLElement, now: number, low: number, high: number, text: string): void {
  setAttribute(element, "aria-valuemin", low.toFixed(3));
  setAttribute(element, "aria-valuemax", high.toFixed(3));
  setAttribute(element, "aria-valuenow", now.toFixed(3));
  setAttribute(element, "aria-valuetext", text);
}

/** Make what is new, remove what is gone. */
export function keep<T extends { readonly id: string }, E>(
  kept: Map<string, E>,
  wanted: readonly T[],
  create: (item: T) => E,
  elements: (made: E) => readonly HTMLElement[],
  parent: HTMLElement,
): void {
  const ids = new Set(wanted.map((item) => item.id));
  for (const [id, made] of kept) {
    if (ids.has(id)) continue;
    for (const element of elements(made)) element.remove();
    kept.delete(id);
  }
  for (const item of wanted) {
    if (kept.has(item.id)) continue;
    const made = create(item);
    kept.set(item.id, made);
    parent.append(...elements(made));
  }
}
