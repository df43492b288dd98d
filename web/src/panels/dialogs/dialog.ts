/** What all dialogs have in common. */

import { make } from "../../dom";

export function makeDialog(label: string): HTMLDialogElement {
  const dialog = make("dialog", { "aria-label": label });
  // A click on what lies around it closes it.
  dialog.addEventListener("pointerdown", (event) => {
    if (event.target === dialog) dialog.close();
  });
  // While it is open the page hears no keys. Closed, it may keep the focus until the next frame: a key that comes so
  // soon is for the page.
  dialog.addEventListener("keydown", (event) => {
    if (dialog.open) event.stopPropagation();
  });
  return dialog;
}

export function closeButton(dialog: HTMLDialogElement, text = "Close"): HTMLButtonElement {
  const made = make("button", { type: "button", class: "button framed" }, text);
  made.addEventListener("click", () => dialog.close());
  return made;
}

export function form(heading: HTMLElement, body: readonly Node[], footer: readonly Node[]): HTMLFormElement {
  return make("form", { method: "dialog" }, make("header", {}, heading), ...body, make("footer", {}, ...footer));
}

/** A form that does something of its own when it is sent; where that can't be done, the dialog stays. */
export function onSubmit(form: HTMLFormElement, submit: () => void): void {
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    submit();
  });
}

/** Where a dialog says why not. */
export class Refusal {
  readonly root = make("p", { class: "refused", role: "alert", hidden: true });

  say(reason: string | null): void {
    this.root.textContent = reason ?? "";
    this.root.hidden = reason === null;
  }
}
