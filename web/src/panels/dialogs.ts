/** Dialogs: open, save, export, shortcuts. */

import { make, setText } from "../dom";
import { icon } from "../icons";
import type { Browse, Found, Listing } from "../messages";
import type { Session } from "../session";
import { type Shortcut, shownKey } from "../shortcuts";
import type { Store } from "../store";
import { type Check, type Choice, check, choice, type Field, textField } from "./fields";

/** What a file is wanted for. */
export interface Wanted {
  readonly title: string;
  readonly holds: Browse["holds"];
  take(path: string): void;
}

export class Dialogs {
  private readonly help: HTMLDialogElement;
  private readonly open: HTMLDialogElement;
  private readonly write: HTMLDialogElement;
  private readonly openTitle = make("h3", {}, "Open");
  private readonly openTrouble = make("p", { class: "refused", role: "alert", hidden: true });
  private readonly writeTrouble = make("p", { class: "refused", role: "alert", hidden: true });
  private wanted: Wanted;
  private readonly files = make("ul", { class: "files", "aria-label": "Files" });
  private readonly folder = make("p", { class: "note" });
  private readonly openPath: Field;
  private readonly writeTitle = make("h3", {}, "Save project");
  private readonly what: Choice<"motion" | "warp" | "picture">;
  private readonly whichClip: Choice<string>;
  private readonly writePath: Field;
  private readonly overwrite: Check;
  private mayOverwrite = false;
  private saving = true;
  private listing: Listing | null = null;

  constructor(
    readonly root: HTMLElement,
    private readonly store: Store,
    private readonly session: Session,
    private readonly upload: ((files: readonly File[], then: (path: string) => void) => void) | null,
  ) {
    this.help = this.dialog("Keyboard shortcuts", []);
    this.wanted = this.document();
    this.openPath = textField("Path", "As your system writes it", () => true);
    this.what = choice("What", "What to write", () => this.suggest());
    this.whichClip = choice("Clip", "Of a group: which clip", () => this.suggest());
    this.writePath = textField("Path", "The name's ending says in which format", () => true);
    this.overwrite = check("Replace the file if it is there", "", (on) => (this.mayOverwrite = on));
    this.open = this.openDialog();
    this.write = this.writeDialog();
    root.append(this.help, this.open, this.write);
  }

  get isOpen(): boolean {
    return this.root.querySelector("dialog[open]") !== null;
  }

  showHelp(shortcuts: readonly Shortcut[], hands: readonly (readonly [string, string])[]): void {
    const entry = (keys: (Node | string)[], does: string): HTMLElement =>
      make("div", {}, make("dt", {}, ...keys), make("dd", {}, does));
    const list = make(
      "dl",
      { class: "shortcuts" },
      ...shortcuts.map((one) =>
        entry(
          one.keys.slice(0, 2).flatMap((key, i) => [...(i > 0 ? [" "] : []), make("kbd", {}, shownKey(key))]),
          one.does,
        ),
      ),
      ...hands.map(([how, does]) => entry([how], does)),
    );
    const title = make("h3", { tabindex: -1 }, "Keyboard shortcuts");
    this.help.classList.add("wide");
    this.help.replaceChildren(form(title, [list], [closeButton(this.help)]));
    this.help.showModal();
    title.focus();
  }

  private document(): Wanted {
    return { title: "Open", holds: "clip", take: (path) => this.session.open(path) };
  }

  /** Choose a file: a document to open, or one that is wanted for something else. */
  showOpen(wanted = this.document()): void {
    this.wanted = wanted;
    setText(this.openTitle, wanted.title);
    this.open.setAttribute("aria-label", wanted.title);
    this.openPath.input.value = "";
    this.openTrouble.hidden = true;
    this.open.showModal();
    this.session.browse(this.listing?.folder ?? null, wanted.holds);
  }

  /** Whether a file that was named may be used. */
  found({ path, place, refused: reason, exists }: Found): void {
    const [dialog, field, trouble] = this.write.open
      ? [this.write, this.writePath, this.writeTrouble]
      : [this.open, this.openPath, this.openTrouble];
    if (!dialog.open || field.input.value.trim() !== path) return;
    const inTheWay = dialog === this.write && exists && !this.mayOverwrite && place !== this.store.state?.path;
    const refused =
      reason ?? (inTheWay ? "This file is there already: choose another name, or tick the box to replace it." : null);
    setText(trouble, refused ?? "");
    trouble.hidden = refused === null;
    if (refused !== null) return;
    dialog.close();
    if (dialog === this.open) this.wanted.take(place);
    else if (this.saving) this.session.save(place, this.mayOverwrite);
    else this.session.export(this.kind, place, Number(this.whichClip.select.value || 0), this.mayOverwrite);
  }

  showSave(): void {
    this.saving = true;
    this.showWrite("Save project");
  }

  showExport(): void {
    this.saving = false;
    this.showWrite("Export");
  }

  list(listing: Listing): void {
    this.listing = listing;
    setText(this.folder, listing.folder);
    const entry = (name: string, kind: "up" | "folder" | "file", action: () => void): HTMLElement => {
      const made = make("button", { type: "button", class: "button" }, icon(kind), name);
      made.addEventListener("click", action);
      return make("li", {}, made);
    };
    const { folder, parent } = listing;
    this.files.replaceChildren(
      ...(parent === null ? [] : [entry("..", "up", () => this.session.browse(parent, this.wanted.holds))]),
      ...listing.folders.map((name) =>
        entry(name, "folder", () => this.session.browse(joined(folder, name), this.wanted.holds)),
      ),
      ...listing.files.map((name) => entry(name, "file", () => this.ask(joined(folder, name)))),
    );
    if (this.write.open && this.writePath.input.value === "") this.suggest();
  }

  /** Ask for a file; it is used once the server has said that it may be. */
  private ask(path: string): void {
    this.openPath.input.value = path;
    this.session.find(path, false);
  }

  /** Make a dialog like the others. */
  dialog(label: string, children: Node[]): HTMLDialogElement {
    const dialog = make("dialog", { "aria-label": label }, ...children);
    // A click on what lies around it closes it.
    dialog.addEventListener("pointerdown", (event) => {
      if (event.target === dialog) dialog.close();
    });
    dialog.addEventListener("keydown", (event) => event.stopPropagation());
    return dialog;
  }

  private openDialog(): HTMLDialogElement {
    const dialog = this.dialog("Open", []);
    const go = make("button", { type: "submit", class: "button main" }, "Open");
    const footer: HTMLElement[] = [];
    if (this.upload) {
      const { upload } = this;
      const picker = make("input", { type: "file", multiple: true, hidden: true });
      picker.addEventListener("change", () => {
        dialog.close();
        upload([...(picker.files ?? [])], (path) => this.wanted.take(path));
        picker.value = "";
      });
      const elsewhere = make("button", { type: "button", class: "button framed" }, "From elsewhere…");
      elsewhere.addEventListener("click", () => picker.click());
      footer.push(elsewhere, picker, make("span", { class: "gap" }));
    }
    const body = form(
      this.openTitle,
      [this.folder, this.files, this.openPath.row, this.openTrouble],
      [...footer, closeButton(dialog, "Cancel"), go],
    );
    body.addEventListener("submit", (event) => {
      event.preventDefault();
      const path = this.openPath.input.value.trim();
      if (path !== "") this.ask(path);
    });
    dialog.append(body);
    return dialog;
  }

  private writeDialog(): HTMLDialogElement {
    const dialog = this.dialog("Write", []);
    const go = make("button", { type: "submit", class: "button main" }, "Write");
    const body = form(
      this.writeTitle,
      [this.what.row, this.whichClip.row, this.writePath.row, this.writeTrouble, this.overwrite.row],
      [closeButton(dialog, "Cancel"), go],
    );
    body.addEventListener("submit", (event) => {
      event.preventDefault();
      let path = this.writePath.input.value.trim();
      if (path === "") {
        this.writePath.input.focus();
        return;
      }
      if (this.saving && !/\.retime$/iu.test(path)) path = `${path}.retime`;
      this.writePath.input.value = path;
      this.session.find(path, true);
    });
    dialog.append(body);
    return dialog;
  }

  private get kind(): "motion" | "warp" | "picture" {
    return this.what.select.value as "motion" | "warp" | "picture";
  }

  private showWrite(title: string): void {
    setText(this.writeTitle, title);
    this.write.setAttribute("aria-label", title);
    this.what.row.hidden = this.saving;
    this.what.show(
      [
        { value: "motion", text: "Motion, retimed" },
        { value: "warp", text: "Warp (JSON)" },
        { value: "picture", text: "Picture of the warp (SVG, PNG, PDF)" },
      ],
      this.kind || "motion",
    );
    this.whichClip.show(
      this.store.clips.map((clip, i) => ({ value: String(i), text: clip.name })),
      String(this.store.view.clip),
    );
    this.mayOverwrite = false;
    this.writeTrouble.hidden = true;
    this.overwrite.show(false);
    this.suggest();
    this.write.showModal();
    this.writePath.input.focus();
    this.writePath.input.select();
  }

  /** A path that says what is in it, beside the clip or the project. */
  private suggest(): void {
    const { state, document, clips } = this.store;
    const which = this.saving ? 0 : Number(this.whichClip.select.value || 0);
    const source = document?.clips[which]?.path ?? clips[which]?.name ?? "clip";
    this.whichClip.row.hidden = this.saving || this.kind !== "motion" || clips.length < 2;
    const [, stem = source, ending = ""] = /^(.*?)(\.[^./\\]+)?$/u.exec(source) ?? [];
    const path = this.saving
      ? (state?.path ?? `${stem}.retime`)
      : { motion: `${stem}_retimed${ending}`, warp: `${stem}_warp.json`, picture: `${stem}_warp.svg` }[this.kind];
    this.writePath.input.value = path;
  }
}

function joined(folder: string, name: string): string {
  const between = folder.includes("\\") && !folder.includes("/") ? "\\" : "/";
  return folder === "" || folder.endsWith(between) ? `${folder}${name}` : `${folder}${between}${name}`;
}

function closeButton(dialog: HTMLDialogElement, text = "Close"): HTMLButtonElement {
  const made = make("button", { type: "button", class: "button framed" }, text);
  made.addEventListener("click", () => dialog.close());
  return made;
}

function form(title: string | HTMLElement, body: Node[], footer: Node[]): HTMLFormElement {
  const heading = typeof title === "string" ? make("h3", {}, title) : title;
  return make("form", { method: "dialog" }, make("header", {}, heading), ...body, make("footer", {}, ...footer));
}
