/** What is imitated: the references, listed, and all that one can say about the one that is looked at. */

import { parseTime } from "../document";
import { make, setText } from "../dom";
import { icon } from "../icons";
import type { Document, ReferenceFile } from "../messages";
import {
  addReference,
  changeReference,
  referencesOf,
  removeReference,
  setCounterpart,
  setReferenceFile,
  setReferenceRange,
} from "../references";
import type { Session } from "../session";
import type { Store } from "../store";
import { frameRange, referenceNames, referenceSpan } from "../timeline/reference_span";
import type { Dialogs } from "./dialogs";
import { check, textField } from "./fields";
import { JointTable } from "./joints";
import { readingFields } from "./reading";
import { fileName } from "./top";

export class ReferencePanel {
  readonly actions: readonly HTMLElement[];
  readonly body: HTMLElement;
  private readonly rows = make("div", { role: "group", "aria-label": "References" });
  private readonly details = make("div", { class: "details" });
  private readonly updates: (() => void)[] = [];
  private shown = "";

  constructor(
    private readonly store: Store,
    private readonly session: Session,
    private readonly dialogs: Dialogs,
  ) {
    const file = button("File…", "Imitate another clip too", () =>
      this.choose("Add a reference", (path) => this.add(path)),
    );
    const itself = button("Itself", "Imitate the clip itself too, or a stretch of it", () => this.add(null));
    file.prepend(icon("plus"));
    itself.prepend(icon("plus"));
    this.actions = [file, itself];
    this.fill();
    this.body = make("div", {}, this.rows, this.details);
    // The clip itself is what is imitated already, where nothing else is.
    this.updates.push(() => (itself.hidden = this.document.references.length === 0));
  }

  update(): void {
    this.list();
    for (const update of this.updates) update();
  }

  private get document(): Document {
    return this.store.document as Document;
  }

  private get index(): number {
    return this.store.reference;
  }

  private get reference(): ReferenceFile {
    return referencesOf(this.document)[this.index] as ReferenceFile;
  }

  private add(path: string | null): void {
    const next = addReference(this.document, path);
    this.store.look({ reference: next.references.length - 1 });
    this.session.edit(next, "add reference");
  }

  private change(change: Partial<ReferenceFile>, label: string): boolean {
    this.session.edit(changeReference(this.document, this.index, change), label);
    return true;
  }

  private choose(title: string, take: (path: string) => void): void {
    this.dialogs.showOpen({ title, holds: "clip", take });
  }

  private list(): void {
    const names = referenceNames(this.store);
    const { references } = this.document;
    const faulty = this.store.problem?.reference ?? -1;
    const weights = references.map((one) => one.weight);
    const now = JSON.stringify([names, weights, this.index, faulty, references.map((one) => one.path)]);
    if (now === this.shown) return;
    this.shown = now;
    const focused = [...this.rows.children].findIndex((row) => row.contains(document.activeElement));
    this.rows.replaceChildren(
      ...names.map((name, i) => {
        const file = references[i];
        const pick = button(name, file?.path ?? "Nothing else is imitated", () => this.store.look({ reference: i }));
        pick.classList.add("pick");
        pick.setAttribute("aria-pressed", String(i === this.index));
        if (i === faulty) pick.classList.add("faulty");
        const weight = make("span", { class: "note" }, file && file.weight !== 1 ? `×${file.weight}` : "");
        const remove = make(
          "button",
          { type: "button", class: "button bare", "aria-label": `Remove ${name}`, title: "Remove this reference" },
          icon("trash"),
        );
        remove.addEventListener("click", () =>
          this.session.edit(removeReference(this.document, i), "remove reference"),
        );
        remove.hidden = !file;
        return make("div", { class: "refrow" }, pick, weight, remove);
      }),
    );
    // Who came by the keyboard stays in the list.
    if (focused >= 0) this.rows.children[Math.min(focused, names.length - 1)]?.querySelector("button")?.focus();
  }

  private fill(): void {
    const { store, session, updates } = this;
    const fault = make("p", { class: "refused", hidden: true });
    updates.push(() => {
      const { problem } = store;
      fault.hidden = problem?.reference !== this.index;
      setText(fault, problem?.message ?? "");
    });

    const choose = button("Another file…", "Imitate another clip in its place", () =>
      this.choose("Choose the reference", (path) =>
        session.edit(setReferenceFile(this.document, this.index, path), "choose reference"),
      ),
    );
    choose.classList.add("framed");
    const itself = button("The clip itself", "Imitate the clip itself in its place", () =>
      session.edit(setReferenceFile(this.document, this.index, null), "choose reference"),
    );
    itself.classList.add("framed");
    const sources = make("div", { class: "pair" }, choose, itself);
    updates.push(() => {
      // The clip itself as the only one is replaced by adding another.
      sources.hidden = this.document.references.length === 0;
      itself.hidden = this.reference.path === null;
      setText(choose, this.reference.path === null ? "A file instead…" : "Another file…");
    });

    const bound =
      (side: "start" | "end") =>
      (text: string): boolean => {
        const span = referenceSpan(store);
        const value = parseTime(text, span?.clip.rate ?? store.rate);
        if (!span || value === null) return false;
        const start = side === "start" ? value : span.start;
        const end = side === "end" ? value : span.end;
        if (start < -1e-6 || end > span.lastTime + 1e-6 || end - start < 3 / span.clip.rate) return false;
        session.edit(
          setReferenceRange(this.document, this.index, frameRange(span, start, end)),
          "choose reference range",
        );
        return true;
      };
    const from = textField(
      "From",
      "Where the imitated stretch of the reference begins: seconds, 105f, or 1:03.5",
      bound("start"),
    );
    const to = textField("To", "Where the imitated stretch of the reference ends", bound("end"));
    from.input.setAttribute("aria-label", "Reference from");
    to.input.setAttribute("aria-label", "Reference to");
    const all = button("All", "Imitate all of it", () =>
      session.edit(setReferenceRange(this.document, this.index, null), "choose reference range"),
    );
    const range = row(
      "Imitated",
      make("div", { class: "pair" }, from.input, make("span", { class: "note" }, "to"), to.input, all),
    );
    updates.push(() => {
      const span = referenceSpan(store);
      from.show(span ? span.start.toFixed(2) : "");
      to.show(span ? span.end.toFixed(2) : "");
      all.style.visibility =
        this.reference.first_frame === null && this.reference.last_frame === null ? "hidden" : "visible";
    });

    const weight = textField(
      "Weight",
      "How many times nearer it looks than it is: 2 is imitated rather than the others",
      (text) => {
        const value = Number(text.replace(/[×x]$/u, ""));
        return Number.isFinite(value) && value > 0 && this.change({ weight: value }, "set reference weight");
      },
    );
    updates.push(() => {
      // Of one alone the weight changes nothing.
      weight.row.hidden = this.document.references.length < 2 && this.reference.weight === 1;
      weight.show(String(this.reference.weight));
    });

    const mirror = check(
      "Its mirror image too",
      "Imitate left as right too",
      (on) => void this.change({ mirror: on }, "choose reference"),
    );
    updates.push(() => mirror.show(this.reference.mirror));

    const table = new JointTable(store, session, this.dialogs);
    const joints = button("", "Which of its joints stands for which of the clip's", () => table.show());
    joints.classList.add("framed", "wide");
    const jointRow = row("Joints", joints);
    updates.push(() => {
      setText(jointRow.firstElementChild as Element, store.clip?.holds === "signal" ? "Channels" : "Joints");
      const clip = store.references[this.index];
      jointRow.hidden = this.reference.path === null;
      const own = clip?.counterparts ?? [];
      const matched =
        own.length === 0 ? "Matched by name" : `${own.filter((name) => name !== "").length} of ${own.length} matched`;
      setText(joints, matched);
      joints.setAttribute("aria-label", `${jointRow.firstElementChild?.textContent ?? ""}: ${matched}`);
      table.update();
    });

    const beside = make("div");
    let besideShown = "";
    updates.push(() => {
      const { clips } = this.document;
      const wanted =
        this.reference.path === null
          ? []
          : clips.map((clip, i) => ({ clip, i })).filter(({ clip, i }) => i > 0 && clip.role === "search");
      const now = JSON.stringify([wanted, this.reference.counterparts, store.clips.map((clip) => clip.name)]);
      if (now === besideShown) return;
      besideShown = now;
      beside.replaceChildren(
        ...wanted.map(({ clip, i }) => {
          const name = store.clips[i]?.name ?? fileName(clip.path);
          const there = this.reference.counterparts.find((one) => one.clip === i);
          const pick = button(
            there ? fileName(there.path) : "Choose a file…",
            there?.path ?? `What ${name} is to move like`,
            () =>
              this.choose(`What ${name} is to move like`, (path) =>
                session.edit(setCounterpart(this.document, this.index, i, path), "choose reference"),
              ),
          );
          pick.classList.add("framed", "wide");
          pick.setAttribute(
            "aria-label",
            `What ${name} is to move like: ${there ? fileName(there.path) : "choose a file"}`,
          );
          return row(`For ${name}`, pick);
        }),
      );
    });

    const reading = readingFields(
      this.dialogs,
      "Reference",
      () => this.reference,
      (change) => void this.change(change, "change reference"),
      () => store.problem?.reference === this.index,
    );
    updates.push(() => {
      reading.root.hidden = this.reference.path === null;
      reading.update();
    });
    this.details.append(fault, sources, range, weight.row, mirror.row, jointRow, beside, reading.root);
  }
}

function button(text: string, title: string, action: () => void): HTMLButtonElement {
  const made = make("button", { type: "button", class: "button", title }, text);
  made.addEventListener("click", action);
  return made;
}

function row(label: string, ...content: HTMLElement[]): HTMLElement {
  return make("div", { class: "row" }, make("span", { class: "label", title: label }, label), ...content);
}
