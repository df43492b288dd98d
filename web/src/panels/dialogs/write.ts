/** Writing a file: the project, or what comes of it. */

import type { Connection } from "../../connection";
import { make, setText } from "../../dom";
import type { Found } from "../../messages";
import type { Store } from "../../store";
import { check, choice, textField } from "../fields";
import { closeButton, form, makeDialog, onSubmit, Refusal } from "./dialog";

type Export = "motion" | "warp" | "picture";

export class WriteDialog {
  readonly root = makeDialog("Write");
  private readonly title = make("h3", {}, "Save project");
  private readonly what = choice<Export>("What", "What to write", () => this.suggest());
  private readonly clip = choice<string>("Clip", "Of a group: which clip", () => this.suggest());
  private readonly path = textField("Path", "The name's ending says in which format", () => true);
  private readonly refusal = new Refusal();
  private readonly overwrite = check("Replace the file if it is there", "", (on) => (this.mayOverwrite = on));
  private mayOverwrite = false;
  private saving = true;

  constructor(
    private readonly store: Store,
    private readonly connection: Connection,
  ) {
    const go = make("button", { type: "submit", class: "button main" }, "Write");
    const body = form(
      this.title,
      [this.what.row, this.clip.row, this.path.row, this.refusal.root, this.overwrite.row],
      [closeButton(this.root, "Cancel"), go],
    );
    onSubmit(body, () => this.submit());
    this.root.append(body);
  }

  /** Ask where to save the project, or where to export what. */
  show(saving: boolean): void {
    this.saving = saving;
    const title = saving ? "Save project" : "Export";
    setText(this.title, title);
    this.root.setAttribute("aria-label", title);
    this.what.row.hidden = saving;
    this.what.show(
      [
        { value: "motion", text: "Motion, retimed" },
        { value: "warp", text: "Warp (JSON)" },
        { value: "picture", text: "Picture of the warp (SVG, PNG, PDF)" },
      ],
      this.kind || "motion",
    );
    this.clip.show(
      this.store.clips.map((clip, i) => ({ value: String(i), text: clip.name })),
      String(this.store.view.clip),
    );
    this.mayOverwrite = false;
    this.refusal.say(null);
    this.overwrite.show(false);
    this.suggest();
    this.root.showModal();
    this.path.input.focus();
    this.path.input.select();
  }

  /** The server says whether a file that was named may be written, and whether it is there already. */
  found({ path, place, refused: reason, exists }: Found): void {
    if (!this.root.open || this.path.input.value.trim() !== path) return;
    const inTheWay = exists && !this.mayOverwrite && place !== this.store.state?.path;
    const there = "This file is there already: choose another name, or tick the box to replace it.";
    const refused = reason ?? (inTheWay ? there : null);
    this.refusal.say(refused);
    if (refused !== null) return;
    this.root.close();
    if (this.saving) this.connection.save(place, this.mayOverwrite);
    else this.connection.export(this.kind, place, this.which, this.mayOverwrite);
  }

  private get kind(): Export {
    return this.what.select.value as Export;
  }

  /** The place of the clip that is exported. */
  private get which(): number {
    return Number(this.clip.select.value || 0);
  }

  private submit(): void {
    const { input } = this.path;
    const path = input.value.trim();
    if (path === "") {
      input.focus();
      return;
    }
    input.value = this.saving && !/\.retime$/iu.test(path) ? `${path}.retime` : path;
    this.connection.find(input.value, true);
  }

  /** Suggest a path that says what is in it, beside the clip or the project. */
  private suggest(): void {
    const { state, document, clips } = this.store;
    const which = this.saving ? 0 : this.which;
    const source = document?.clips[which]?.path ?? clips[which]?.name ?? "clip";
    this.clip.row.hidden = this.saving || this.kind !== "motion" || clips.length < 2;
    const [, stem = source, ending = ""] = /^(.*?)(\.[^./\\]+)?$/u.exec(source) ?? [];
    this.path.input.value = this.saving
      ? (state?.path ?? `${stem}.retime`)
      : { motion: `${stem}_retimed${ending}`, warp: `${stem}_warp.json`, picture: `${stem}_warp.svg` }[this.kind];
  }
}
