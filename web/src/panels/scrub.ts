/** Dragging across a field: its value goes up to the right and down to the left, a step for some pixels. */

import type { Connection } from "../connection";
import type { Document } from "../messages";
import type { Store } from "../store";

/** A drag begins; what it returns is called with the steps so far, and with `done` once more when it ends. */
export type Scrub = () => (steps: number, done: boolean) => void;

const PIXELS = 3;
/** A hand that clicks trembles. */
const SLACK = 4;

/** Let a field be dragged across while nobody types in it; a click still begins to type. Shift: ten steps for one. */
export function scrubbable(input: HTMLInputElement, scrub: Scrub): void {
  input.classList.add("scrubs");
  input.addEventListener("pointerdown", (down) => {
    if (down.button !== 0 || input.ownerDocument.activeElement === input) return;
    // Else it has the focus, and text is marked.
    down.preventDefault();
    const over = new AbortController();
    const { signal } = over;
    input.setPointerCapture(down.pointerId);
    let drag: ((steps: number, done: boolean) => void) | null = null;
    let last = down.clientX;
    let pixels = 0;
    const steps = (): number => Math.trunc(pixels / PIXELS);
    input.addEventListener(
      "pointermove",
      (event) => {
        if (!drag && Math.abs(event.clientX - down.clientX) < SLACK) return;
        drag ??= scrub();
        pixels += (event.clientX - last) * (event.shiftKey ? 10 : 1);
        last = event.clientX;
        drag(steps(), false);
      },
      { signal },
    );
    const finish = (taken: boolean): void => {
      over.abort();
      drag?.(taken ? steps() : 0, true);
      if (drag || !taken) return;
      input.focus();
      input.select();
    };
    input.addEventListener("pointerup", () => finish(true), { signal });
    input.addEventListener("pointercancel", () => finish(false), { signal });
    window.addEventListener(
      "keydown",
      (event) => {
        if (event.key !== "Escape") return;
        event.stopPropagation();
        finish(false);
      },
      { signal, capture: true },
    );
  });
  // The page would focus it by the mouse's own event.
  input.addEventListener("mousedown", (event) => {
    if (input.ownerDocument.activeElement !== input && event.button === 0) event.preventDefault();
  });
}

interface Where {
  readonly store: Store;
  readonly connection: Connection;
}

/** Drag a value of the document; `put` returns the document with the value some steps from where it was. */
export function valueScrub(
  { store, connection }: Where,
  label: string,
  put: (before: Document) => (steps: number) => Document,
): Scrub {
  return () => {
    const gesture = connection.newGesture();
    const before = store.document;
    const change = before && put(before);
    let latest: number | null = null;
    return (steps, done) => {
      // Dragged nowhere, nothing was changed.
      if (!change || (latest === null ? steps === 0 : steps === latest && !done)) return;
      latest = steps;
      connection.edit(change(steps), label, gesture, done);
    };
  };
}

/** Drag a time: a frame a step, never below 0. */
export function timeScrub(
  where: Where,
  label: string,
  now: () => number,
  put: (before: Document, time: number) => Document,
): Scrub {
  return valueScrub(where, label, (before) => {
    const start = now();
    return (steps) => put(before, Math.max(0, start + steps / where.store.rate));
  });
}

/** Drag how long after something else a thing begins, which is written as it is typed: a frame a step, below 0 too. */
export function offsetScrub(
  where: Where,
  label: string,
  now: (document: Document) => number,
  put: (before: Document, written: string) => Document,
): Scrub {
  return valueScrub(where, label, (before) => {
    const start = now(before);
    return (steps) => put(before, `${Number((start + steps / where.store.rate).toFixed(4))}s`);
  });
}
