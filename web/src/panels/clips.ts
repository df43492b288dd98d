/** The clips of the group: what they are, whether the warp is found on them, and how they are read. */

import { addClip, changeClip, removeClip, setRole } from "../document";
import { make, setText } from "../dom";
import { icon } from "../icons";
import type { ClipFile, Document } from "../messages";
import type { Session } from "../session";
import type { Store } from "../store";
import type { Dialogs } from "./dialogs";
import { type ReadingFields, readingFields } from "./reading";
import { dot, fileName } from "./top";

interface Row {
  readonly root: HTMLElement;
  readonly name: HTMLElement;
  readonly role: HTMLSelectElement;
  readonly remove: HTMLButtonElement;
  readonly reading: ReadingFields;
  readonly fault: HTMLElement;
}

export class ClipPanel {
  readonly add: HTMLButtonElement;
  readonly body = make("div");
  private readonly rows: Row[] = [];

  constructor(
    private readonly store: Store,
    private readonly session: Session,
    private readonly dialogs: Dialogs,
  ) {
    this.add = make(
      "button",
      { type: "button", class: "button", title: "Another clip that gets the same warp: a second character, a camera" },
      icon("plus"),
      "Add",
    );
    this.add.addEventListener("click", () =>
      dialogs.showOpen({
        title: "Add a clip",
        holds: "clip",
        take: (path) => session.edit(addClip(this.document, path), "add clip"),
      }),
    );
  }

  private get document(): Document {
    return this.store.document as Document;
  }

  update(): void {
    const { clips } = this.document;
    while (this.rows.length > clips.length) this.rows.pop()?.root.remove();
    while (this.rows.length < clips.length) {
      const row = this.makeRow(this.rows.length);
      this.rows.push(row);
      this.body.append(row.root);
    }
    this.rows.forEach((row, i) => {
      const file = clips[i] as ClipFile;
      const name = this.store.clips[i]?.name ?? fileName(file.path);
      if (row.name.dataset.shown !== `${name} ${this.store.clips.length}`) {
        row.name.dataset.shown = `${name} ${this.store.clips.length}`;
        row.name.replaceChildren(...[dot(this.store.clips, i), name].filter((part) => part !== null));
      }
      row.name.title = file.path;
      row.role.value = file.role;
      row.role.setAttribute("aria-label", `Role of ${name}`);
      row.remove.setAttribute("aria-label", `Remove ${name}`);
      row.reading.update();
      const { problem } = this.store;
      row.fault.hidden = problem?.clip !== i;
      setText(row.fault, problem?.message ?? "");
    });
  }

  private makeRow(i: number): Row {
    const { store, session } = this;
    const role = make(
      "select",
      { class: "field", disabled: i === 0, title: "Whether the warp is found on it, or it only gets the warp" },
      make("option", { value: "search" }, "searched"),
      make("option", { value: "follow" }, "follows"),
    );
    role.addEventListener("change", () =>
      session.edit(setRole(this.document, i, role.value === "search" ? "search" : "follow"), "choose role of clip"),
    );
    const remove = make(
      "button",
      { type: "button", class: "button bare", title: "Remove from the group" },
      icon("trash"),
    );
    remove.addEventListener("click", () => {
      store.look({ clip: 0 });
      session.edit(removeClip(this.document, i), "remove clip");
    });
    // The first one sets the clock.
    if (i === 0) remove.style.visibility = "hidden";
    const name = make("span", { class: "clipname" });
    const fault = make("p", { class: "refused", hidden: true });
    const reading = readingFields(
      this.dialogs,
      `Clip ${i + 1}`,
      () => this.document.clips[i] as ClipFile,
      (change) => session.edit(changeClip(this.document, i, change), "change how a clip is read"),
      () => store.problem?.clip === i,
      (path) => session.edit(changeClip(this.document, i, { path }), "choose clip"),
    );
    const root = make("div", {}, make("div", { class: "cliprow" }, name, role, remove), fault, reading.root);
    return { root, name, role, remove, reading, fault };
  }
}
