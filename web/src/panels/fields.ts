/** Fields of the side: typed values that answer to Enter, and show what the document holds while nobody types. */

import { make, setAttribute, setText } from "../dom";
import { GrammarError } from "../grammar";
import { type Scrub, scrubbable } from "./scrub";

let count = 0;

export interface Field {
  readonly row: HTMLElement;
  readonly input: HTMLInputElement;
  /** What is wrong, said; in the row, or where the input alone was put. */
  readonly trouble: HTMLElement;
  /** Show a value, unless someone is typing another. */
  show(text: string): void;
  /** Say what is wrong with the value that is shown; null: nothing. */
  blame(message: string | null): void;
}

/**
 * A field for text; `commit` returns whether it understood what was typed, or throws what is wrong with it. With `scrub`
 * its value can be dragged to the left and to the right.
 */
export function textField(label: string, hint: string, commit: (text: string) => boolean, scrub?: Scrub): Field {
  const id = `retime-field-${++count}`;
  const input = make("input", {
    id,
    class: "field",
    type: "text",
    spellcheck: "false",
    autocomplete: "off",
    title: scrub ? `${hint}. Or drag across it` : hint,
  });
  if (scrub) scrubbable(input, scrub);
  const trouble = make("p", { id: `${id}-trouble`, class: "refused", hidden: true });
  let shown = "";
  let refused = false;
  // What is wrong with what was typed, and, said by the server, with what is shown.
  let misread: string | null = null;
  let blamed: string | null = null;
  const mark = (): void => {
    const message = misread ?? blamed;
    setText(trouble, message ?? "");
    trouble.hidden = message === null;
    setAttribute(input, "aria-describedby", message === null ? null : trouble.id);
    setAttribute(input, "aria-invalid", refused || message !== null ? "true" : null);
  };
  const accept = (): void => {
    refused = false;
    misread = null;
  };
  const take = (): void => {
    input.dataset.typing = "false";
    accept();
    try {
      const typed = input.value;
      refused = typed !== shown && !commit(typed.trim());
      // Enter has taken it: leaving the field does not take it again.
      if (!refused) shown = typed;
    } catch (error) {
      if (!(error instanceof GrammarError)) throw error;
      refused = true;
      misread = error.message;
    }
    mark();
  };
  input.addEventListener("change", take);
  input.addEventListener("input", () => (input.dataset.typing = String(input.value !== shown)));
  input.addEventListener("keydown", (event) => {
    // The page gets the keys with Control, except those that the field needs itself (see shortcuts.ts), and Escape where
    // there is nothing typed to take back: it stops a search.
    const passes = event.ctrlKey || event.metaKey || (event.key === "Escape" && input.dataset.typing !== "true");
    if (!passes) event.stopPropagation();
    if (event.key === "Escape") {
      input.dataset.typing = "false";
      input.value = shown;
      accept();
      mark();
      input.blur();
    }
    if (event.key === "Enter") {
      take();
      input.select();
    }
  });
  return {
    row: make("div", { class: "row" }, make("label", { for: id }, label), input, trouble),
    input,
    trouble,
    show(text) {
      if (text === shown && input.value === text) return;
      shown = text;
      const focused = document.activeElement === input;
      if (focused && input.dataset.typing === "true") return;
      accept();
      mark();
      if (input.value === text) return;
      input.value = text;
      if (focused) input.select();
    },
    blame(message) {
      blamed = message;
      mark();
    },
  };
}

/** Put under a row what is wrong with the value that it shows. */
export function blamable(
  row: HTMLElement,
  input: HTMLElement,
): { root: HTMLElement; blame(message: string | null): void } {
  const trouble = make("p", { id: `retime-trouble-${++count}`, class: "refused", hidden: true });
  return {
    root: make("div", {}, row, trouble),
    blame(message) {
      setText(trouble, message ?? "");
      trouble.hidden = message === null;
      setAttribute(input, "aria-describedby", message === null ? null : trouble.id);
      setAttribute(input, "aria-invalid", message === null ? null : "true");
    },
  };
}

export interface Slider {
  readonly row: HTMLElement;
  readonly input: HTMLInputElement;
  show(value: number, text: string): void;
}

/** A slider; `slide` is called while it moves, and once more, with `done`, when it is let go. */
export function slider(
  label: string,
  hint: string,
  bounds: { min: number; max: number; step: number },
  slide: (value: number, done: boolean) => void,
): Slider {
  const id = `retime-field-${++count}`;
  const input = make("input", { id, class: "slider", type: "range", title: hint, ...bounds });
  const said = make("span", { class: "note" });
  said.style.minWidth = "38px";
  said.style.textAlign = "right";
  input.addEventListener("input", () => slide(Number(input.value), false));
  input.addEventListener("change", () => slide(Number(input.value), true));
  return {
    row: make("div", { class: "row" }, make("label", { for: id }, label), make("span", { class: "pair" }, input, said)),
    input,
    show(value, text) {
      const now = String(value);
      if (input.value !== now) input.value = now;
      const share = `${(100 * (value - bounds.min)) / (bounds.max - bounds.min)}%`;
      if (input.style.getPropertyValue("--share") !== share) input.style.setProperty("--share", share);
      setAttribute(input, "aria-valuetext", text);
      setText(said, text);
    },
  };
}

export interface Check {
  readonly row: HTMLElement;
  readonly input: HTMLInputElement;
  /** What it is called beside its box. */
  readonly words: HTMLElement;
  show(on: boolean): void;
}

export function check(label: string, hint: string, change: (on: boolean) => void): Check {
  const input = make("input", { type: "checkbox" });
  const words = make("span", {}, label);
  input.addEventListener("change", () => change(input.checked));
  return {
    row: make("label", { class: "check", title: hint }, input, words),
    input,
    words,
    show(on) {
      input.checked = on;
    },
  };
}

export interface Choice<T extends string> {
  readonly row: HTMLElement;
  readonly select: HTMLSelectElement;
  show(options: readonly { value: T; text: string }[], value: T): void;
}

export function choice<T extends string>(label: string, hint: string, change: (value: T) => void): Choice<T> {
  const id = `retime-field-${++count}`;
  const select = make("select", { id, class: "field", title: hint });
  select.addEventListener("change", () => change(select.value as T));
  let made = "";
  return {
    row: make("div", { class: "row" }, make("label", { for: id }, label), select),
    select,
    show(options, value) {
      const name = JSON.stringify(options);
      if (name !== made) {
        made = name;
        select.replaceChildren(...options.map((one) => make("option", { value: one.value }, one.text)));
      }
      select.value = value;
    },
  };
}
