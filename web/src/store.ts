/** What the page shows: one place that holds it, and says what changed. */

import { findKey, throughKeys } from "./document";
import { type Flight, flightsOf } from "./flights";
import { type Beside, NOTHING_BESIDE } from "./media/beside";
import type { Clip, Curve, Document, Problem, Progress, State, Why } from "./messages";
import { type PlaybackState, STILL, seek } from "./playback";
import { splineOf } from "./spline";
import { PLAIN_VIEW, recallView, rememberView, type ViewSettings } from "./view_settings";
import { inputAt, type Knots } from "./warp";
import type { Match } from "./why";

export type Topic =
  | "document"
  | "curve"
  | "why"
  | "clips"
  | "playhead"
  | "selection"
  | "hover"
  | "view"
  | "status"
  | "theme"
  | "size"
  | "beside";

export type Selection =
  | { readonly kind: "key"; readonly id: string }
  | { readonly kind: "lock"; readonly id: string }
  | { readonly kind: "flight"; readonly id: string }
  | { readonly kind: "marker"; readonly id: string }
  | { readonly kind: "end" }
  | null;

/** A moment that is looked at. */
export interface Looked {
  readonly by: "key" | "pointer" | "playhead";
  readonly outputTime: number;
  /** What the input's side shows. */
  readonly inputTime: number;
  /** What the output shows, where that is not for the curve to say. */
  readonly shown: number | null;
}

/** All that the page shows. Its values are never changed in place: the store's setters replace them. */
interface Shown {
  readonly document: Document | null;
  readonly state: State | null;
  readonly curve: Curve | null;
  readonly why: Why | null;
  readonly problem: Problem | null;
  /** How far the search is, where it takes long. */
  readonly progress: Progress | null;
  readonly clips: readonly Clip[];
  readonly references: readonly Clip[];
  readonly kept: ReadonlyMap<string, Knots>;
  /** Of signals, by their names: the channels that a person chose to see. */
  readonly channels: ReadonlyMap<string, readonly number[]>;
  readonly playback: PlaybackState;
  readonly selection: Selection;
  /** Ids of the keytimes that are chosen together; the selected one is among them. */
  readonly chosenKeys: ReadonlySet<string>;
  /** Output time under the pointer. */
  readonly hover: number | null;
  readonly view: ViewSettings;
  /** Whether a drag is going on: views stand still while it is. */
  readonly dragging: boolean;
  /** What was found of the video or sound beside the stage, and of beats. */
  readonly beside: Beside;
  /** The keytime that is dragged. */
  readonly draggedKey: string | null;
}

const NOTHING: Shown = {
  document: null,
  state: null,
  curve: null,
  why: null,
  problem: null,
  progress: null,
  clips: [],
  references: [],
  kept: new Map(),
  channels: new Map(),
  playback: STILL,
  selection: null,
  chosenKeys: new Set(),
  hover: null,
  view: PLAIN_VIEW,
  dragging: false,
  beside: NOTHING_BESIDE,
  draggedKey: null,
};

const NO_FLIGHTS: readonly Flight[] = [];

export class Store {
  private shown: Shown = { ...NOTHING, view: recallView() };
  private readonly changed = new Set<Topic>();
  private knownFlights: readonly Flight[] = NO_FLIGHTS;
  private flightsAreOf: readonly unknown[] = [];

  /** `wake` is called when there is something new to draw. */
  constructor(private readonly wake: () => void) {}

  /** Take what changed since the last call, that is since the last frame. */
  take(): Set<Topic> {
    const taken = new Set(this.changed);
    this.changed.clear();
    return taken;
  }

  /** Whether something of a topic changed since the last frame. */
  hasChanged(topic: Topic): boolean {
    return this.changed.has(topic);
  }

  // What there is.

  get document(): Shown["document"] {
    return this.shown.document;
  }

  get state(): Shown["state"] {
    return this.shown.state;
  }

  get curve(): Shown["curve"] {
    return this.shown.curve;
  }

  get why(): Shown["why"] {
    return this.shown.why;
  }

  get problem(): Shown["problem"] {
    return this.shown.problem;
  }

  get progress(): Shown["progress"] {
    return this.shown.progress;
  }

  get clips(): Shown["clips"] {
    return this.shown.clips;
  }

  get references(): Shown["references"] {
    return this.shown.references;
  }

  get kept(): Shown["kept"] {
    return this.shown.kept;
  }

  get channels(): Shown["channels"] {
    return this.shown.channels;
  }

  get playback(): Shown["playback"] {
    return this.shown.playback;
  }

  get selection(): Shown["selection"] {
    return this.shown.selection;
  }

  /** Keytimes that are chosen together, as far as they are still there. */
  get chosenKeys(): Shown["chosenKeys"] {
    const { chosenKeys, document } = this.shown;
    const there = document?.keys.filter((key) => chosenKeys.has(key.id)) ?? [];
    return there.length === chosenKeys.size ? chosenKeys : new Set(there.map((key) => key.id));
  }

  get hover(): Shown["hover"] {
    return this.shown.hover;
  }

  get view(): Shown["view"] {
    return this.shown.view;
  }

  /** The id of what is selected, where that is of this kind. */
  selectedId(kind: "key" | "lock" | "flight" | "marker"): string | null {
    const { selection } = this.shown;
    return selection?.kind === kind ? selection.id : null;
  }

  get draggedKey(): Shown["draggedKey"] {
    return this.shown.draggedKey;
  }

  get dragging(): Shown["dragging"] {
    return this.shown.dragging;
  }

  get beside(): Shown["beside"] {
    return this.shown.beside;
  }

  get clip(): Clip | null {
    return this.clips[0] ?? null;
  }

  /** When the figures that are searched are in the air: as it was found, and put right by hand. */
  get flights(): readonly Flight[] {
    const { document, clips } = this;
    if (!document) return NO_FLIGHTS;
    // Asked for many times a frame, and the same until somebody puts one right, or another clip comes.
    const of = [document.flights, document.clips, clips];
    if (!of.every((part, i) => part === this.flightsAreOf[i])) {
      this.flightsAreOf = of;
      this.knownFlights = flightsOf(document, clips);
    }
    return this.knownFlights;
  }

  /** The place of the reference that is looked at; the last one where that is gone. */
  get reference(): number {
    return Math.max(0, Math.min(this.view.reference, (this.document?.references.length ?? 0) - 1));
  }

  /** The time of a match within all of its reference, of which only a stretch may be imitated. */
  wholeTime({ source, time }: Match): number {
    return time + (this.references[source]?.start_time ?? 0);
  }

  /** Time of the last frame of the first clip, seconds. */
  get inputEnd(): number {
    const clip = this.clip;
    return clip ? (clip.n_frames - 1) / clip.rate : 0;
  }

  get rate(): number {
    return this.clip?.rate ?? 30;
  }

  get knots(): Knots | null {
    if (this.curve) return { outputTimes: this.curve.output_times, inputTimes: this.curve.input_times };
    // A project may open with a problem, before there was any curve: then there is at least something to look at.
    return this.problem && this.document && this.clip ? throughKeys(this.document, this.inputEnd) : null;
  }

  /** The warp of what the output is compared with; none for the input itself. */
  get companionKnots(): Knots | null {
    const { companion } = this.view;
    if (!this.curve || companion === "input") return null;
    if (companion === "linear") {
      return { outputTimes: this.curve.linear_output_times, inputTimes: this.curve.linear_input_times };
    }
    if (companion === "spline") {
      return splineOf(this.curve);
    }
    return this.kept.get(companion.kept) ?? null;
  }

  get companionName(): string {
    const { companion } = this.view;
    if (typeof companion === "string") return { input: "Input", linear: "Linear", spline: "Spline" }[companion];
    return this.document?.kept.find((one) => one.id === companion.kept)?.name ?? "Kept";
  }

  /** The output time that the stage shows: the frame under the pointer, while nothing plays and nothing is dragged. */
  get lookedAt(): number {
    return this.looked.outputTime;
  }

  /**
   * What both sides of the stage show: while a keytime is dragged, its pose; else the frame under the pointer, while
   * nothing plays and nothing is dragged; else what the playhead says.
   */
  get looked(): Looked {
    const { playback, hover, knots, document, draggedKey } = this;
    const key = document && draggedKey !== null ? findKey(document, draggedKey) : null;
    if (key) {
      const { output_time, input_time } = key;
      return { by: "key", outputTime: output_time, inputTime: input_time, shown: input_time };
    }
    if (hover !== null && knots && playback.rate === 0 && !this.dragging) {
      const { outputTime, inputTime } = seek({ ...playback, clock: "output" }, knots, this.inputEnd, hover);
      return { by: "pointer", outputTime, inputTime, shown: null };
    }
    return { by: "playhead", outputTime: playback.outputTime, inputTime: playback.inputTime, shown: null };
  }

  /** The input time that the output shows at a time. */
  shownInput(outputTime: number): number {
    return this.knots ? inputAt(this.knots, outputTime) : 0;
  }

  // What the server tells.

  /** Show a document: as a person has just changed it, or as the server has it. */
  setDocument(document: Document): void {
    this.set({ document }, "document");
  }

  setState(state: State | null): void {
    this.set({ state }, "status");
  }

  /** Show a curve; what could not be done before can be done now. */
  setCurve(curve: Curve): void {
    // Where nothing was searched nothing is explained: what was said of the last curve is not of this one.
    const why = curve.total === null ? null : this.shown.why;
    this.set(
      { curve, problem: null, progress: null, why },
      "curve",
      "status",
      ...(why === this.shown.why ? [] : (["why"] as const)),
    );
  }

  /** Show what is wrong with the document; the last curve stays. */
  setProblem(problem: Problem): void {
    this.set({ problem, progress: null }, "curve", "status");
  }

  /** Show how far a search is; null: none is at work. */
  setProgress(progress: Progress | null): void {
    this.set({ progress }, "status");
  }

  setWhy(why: Why): void {
    this.set({ why }, "why");
  }

  /** Put a clip or a reference in its place, and forget those beyond as many as there are. */
  setClip(clip: Clip): void {
    const list = clip.what === "clip" ? "clips" : "references";
    const clips = this.shown[list].slice(0, clip.count);
    clips[clip.index] = clip;
    this.set({ [list]: clips }, "clips");
  }

  setKept(id: string, warp: Knots): void {
    this.set({ kept: new Map(this.shown.kept).set(id, warp) }, "view");
  }

  /** Another document is open: nothing that was found of the old one belongs to it. */
  clear(): void {
    const { clips, references, curve, why, problem, progress } = NOTHING;
    this.set({ clips, references, curve, why, problem, progress }, "clips", "curve", "why", "status");
  }

  /** Something was found of the video or sound beside the stage, or of beats. */
  setBeside(change: Partial<Beside>): void {
    this.set({ beside: { ...this.shown.beside, ...change } }, "beside");
  }

  // What a person does.

  look(change: Partial<ViewSettings>): void {
    this.set({ view: { ...this.shown.view, ...change } }, "view");
    rememberView(this.shown.view);
  }

  /** Select one thing, or nothing. */
  select(selection: Selection): void {
    const chosenKeys = new Set(selection?.kind === "key" ? [selection.id] : []);
    this.set({ selection, chosenKeys }, "selection");
  }

  /** Choose keytimes together; the one that is looked at is `lead`, where it is one of them, else the last. */
  chooseKeys(ids: Iterable<string>, lead: string | null = null): void {
    const chosenKeys = new Set(ids);
    const id = lead !== null && chosenKeys.has(lead) ? lead : [...chosenKeys].at(-1);
    this.set({ selection: id === undefined ? null : { kind: "key", id }, chosenKeys }, "selection");
  }

  /** Choose a keytime beside those that are chosen, or not any more. */
  toggleKey(id: string): void {
    const others = [...this.shown.chosenKeys].filter((other) => other !== id);
    this.chooseKeys(this.shown.chosenKeys.has(id) ? others : [...others, id], id);
  }

  setPlayback(playback: PlaybackState): void {
    this.set({ playback }, "playhead");
  }

  /** The pointer is over an output time, or over none. */
  point(hover: number | null): void {
    if (hover !== this.shown.hover) this.set({ hover }, "hover");
  }

  chooseChannels(signal: string, channels: readonly number[]): void {
    this.set({ channels: new Map(this.shown.channels).set(signal, channels) }, "view");
  }

  /** A drag begins, or goes on: views stand still until it ends. */
  beginDrag(draggedKey: string | null = null): void {
    if (!this.shown.dragging) this.set({ dragging: true, draggedKey });
  }

  endDrag(): void {
    this.set({ dragging: false, draggedKey: null }, "view");
  }

  // What changes outside the store, and has to be drawn.

  /** The stage or the timeline shows another part; which one they remember themselves. */
  viewMoved(): void {
    this.set({}, "view");
  }

  /** Nothing was drawn yet: all of it is new. */
  begin(): void {
    this.set({}, "size", "theme", "view");
  }

  resized(): void {
    this.set({}, "size");
  }

  recolored(): void {
    this.set({}, "theme");
  }

  /** Change what is shown; it is drawn at the next frame, by those who draw one of the topics. */
  private set(change: Partial<Shown>, ...topics: Topic[]): void {
    this.shown = { ...this.shown, ...change };
    if (topics.length === 0) return;
    for (const topic of topics) this.changed.add(topic);
    this.wake();
  }
}
