/** Which joint (or channel) of a reference stands for which of the clip's: a table, and a file that says the same. */

import type { Connection } from "../../connection";
import { make, setText } from "../../dom";
import type { Clip, Document, ReferenceFile } from "../../messages";
import { changeReference, referencesOf, setJoint } from "../../references";
import type { Store } from "../../store";
import { makeDialog } from "../dialogs/dialog";
import type { Dialogs } from "../dialogs/dialogs";
import { fileName } from "../top";

interface Row {
  readonly root: HTMLElement;
  readonly select: HTMLSelectElement;
}

export class JointTable {
  private readonly dialog = makeDialog("Joints");
  private readonly title = make("h3", { tabindex: -1 });
  private readonly note = make("p", { class: "note", "aria-live": "polite" });
  private readonly fault = make("p", { class: "refused", role: "alert", hidden: true });
  private readonly list = make("div", { class: "joints" });
  private readonly file = make("button", { type: "button", class: "button framed" });
  private readonly noFile = make("button", { type: "button", class: "button framed" }, "Without the file");
  private readonly plain = make(
    "button",
    { type: "button", class: "button framed", title: "Take back what the table says" },
    "As the names say",
  );
  private rows = new Map<string, Row>();
  private made = "";

  constructor(
    private readonly store: Store,
    private readonly connection: Connection,
    dialogs: Dialogs,
  ) {
    const close = make("button", { type: "submit", class: "button main" }, "Done");
    this.file.addEventListener("click", () =>
      dialogs.showOpen({
        title: "Choose a joint map (JSON or CSV)",
        holds: "joint map",
        take: (path) => this.change({ joint_map: path }),
      }),
    );
    this.noFile.addEventListener("click", () => this.change({ joint_map: null }));
    this.plain.addEventListener("click", () => this.change({ joints: [] }));
    const gap = make("span", { class: "gap" });
    const form = make(
      "form",
      { method: "dialog" },
      make("header", {}, this.title),
      this.note,
      this.fault,
      this.list,
      make("footer", {}, this.file, this.noFile, gap, this.plain, close),
    );
    this.dialog.append(form);
    dialogs.add(this.dialog);
  }

  show(): void {
    this.dialog.showModal();
    this.update();
    this.title.focus();
  }

  update(): void {
    if (!this.dialog.open || !this.store.document) return;
    const { clip, references, problem } = this.store;
    const reference = references[this.store.reference];
    const file = this.reference;
    if (!clip || !reference || !file) return;
    const parts = clip.holds === "signal" ? "Channels" : "Joints";
    setText(this.title, `${parts} of ${reference.name} that stand for those of ${clip.name}`);
    this.dialog.setAttribute("aria-label", this.title.textContent ?? "Joints");
    const own = clip.names.slice(0, reference.counterparts.length);
    const matched = reference.counterparts.filter((name) => name !== "").length;
    const without = clip.holds === "signal" ? "Each channel needs one." : "Joints without one are not compared.";
    setText(this.note, `${matched} of ${own.length} have a counterpart. ${without}`);
    this.fault.hidden = problem?.reference !== this.store.reference;
    setText(this.fault, problem?.message ?? "");
    setText(this.file, file.joint_map === null ? "From a file…" : fileName(file.joint_map));
    this.file.title = file.joint_map ?? "A file that says which is which: JSON, or CSV with two columns";
    this.noFile.hidden = file.joint_map === null;
    this.plain.hidden = file.joints.length === 0;
    this.build(own, reference);
    own.forEach((name, i) => {
      const row = this.rows.get(name);
      if (!row) return;
      const said = file.joints.find((pair) => pair.input === name)?.reference;
      const found = reference.counterparts[i] ?? "";
      const first = row.select.options[0];
      if (first)
        first.text =
          said === undefined
            ? found === ""
              ? "none"
              : `${found}, by ${file.joint_map === null ? "name" : "name or file"}`
            : "as the names say";
      row.select.value = said ?? "";
      row.root.dataset.is = said !== undefined ? "said" : found === "" ? "none" : "found";
    });
  }

  private get reference(): ReferenceFile | undefined {
    return referencesOf(this.store.document as Document)[this.store.reference];
  }

  private change(change: Partial<ReferenceFile>): void {
    this.connection.edit(
      changeReference(this.store.document as Document, this.store.reference, change),
      "change joint map",
    );
  }

  /** Make the rows once for each pair of skeletons: an open list of choices stays open when an answer arrives. */
  private build(own: readonly string[], reference: Clip): void {
    const names = jointsOf(reference);
    const now = JSON.stringify([own, names]);
    if (now === this.made) return;
    this.made = now;
    this.rows = new Map(
      own.map((name) => {
        const select = make(
          "select",
          { class: "field", "aria-label": `Stands for ${name}` },
          make("option", { value: "" }, ""),
        );
        select.append(...names.map((other) => make("option", { value: other }, other)));
        select.addEventListener("change", () =>
          this.connection.edit(
            setJoint(
              this.store.document as Document,
              this.store.reference,
              name,
              select.value === "" ? null : select.value,
            ),
            "change joint map",
          ),
        );
        return [name, { root: make("label", { class: "row" }, make("span", { title: name }, name), select), select }];
      }),
    );
    this.list.replaceChildren(...[...this.rows.values()].map((row) => row.root));
  }
}

/** The joints of a motion, without the ends of its limbs; the channels of a signal. */
export function jointsOf(clip: Clip): string[] {
  return clip.names.filter((name) => !name.startsWith("end of "));
}
