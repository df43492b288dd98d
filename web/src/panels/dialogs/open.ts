/** Choosing a file: a document to open, or one that is wanted for something else. */

import type { Connection } from "../../connection";
import { make, setText } from "../../dom";
import { type IconName, icon } from "../../icons";
import type { Browse, Found, Listing, Refused } from "../../messages";
import type { TakeFiles } from "../../shell/files";
import { textField } from "../fields";
import { closeButton, form, makeDialog, onSubmit, Refusal } from "./dialog";

/** What a file is wanted for. */
export interface Wanted {
  readonly title: string;
  readonly holds: Browse["holds"];
  /** It is opened in the place of the document, and refused then where it can't be read. */
  readonly opens?: boolean;
  take(path: string): void;
}

export class OpenDialog {
  readonly root = makeDialog("Open");
  private readonly title = make("h3", {}, "Open");
  private readonly folder = make("p", { class: "note" });
  private readonly files = make("ul", { class: "files", "aria-label": "Files" });
  private readonly path = textField("Path", "As your system writes it", () => true);
  private readonly refusal = new Refusal();
  private wanted: Wanted;
  private listing: Listing | null = null;
  /** What was chosen last. */
  private asked: string | null = null;
  private readonly go = make("button", { type: "submit", class: "button main" });

  /** `send` sends files that are picked to the server; null where that can't be done. */
  constructor(
    private readonly connection: Connection,
    send: TakeFiles | null,
  ) {
    this.wanted = this.document();
    const body = form(
      this.title,
      [this.folder, this.files, this.path.row, this.refusal.root],
      [...(send ? this.fromElsewhere(send) : []), closeButton(this.root, "Cancel"), this.go],
    );
    onSubmit(body, () => {
      const path = this.path.input.value.trim();
      if (path !== "") this.ask(path);
    });
    this.root.append(body);
  }

  show(wanted = this.document()): void {
    this.wanted = wanted;
    this.asked = null;
    setText(this.title, wanted.title);
    this.root.setAttribute("aria-label", wanted.title);
    this.path.input.value = "";
    this.refusal.say(null);
    this.stopWaiting();
    this.root.showModal();
    this.connection.browse(this.listing?.folder ?? null, wanted.holds);
  }

  /** The server has listed a folder. */
  list(listing: Listing): void {
    this.listing = listing;
    const { folder, parent, folders, files } = listing;
    setText(this.folder, folder);
    const entry = (name: string, kind: IconName, action: () => void): HTMLElement => {
      const made = make("button", { type: "button", class: "button" }, icon(kind), name);
      made.addEventListener("click", action);
      return make("li", {}, made);
    };
    const browse = (place: string): void => this.connection.browse(place, this.wanted.holds);
    this.files.replaceChildren(
      ...(parent === null ? [] : [entry("..", "up", () => browse(parent))]),
      ...folders.map((name) => entry(name, "folder", () => browse(joined(folder, name)))),
      ...files.map((name) => entry(name, "file", () => this.ask(joined(folder, name)))),
    );
  }

  /** The server says whether a file that was named may be used. */
  found({ path, place, refused }: Found): void {
    if (!this.root.open || this.path.input.value.trim() !== path) return;
    this.stopWaiting();
    this.refusal.say(refused);
    if (refused !== null) return;
    this.root.close();
    this.asked = place;
    this.wanted.take(place);
  }

  /** The server could not open what was chosen here: the dialog is there again, with the path; false: it was not. */
  refused({ path, reason }: Refused): boolean {
    if (this.asked !== path || this.root.open) return false;
    this.asked = null;
    this.refusal.say(reason);
    this.root.showModal();
    return true;
  }

  /** Nothing is read any more. */
  stopWaiting(): void {
    setText(this.go, "Open");
  }

  private document(): Wanted {
    return { title: "Open", holds: "clip", opens: true, take: (path) => this.connection.open(path) };
  }

  /** Ask for a file; it is used once the server has said that it may be, and of a clip, that it can be read. */
  private ask(path: string): void {
    this.path.input.value = path;
    const asClip = this.wanted.holds === "clip" && !this.wanted.opens;
    if (asClip) {
      this.refusal.say(null);
      setText(this.go, "Reading…");
    }
    this.connection.find(path, { asClip });
  }

  private fromElsewhere(send: TakeFiles): HTMLElement[] {
    const picker = make("input", { type: "file", multiple: true, hidden: true });
    picker.addEventListener("change", () => {
      this.root.close();
      const { wanted } = this;
      send([...(picker.files ?? [])], wanted.opens ? undefined : wanted);
      picker.value = "";
    });
    const elsewhere = make("button", { type: "button", class: "button framed" }, "From elsewhere…");
    elsewhere.addEventListener("click", () => picker.click());
    return [elsewhere, picker, make("span", { class: "gap" })];
  }
}

function joined(folder: string, name: string): string {
  const between = folder.includes("\\") && !folder.includes("/") ? "\\" : "/";
  return folder === "" || folder.endsWith(between) ? `${folder}${name}` : `${folder}${between}${name}`;
}
