/** All that one can say about one reference: its file, its stretch, its weight, its joints. */

import type { Connection } from "../../connection";
import { make, setText } from "../../dom";
import { GrammarError, parseNumber, parseTime } from "../../grammar";
import type { Document, ReferenceFile } from "../../messages";
import { changeReference, referencesOf, setCounterpart, setReferenceFile, setReferenceRange } from "../../references";
import { clamp } from "../../scale";
import type { Store } from "../../store";
import { frameRange, referenceSpan } from "../../timeline/reference_span";
import { fieldTime, saidTime, unitsOf } from "../../units";
import { button } from "../buttons";
import type { Dialogs } from "../dialogs/dialogs";
import { check, textField } from "../fields";
import { type Scrub, valueScrub } from "../scrub";
import { fileName } from "../top";
import { JointTable } from "./joints";
import { readingFields } from "./reading";
import { documentOf, row } from "./section";

/** A part of the details, and how it shows the reference that is looked at. */
interface Part {
  readonly root: HTMLElement;
  update(): void;
}

export class ReferenceDetails {
  readonly root: HTMLElement;
  private readonly parts: readonly Part[];

  constructor(
    private readonly store: Store,
    private readonly connection: Connection,
    private readonly dialogs: Dialogs,
  ) {
    this.parts = [
      this.fault(),
      this.file(),
      this.range(),
      this.weight(),
      this.mirror(),
      this.joints(),
      this.counterparts(),
      this.reading(),
    ];
    this.root = make("div", { class: "details" }, ...this.parts.map((part) => part.root));
  }

  update(): void {
    for (const part of this.parts) part.update();
  }

  private get document(): Document {
    return documentOf(this.store);
  }

  private get index(): number {
    return this.store.reference;
  }

  private get reference(): ReferenceFile {
    return referencesOf(this.document)[this.index] as ReferenceFile;
  }

  private edit(document: Document, label: string): void {
    this.connection.edit(document, label);
  }

  private change(change: Partial<ReferenceFile>, label: string): void {
    this.edit(changeReference(this.document, this.index, change), label);
  }

  private choose(title: string, take: (path: string) => void): void {
    this.dialogs.showOpen({ title, holds: "clip", take });
  }

  private fault(): Part {
    const { store } = this;
    const root = make("p", { class: "refused", hidden: true });
    return {
      root,
      update: () => {
        root.hidden = store.problem?.reference !== this.index;
        setText(root, store.problem?.message ?? "");
      },
    };
  }

  private file(): Part {
    const replace = (path: string | null): void =>
      this.edit(setReferenceFile(this.document, this.index, path), "choose reference");
    const other = button("Another file…", "Imitate another clip in its place", () =>
      this.choose("Choose the reference", replace),
    );
    const itself = button("The clip itself", "Imitate the clip itself in its place", () => replace(null));
    other.classList.add("framed");
    itself.classList.add("framed");
    const root = make("div", { class: "pair" }, other, itself);
    return {
      root,
      update: () => {
        // The clip itself as the only one is replaced by adding another.
        root.hidden = this.document.references.length === 0;
        itself.hidden = this.reference.path === null;
        setText(other, this.reference.path === null ? "A file instead…" : "Another file…");
      },
    };
  }

  private range(): Part {
    const { store } = this;
    const bound =
      (side: "start" | "end") =>
      (text: string): boolean => {
        const span = referenceSpan(store);
        if (!span) return false;
        const value = parseTime(text, span.clip.rate);
        const start = side === "start" ? value : span.start;
        const end = side === "end" ? value : span.end;
        if (start < -1e-6 || end > span.lastTime + 1e-6 || end - start < 3 / span.clip.rate) {
          const last = saidTime(span.lastTime, span.clip.rate, unitsOf(store));
          throw new GrammarError(`expected a stretch of 4 frames or more, from 0 to ${last}, found '${text}'`);
        }
        const range = frameRange(span, start, end);
        this.edit(setReferenceRange(this.document, this.index, range), "choose reference range");
        return true;
      };
    const hint = "Where the imitated stretch of the reference begins: seconds, 105f, or 1:03.5";
    const drag = (side: "start" | "end"): Scrub =>
      valueScrub({ store, connection: this.connection }, "choose reference range", (before) => {
        const span = referenceSpan(store);
        if (!span) return () => before;
        const { index } = this;
        const { rate } = span.clip;
        return (steps) => {
          const time = span[side] + steps / rate;
          const start = side === "start" ? clamp(time, 0, span.end - 3 / rate) : span.start;
          const end = side === "end" ? clamp(time, span.start + 3 / rate, span.lastTime) : span.end;
          return setReferenceRange(before, index, frameRange(span, start, end));
        };
      });
    const from = textField("From", hint, bound("start"), drag("start"));
    const to = textField("To", "Where the imitated stretch of the reference ends", bound("end"), drag("end"));
    from.input.setAttribute("aria-label", "Reference from");
    to.input.setAttribute("aria-label", "Reference to");
    const all = button("All", "Imitate all of it", () =>
      this.edit(setReferenceRange(this.document, this.index, null), "choose reference range"),
    );
    const pair = make("div", { class: "pair" }, from.input, make("span", { class: "note" }, "to"), to.input, all);
    return {
      root: row("Imitated", pair, from.trouble, to.trouble),
      update: () => {
        const span = referenceSpan(store);
        const { first_frame, last_frame } = this.reference;
        from.show(span ? fieldTime(span.start, span.clip.rate, unitsOf(store), 2) : "");
        to.show(span ? fieldTime(span.end, span.clip.rate, unitsOf(store), 2) : "");
        all.style.visibility = first_frame === null && last_frame === null ? "hidden" : "visible";
      },
    };
  }

  private weight(): Part {
    const hint = "How much it counts beside the others: 2 makes its poses look twice as near";
    const commit = (text: string): boolean => {
      this.change({ weight: parseNumber(text, { above: true, unit: "x" }) }, "set reference weight");
      return true;
    };
    const drag = valueScrub({ store: this.store, connection: this.connection }, "set reference weight", (before) => {
      const { index } = this;
      const { weight } = this.reference;
      return (steps) => {
        const next = Math.max(0.05, Number((weight + steps / 20).toFixed(2)));
        return changeReference(before, index, { weight: next });
      };
    });
    const weight = textField("Weight", hint, commit, drag);
    return {
      root: weight.row,
      update: () => {
        // Of one alone the weight changes nothing.
        weight.row.hidden = this.document.references.length < 2 && this.reference.weight === 1;
        weight.show(String(this.reference.weight));
      },
    };
  }

  private mirror(): Part {
    const mirror = check("Its mirror image too", "Imitate left as right too", (on) =>
      this.change({ mirror: on }, "choose reference"),
    );
    return { root: mirror.row, update: () => mirror.show(this.reference.mirror) };
  }

  private joints(): Part {
    const { store } = this;
    const table = new JointTable(store, this.connection, this.dialogs);
    const open = button("", "Which of its joints stands for which of the clip's", () => table.show());
    open.classList.add("framed", "wide");
    const root = row("Joints", open);
    return {
      root,
      update: () => {
        const what = store.clip?.holds === "signal" ? "Channels" : "Joints";
        setText(root.firstElementChild as Element, what);
        root.hidden = this.reference.path === null;
        const own = store.references[this.index]?.counterparts ?? [];
        const matched = `${own.filter((name) => name !== "").length} of ${own.length} matched`;
        setText(open, own.length === 0 ? "Matched by name" : matched);
        open.setAttribute("aria-label", `${what}: ${open.textContent}`);
        table.update();
      },
    };
  }

  /** For a group: what each of the other clips that are searched moves like. */
  private counterparts(): Part {
    const { store } = this;
    const root = make("div");
    let shown = "";
    return {
      root,
      update: () => {
        const { path, counterparts } = this.reference;
        const others = this.document.clips.map((clip, i) => ({ clip, i })).slice(1);
        const wanted = path === null ? [] : others.filter(({ clip }) => clip.role === "search");
        const now = JSON.stringify([wanted, counterparts, store.clips.map((clip) => clip.name)]);
        if (now === shown) return;
        shown = now;
        root.replaceChildren(
          ...wanted.map(({ clip, i }) => this.counterpart(store.clips[i]?.name ?? fileName(clip.path), i)),
        );
      },
    };
  }

  private counterpart(name: string, clip: number): HTMLElement {
    const there = this.reference.counterparts.find((one) => one.clip === clip);
    const title = `What ${name} is to move like`;
    const pick = button(there ? fileName(there.path) : "Choose a file…", there?.path ?? title, () =>
      this.choose(title, (path) =>
        this.edit(setCounterpart(this.document, this.index, clip, path), "choose reference"),
      ),
    );
    pick.classList.add("framed", "wide");
    pick.setAttribute("aria-label", `${title}: ${there ? fileName(there.path) : "choose a file"}`);
    return row(`For ${name}`, pick);
  }

  private reading(): Part {
    const reading = readingFields(
      this.dialogs,
      "Reference",
      () => this.reference,
      (change) => this.change(change, "change reference"),
      () => this.store.problem?.reference === this.index,
    );
    return {
      root: reading.root,
      update: () => {
        reading.root.hidden = this.reference.path === null;
        reading.update();
      },
    };
  }
}
