/** The clips of the group: what they are, whether the warp is found on them, and how they are read. */

import type { Connection } from "../../connection";
import { addClip, changeClip, removeClip, setRole } from "../../document";
import { make, setText } from "../../dom";
import type { ClipFile, Document } from "../../messages";
import type { Store } from "../../store";
import { button, iconButton } from "../buttons";
import type { Dialogs } from "../dialogs/dialogs";
import { dot, fileName } from "../top";
import { LengthNotes } from "./lengths";
import { type ReadingFields, readingFields } from "./reading";
import { documentOf, frame, type Section, type Side } from "./section";
import { TrimRow } from "./trim_row";

interface Row {
  readonly root: HTMLElement;
  readonly name: HTMLElement;
  readonly role: HTMLSelectElement;
  readonly remove: HTMLButtonElement;
  readonly reading: ReadingFields;
  readonly trim: TrimRow;
  readonly fault: HTMLElement;
}

export function clipsSection(side: Side): Section {
  const { store, connection, dialogs } = side;
  const add = button(
    "Add",
    "Another clip that gets the same warp: a second character, a camera",
    () =>
      dialogs.showOpen({
        title: "Add a clip",
        holds: "clip",
        take: (path) => connection.edit(addClip(documentOf(store), path), "add clip"),
      }),
    "plus",
  );
  const { root, body } = frame("Clips", add);
  const rows = new ClipRows(body, store, connection, dialogs);
  const lengths = new LengthNotes(side);
  root.append(lengths.root);
  return {
    root,
    update() {
      rows.update();
      lengths.update();
    },
  };
}

/** A row for each clip of the group. */
class ClipRows {
  private readonly rows: Row[] = [];

  constructor(
    private readonly body: HTMLElement,
    private readonly store: Store,
    private readonly connection: Connection,
    private readonly dialogs: Dialogs,
  ) {}

  private get document(): Document {
    return documentOf(this.store);
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
      row.trim.update();
      const { problem } = this.store;
      row.fault.hidden = problem?.clip !== i;
      setText(row.fault, problem?.message ?? "");
    });
  }

  private makeRow(i: number): Row {
    const { store, connection } = this;
    const role = make(
      "select",
      {
        class: "field",
        disabled: i === 0,
        title: "Searched: it has a say in the timing. Follows: it only gets the timing",
      },
      make("option", { value: "search" }, "searched"),
      make("option", { value: "follow" }, "follows"),
    );
    role.addEventListener("change", () =>
      connection.edit(setRole(this.document, i, role.value === "search" ? "search" : "follow"), "choose role of clip"),
    );
    const remove = iconButton("trash", "Remove from the group", () => {
      store.look({ clip: 0 });
      connection.edit(removeClip(this.document, i), "remove clip");
    });
    // The first one sets the clock.
    if (i === 0) remove.style.visibility = "hidden";
    const name = make("span", { class: "clipname" });
    const fault = make("p", { class: "refused", hidden: true });
    const reading = readingFields(
      this.dialogs,
      `Clip ${i + 1}`,
      () => this.document.clips[i] as ClipFile,
      (change) => connection.edit(changeClip(this.document, i, change), "change how a clip is read"),
      () => store.problem?.clip === i,
      (path) => connection.edit(changeClip(this.document, i, { path }), "choose clip"),
      i > 0 ? () => store.clips[0]?.rate ?? 30 : undefined,
    );
    const trim = new TrimRow({ store, connection }, i);
    reading.root.querySelector("summary")?.after(trim.root);
    const root = make("div", {}, make("div", { class: "cliprow" }, name, role, remove), fault, reading.root);
    return { root, name, role, remove, reading, trim, fault };
  }
}
