/** The side: everything that can be typed. */

import {
  addLock,
  changeKey,
  changeLock,
  deleteKey,
  deleteLock,
  findKey,
  keysInOrder,
  lengthText,
  parseLength,
  parseRate,
  parseSpeed,
  parseTime,
  rateValue,
  setLength,
  setOption,
} from "../document";
import { make, setText } from "../dom";
import { icon } from "../icons";
import type { Document } from "../messages";
import { clamp } from "../scale";
import type { Session } from "../session";
import type { Companion, Store, Topic } from "../store";
import { speedAt } from "../warp";
import { ClipPanel } from "./clips";
import type { Dialogs } from "./dialogs";
import { check, choice, type Field, slider, textField } from "./fields";
import { ReferencePanel } from "./references";

/** Hz. */
const FASTEST_ANALYSIS = 240;

type NumberName = "time_scale" | "low_pass" | "n_neighbors" | "max_skip" | "upsample" | "smoothing";

interface NumberOption {
  readonly name: NumberName;
  readonly label: string;
  readonly hint: string;
  /** What holds where nothing is given. */
  readonly usual: string;
  readonly least: number;
  readonly whole: boolean;
}

/** Numbers of the search that few people need. */
const NUMBERS: readonly NumberOption[] = [
  {
    name: "time_scale",
    label: "Time scale",
    hint: "How much velocity weighs against pose, seconds",
    usual: "0.2 s",
    least: 0,
    whole: false,
  },
  {
    name: "low_pass",
    label: "Low-pass",
    hint: "Cutoff of the filter that the search looks through, Hz; 0 is off",
    usual: "4 Hz",
    least: 0,
    whole: false,
  },
  {
    name: "n_neighbors",
    label: "Neighbours",
    hint: "Reference frames averaged in a score",
    usual: "3",
    least: 1,
    whole: true,
  },
  {
    name: "max_skip",
    label: "Longest skip",
    hint: "max_skip: the largest step between frames that the search may take",
    usual: "as needed",
    least: 1,
    whole: true,
  },
  {
    name: "upsample",
    label: "Upsampling",
    hint: "upsample: frames offered for each one of the input, so that it may be slowed down to one part in so many",
    usual: "as needed",
    least: 1,
    whole: true,
  },
  {
    name: "smoothing",
    label: "Smoothing",
    hint: "Output frames, at the analysis rate, averaged to smooth the steps; 0 is off",
    usual: "5",
    least: 0,
    whole: true,
  },
];

export class Inspector {
  readonly root = make("div", { class: "sections" });
  private readonly fields = new Map<string, Field>();
  private readonly sections: readonly ((changed: Set<Topic>) => void)[];

  constructor(
    private readonly store: Store,
    private readonly session: Session,
    private readonly dialogs: Dialogs,
  ) {
    this.sections = [
      this.keySection(),
      this.timingSection(),
      this.lockSection(),
      this.referenceSection(),
      this.compareSection(),
      this.clipSection(),
      this.searchSection(),
    ];
  }

  update(changed: Set<Topic>): void {
    if (!this.store.document) return;
    if (!["document", "curve", "selection", "clips", "view"].some((topic) => changed.has(topic as Topic))) return;
    for (const show of this.sections) show(changed);
    const { problem } = this.store;
    for (const [name, field] of this.fields) field.blame(problem?.field === name ? problem.message : null);
  }

  /** Note a field by its name in the document, to say beside it what is wrong with it. */
  private named(name: string, field: Field): Field {
    this.fields.set(name, field);
    return field;
  }

  private get document(): Document {
    return this.store.document as Document;
  }

  private section(title: string, ...actions: HTMLElement[]): { body: HTMLElement; title: HTMLElement } {
    const heading = make("h2", {}, title);
    const body = make("div");
    const end = make("span", { class: "pair" }, ...actions);
    this.root.append(make("section", { "aria-label": title }, make("header", {}, heading, end), body));
    return { body, title: heading };
  }

  private keySection(): () => void {
    const { store, session } = this;
    const selected = (): ReturnType<typeof findKey> =>
      store.selection?.kind === "key" ? findKey(this.document, store.selection.id) : null;
    const change = (part: Parameters<typeof changeKey>[2], label: string): boolean => {
      const key = selected();
      if (key) session.edit(changeKey(this.document, key.id, part), label);
      return key !== null;
    };
    const remove = make(
      "button",
      { type: "button", class: "button bare", "aria-label": "Delete keytime", title: "Delete keytime (Delete)" },
      icon("trash"),
    );
    remove.addEventListener("click", () => {
      const key = selected();
      if (!key) return;
      session.edit(deleteKey(this.document, key.id), "delete key");
      store.select(null);
    });
    const { body, title } = this.section("Keytime", remove);
    const time = (text: string): number | null => parseTime(text, store.rate);
    const output = textField("Output at", "Seconds, 105f, or 1:03.5", (text) => {
      const value = time(text);
      return value !== null && change({ output_time: value }, "move key");
    });
    const input = textField("Shows input", "Seconds, 150f, or 1:03.5", (text) => {
      const value = time(text);
      return value !== null && change({ input_time: value }, "move key");
    });
    const speed = textField("Speed", "A tangent: 1, 0.5, 1/2 or 50%. Empty: whatever comes", (text) => {
      if (text === "" || text === "free") return change({ speed: null }, "free speed at key");
      const value = parseSpeed(text);
      return value !== null && change({ speed: value }, "set speed at key");
    });
    speed.input.placeholder = "free";
    const note = make("p", { class: "note" });
    const fields = make("div", {}, output.row, input.row, speed.row);
    body.append(fields, note);
    return () => {
      const key = selected();
      fields.hidden = key === null;
      note.hidden = key !== null;
      remove.hidden = key === null;
      if (key) {
        const place = keysInOrder(this.document).findIndex((one) => one.id === key.id);
        setText(title, `Keytime ${place + 1} of ${this.document.keys.length}`);
        output.show(key.output_time.toFixed(3));
        input.show(key.input_time.toFixed(3));
        speed.show(key.speed === null ? "" : String(key.speed));
        speed.input.placeholder = store.knots
          ? `free, ${speedAt(store.knots, key.output_time).toFixed(2)} now`
          : "free";
      } else {
        setText(title, "Keytime");
        setText(
          note,
          this.document.keys.length > 0
            ? "Click a keytime to type its times."
            : "Press I to put one at the playhead, or double-click the map.",
        );
      }
    };
  }

  private timingSection(): () => void {
    const { store, session } = this;
    const { body } = this.section("Timing");
    const length = textField(
      "Length",
      "65%, 9.3s, 280f or free. Empty: after the last keytime the input plays on",
      (text) => {
        const written = text === "" || text.toLowerCase() === "free" ? text.toLowerCase() : parseLength(text);
        if (written === null) return false;
        session.edit(setLength(this.document, written === "" ? null : written), "set length");
        return true;
      },
    );
    length.input.placeholder = "as the keys say";
    const bound = (name: "min_length" | "max_length", label: string, hint: string): Field => {
      const field = textField(label, hint, (text) => {
        const written = text === "" ? null : parseLength(text);
        if (text !== "" && written === null) return false;
        session.edit({ ...this.document, [name]: written }, "bound length");
        return true;
      });
      field.input.placeholder = "no bound";
      return this.named(name, field);
    };
    const least = bound(
      "min_length",
      "At least",
      "The free length is no shorter than this: 65%, 9.3s, 280f. Empty: no bound",
    );
    const most = bound(
      "max_length",
      "At most",
      "The free length is no longer than this: 65%, 9.3s, 280f. Empty: no bound",
    );
    const weighed = choice<"neutral" | "sum">("Weighed", "How a free length weighs frames", (value) =>
      session.edit({ ...this.document, free_weight: value }, "weigh free length"),
    );
    let gesture = "";
    const slide =
      (apply: (value: number) => Document, label: string) =>
      (value: number, done: boolean): void => {
        gesture ||= session.newGesture();
        session.edit(apply(value), label, gesture, done);
        if (done) gesture = "";
      };
    const influence = slider(
      "Influence",
      "0 is the spline through the keytimes, 1 the guided warp",
      { min: 0, max: 1, step: 0.01 },
      slide((value) => ({ ...this.document, influence: value }), "set influence"),
    );
    const smoothness = slider(
      "Smoothness",
      "How much a change of speed costs the search",
      { min: 0, max: 4, step: 0.05 },
      slide((value) => setOption(this.document, "smoothness", value ** 2), "set smoothness"),
    );
    const limit = (name: "slowest" | "fastest", text: string): boolean => {
      const value = text === "" ? null : parseSpeed(text);
      if (text !== "" && value === null) return false;
      session.edit(setOption(this.document, name, value), "set speed limits");
      return true;
    };
    const slowest = textField("Slowest", "Speed limit for the whole clip: 0.5, 1/2, 50%. Empty: none", (text) =>
      limit("slowest", text),
    );
    const fastest = textField("Fastest", "Speed limit for the whole clip: 2, 200%. Empty: none", (text) =>
      limit("fastest", text),
    );
    slowest.input.placeholder = fastest.input.placeholder = "none";
    this.named("options.slowest", slowest);
    this.named("options.fastest", fastest);
    const limits = make("div", { class: "pair" }, slowest.input, make("span", { class: "note" }, "to"), fastest.input);
    slowest.input.setAttribute("aria-label", "Slowest speed");
    fastest.input.setAttribute("aria-label", "Fastest speed");
    const loop = check("Loop: its end meets its beginning", "The clip is a cycle, and stays one", (on) =>
      session.edit(setOption(this.document, "loop", on), "set loop"),
    );
    const note = make("p", { class: "note" });
    body.append(
      this.named("length", length).row,
      least.row,
      most.row,
      weighed.row,
      influence.row,
      smoothness.row,
      make("div", { class: "row" }, make("span", { class: "label" }, "Speed limits"), limits),
      loop.row,
      note,
    );
    return () => {
      const { options } = this.document;
      length.show(this.document.length ?? "");
      const free = this.document.length === "free";
      for (const [field, value] of [
        [least, this.document.min_length],
        [most, this.document.max_length],
      ] as const) {
        field.row.hidden = !free && value === null;
        field.show(value ?? "");
      }
      weighed.row.hidden = !free;
      weighed.show(
        [
          { value: "neutral", text: "Both clocks alike" },
          { value: "sum", text: "Plain sum (the paper's)" },
        ],
        this.document.free_weight,
      );
      influence.show(this.document.influence, this.document.influence.toFixed(2));
      smoothness.show(Math.sqrt(options.smoothness), options.smoothness.toFixed(2));
      slowest.show(options.slowest === null ? "" : String(options.slowest));
      fastest.show(options.fastest === null ? "" : String(options.fastest));
      loop.show(options.loop);
      const { clip, curve } = store;
      setText(note, clip && curve ? lengthText(curve.n_output, clip) : "");
    };
  }

  private lockSection(): () => void {
    const { store, session } = this;
    const add = make(
      "button",
      {
        type: "button",
        class: "button bare",
        "aria-label": "Add lock at the playhead",
        title: "Lock a second around the playhead",
      },
      icon("plus"),
    );
    add.addEventListener("click", () => {
      const middle = store.playback.inputTime;
      const start = clamp(middle - 0.5, 0, Math.max(0, store.inputEnd - 1));
      const [document, id] = addLock(this.document, start, Math.min(start + 1, store.inputEnd));
      session.edit(document, "add lock");
      store.select({ kind: "lock", id });
    });
    const { body } = this.section("Locked spans", add);
    const rows = make("div");
    const heads = make(
      "div",
      { class: "heads", "aria-hidden": true },
      make("span", {}, "from"),
      make("span", {}, "to"),
      make("span", {}, "speed"),
    );
    const note = make("p", { class: "note" }, "Drag along the input times to keep a span at its speed.");
    body.append(heads, rows, note);
    const made = new Map<string, { row: HTMLElement; show: () => void }>();
    const build = (id: string): { row: HTMLElement; show: () => void } => {
      const change = (part: Parameters<typeof changeLock>[2]): boolean => {
        session.edit(changeLock(this.document, id, part), "change lock");
        return true;
      };
      const from = textField("From", "Input time at which it begins", (text) => {
        const value = parseTime(text, store.rate);
        return value !== null && change({ start: value });
      });
      const to = textField("To", "Input time at which it ends", (text) => {
        const value = parseTime(text, store.rate);
        return value !== null && change({ end: value });
      });
      const speed = textField("Speed", "1, 0.5-2, or uncut (slowed down at most)", (text) => {
        const speeds = parseSpeeds(text);
        return speeds !== null && change({ slowest: speeds[0], fastest: speeds[1] });
      });
      const remove = make(
        "button",
        { type: "button", class: "button bare", "aria-label": "Delete lock", title: "Delete lock" },
        icon("trash"),
      );
      remove.addEventListener("click", () => session.edit(deleteLock(this.document, id), "delete lock"));
      for (const [field, name] of [
        [from, "Lock from"],
        [to, "Lock to"],
        [speed, "Lock speed"],
      ] as const) {
        field.input.setAttribute("aria-label", name);
        field.input.addEventListener("focus", () => store.select({ kind: "lock", id }));
      }
      const row = make("div", { class: "lock" }, from.input, to.input, speed.input, remove);
      return {
        row,
        show: () => {
          const lock = this.document.locks.find((one) => one.id === id);
          if (!lock) return;
          from.show(lock.start.toFixed(2));
          to.show(lock.end.toFixed(2));
          speed.show(speedsText(lock.slowest, lock.fastest));
          row.setAttribute("aria-current", String(store.selection?.kind === "lock" && store.selection.id === id));
          row.classList.toggle("faulty", store.problem?.lock === id);
        },
      };
    };
    return () => {
      const { locks } = this.document;
      for (const [id, { row }] of made) {
        if (locks.some((lock) => lock.id === id)) continue;
        row.remove();
        made.delete(id);
      }
      for (const lock of locks) {
        let entry = made.get(lock.id);
        if (!entry) {
          entry = build(lock.id);
          made.set(lock.id, entry);
          rows.append(entry.row);
        }
        entry.show();
      }
      heads.hidden = locks.length === 0;
      note.hidden = locks.length > 0;
    };
  }

  private referenceSection(): () => void {
    const panel = new ReferencePanel(this.store, this.session, this.dialogs);
    const { body } = this.section("References", ...panel.actions);
    body.append(panel.body);
    return () => panel.update();
  }

  private compareSection(): () => void {
    const { store, session } = this;
    const keep = make(
      "button",
      { type: "button", class: "button", title: "Keep this warp, to compare later ones with" },
      icon("plus"),
      "Keep",
    );
    keep.addEventListener("click", () => {
      const names = new Set(this.document.kept.map((one) => one.name));
      let n = 1;
      while (names.has(`Version ${n}`)) n++;
      session.keep(`Version ${n}`);
    });
    const { body } = this.section("Compare with", keep);
    const other = choice<string>("Beside it", "What stands beside the output on the stage", (value) => {
      const companion: Companion = value.startsWith("kept:")
        ? { kept: value.slice(5) }
        : (value as "input" | "linear" | "spline");
      store.look({ companion, showB: false });
    });
    const name = textField("Name", "What to call the version", (text) => {
      const { companion } = store.view;
      if (typeof companion === "string" || text === "") return false;
      const kept = this.document.kept.map((one) => (one.id === companion.kept ? { ...one, name: text } : one));
      session.edit({ ...this.document, kept }, "rename version");
      return true;
    });
    const drop = make(
      "button",
      { type: "button", class: "button bare", "aria-label": "Forget this version", title: "Forget this version" },
      icon("trash"),
    );
    drop.addEventListener("click", () => {
      const { companion } = store.view;
      if (typeof companion === "string") return;
      session.edit(
        { ...this.document, kept: this.document.kept.filter((one) => one.id !== companion.kept) },
        "forget version",
      );
      store.look({ companion: "input", showB: false });
    });
    const pair = make("span", { class: "pair" }, name.input, drop);
    const nameRow = make("div", { class: "row" }, make("span", { class: "label" }, "Name"), pair);
    name.input.setAttribute("aria-label", "Name of the version");
    const swap = make("div", { class: "segments", role: "group", "aria-label": "Which warp the output plays" });
    const a = make("button", { type: "button", class: "button" }, "A  this warp");
    const b = make("button", { type: "button", class: "button" }, "B");
    a.addEventListener("click", () => store.look({ showB: false }));
    b.addEventListener("click", () => store.look({ showB: true }));
    swap.append(a, b);
    const swapRow = make("div", { class: "row" }, make("span", { class: "label" }, "Play"), swap);
    body.append(other.row, nameRow, swapRow);
    return () => {
      const { companion } = store.view;
      const kept = this.document.kept;
      if (typeof companion !== "string" && !kept.some((one) => one.id === companion.kept)) {
        store.look({ companion: "input", showB: false });
        return;
      }
      other.show(
        [
          { value: "input", text: "Input" },
          { value: "linear", text: "Linear warp" },
          { value: "spline", text: "Spline warp" },
          ...kept.map((one) => ({ value: `kept:${one.id}`, text: one.name })),
        ],
        typeof companion === "string" ? companion : `kept:${companion.kept}`,
      );
      nameRow.hidden = typeof companion === "string";
      name.show(store.companionName);
      swapRow.hidden = companion === "input";
      b.textContent = `B  ${store.companionName}`;
      a.setAttribute("aria-pressed", String(!store.view.showB));
      b.setAttribute("aria-pressed", String(store.view.showB));
    };
  }

  private clipSection(): () => void {
    const panel = new ClipPanel(this.store, this.session, this.dialogs);
    const { body } = this.section("Clips", panel.add);
    body.append(panel.body);
    return () => panel.update();
  }

  private searchSection(): () => void {
    const { session } = this;
    const { body } = this.section("Search");
    const method = choice<"guided" | "linear" | "spline">(
      "Method",
      "Search for a warp, or only join the keytimes",
      (value) => session.edit(setOption(this.document, "method", value), "choose method"),
    );
    const score = choice<"joint" | "conditional">("Score", "What makes a frame's speed look right", (value) =>
      session.edit(setOption(this.document, "score", value), "choose score"),
    );
    const features = choice<"" | "torso" | "heading" | "signal">("Pose", "In which space poses are compared", (value) =>
      session.edit(setOption(this.document, "features", value === "" ? null : value), "choose pose space"),
    );
    const rate = textField(
      "Analysis rate",
      `At how many Hz the search looks at the motion: 30, 29.97; ${FASTEST_ANALYSIS} at most. Empty: 30; the output keeps the clip's own`,
      (text) => {
        const value = text === "" ? null : parseRate(text);
        // A search at a rate far above any capture's would take for ever, and nobody could stop it.
        if (text !== "" && (value === null || !(rateValue(value) >= 1 && rateValue(value) <= FASTEST_ANALYSIS)))
          return false;
        session.edit(setOption(this.document, "rate", value), "set analysis rate");
        return true;
      },
    );
    rate.input.placeholder = "30 Hz";
    this.named("options.rate", rate);
    const numbers = NUMBERS.map(({ name, label, hint, usual, least, whole }) => {
      const field = textField(label, `${hint}. Empty: ${usual}`, (text) => {
        const value = text === "" ? null : Number(text.replace(/\s*(s|hz)$/iu, ""));
        if (value !== null && !(Number.isFinite(value) && value >= least && (!whole || Number.isInteger(value))))
          return false;
        session.edit(setOption(this.document, name, value), `set ${label.toLowerCase()}`);
        return true;
      });
      field.input.placeholder = usual;
      return { name, field: this.named(`options.${name}`, field) };
    });
    const set = make("span", { class: "note" });
    const more = make(
      "details",
      { class: "reading" },
      make("summary", {}, "More", set),
      ...numbers.map(({ field }) => field.row),
    );
    const average = check("Average where it is sped up", "Blends the frames that a fast stretch leaps over", (on) =>
      session.edit(setOption(this.document, "average", on), "set averaging"),
    );
    body.append(method.row, score.row, features.row, rate.row, average.row, more);
    return () => {
      const { options } = this.document;
      method.show(
        [
          { value: "guided", text: "Guided" },
          { value: "linear", text: "Linear" },
          { value: "spline", text: "Spline" },
        ],
        options.method,
      );
      score.show(
        [
          { value: "joint", text: "Joint (the paper's)" },
          { value: "conditional", text: "Conditional" },
        ],
        options.score,
      );
      features.show(
        [
          { value: "", text: "Default" },
          { value: "heading", text: "Heading" },
          { value: "torso", text: "Torso (the paper's)" },
          { value: "signal", text: "Plain channels" },
        ],
        options.features ?? "",
      );
      rate.show(options.rate ?? "");
      for (const { name, field } of numbers) field.show(options[name] === null ? "" : String(options[name]));
      const given = numbers.filter(({ name }) => options[name] !== null).length;
      setText(set, given > 0 ? `${given} set` : "");
      if (numbers.some(({ name }) => this.store.problem?.field === `options.${name}`)) more.open = true;
      average.show(options.average);
    };
  }
}

/** A lock's speeds as people write them: `1`, `0.5-2`, `uncut`. */
export function parseSpeeds(text: string): [number, number] | null {
  if (text.trim().toLowerCase() === "uncut") return [0, 1];
  const parts = text.split(/\s*(?:-|–|to)\s*/u);
  const speeds = parts.map((part) => (part.trim() === "0" ? 0 : parseSpeed(part)));
  const [low, high = low] = speeds;
  if (parts.length > 2 || low === null || low === undefined || high === null || high === undefined) return null;
  return low <= high && high > 0 ? [low, high] : null;
}

export function speedsText(slowest: number, fastest: number): string {
  if (slowest === 0 && fastest === 1) return "uncut";
  return slowest === fastest ? String(slowest) : `${slowest}-${fastest}`;
}
