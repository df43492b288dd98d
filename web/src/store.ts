/** What the page shows: one place that holds it, and says what changed. */

import { throughKeys } from "./document";
import { recall, remember } from "./memory";
import type { Clip, Curve, Document, Problem, State, Why } from "./messages";
import { type PlaybackState, STILL } from "./playback";
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
  | "size";

export type Selection =
  | { readonly kind: "key"; readonly id: string }
  | { readonly kind: "lock"; readonly id: string }
  | { readonly kind: "end" }
  | null;

/** What is compared with the output. */
export type Companion = "input" | "linear" | "spline" | { readonly kept: string };

export interface ViewSettings {
  readonly layout: "side" | "over";
  readonly companion: Companion;
  /** The output figure plays the companion's warp instead. */
  readonly showB: boolean;
  readonly follow: boolean;
  readonly ground: boolean;
  readonly trails: boolean;
  readonly onion: boolean;
  readonly snap: boolean;
  /** Which clip of a group the camera follows, or which signal is drawn. */
  readonly clip: number;
  /** Which reference is looked at. */
  readonly reference: number;
}

const VIEW: ViewSettings = {
  layout: "side",
  companion: "input",
  showB: false,
  follow: true,
  ground: true,
  trails: false,
  onion: false,
  snap: true,
  clip: 0,
  reference: 0,
};

const STORED = "retime.view";

export class Store {
  document: Document | null = null;
  state: State | null = null;
  curve: Curve | null = null;
  why: Why | null = null;
  problem: Problem | null = null;
  clips: Clip[] = [];
  references: Clip[] = [];
  kept = new Map<string, Knots>();
  /** Of signals, by their names: the channels that a person chose to see. */
  readonly channels = new Map<string, readonly number[]>();
  playback: PlaybackState = STILL;
  selection: Selection = null;
  /** Output time under the pointer. */
  hover: number | null = null;
  view: ViewSettings = { ...VIEW, ...remembered() };
  /** Whether a drag is going on: views stand still while it is. */
  dragging = false;

  private readonly changed = new Set<Topic>();

  constructor(private readonly wake: () => void) {}

  /** Tell that something changed; it is drawn at the next frame. */
  touch(...topics: Topic[]): void {
    for (const topic of topics) this.changed.add(topic);
    this.wake();
  }

  /** What changed since the last call. */
  take(): Set<Topic> {
    const taken = new Set(this.changed);
    this.changed.clear();
    return taken;
  }

  get clip(): Clip | null {
    return this.clips[0] ?? null;
  }

  /** The place of the reference that is looked at; the last one where that is gone. */
  get reference(): number {
    return Math.max(0, Math.min(this.view.reference, (this.document?.references.length ?? 0) - 1));
  }

  /** When a match lies in all of its reference, of which a stretch may be imitated. */
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
      return { outputTimes: this.curve.spline_output_times, inputTimes: this.curve.spline_input_times };
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
    const skims = this.hover !== null && this.playback.rate === 0 && !this.dragging;
    return skims ? (this.hover as number) : this.playback.outputTime;
  }

  /** The input time that the output shows at a time. */
  shownInput(outputTime: number): number {
    return this.knots ? inputAt(this.knots, outputTime) : 0;
  }

  look(change: Partial<ViewSettings>): void {
    this.view = { ...this.view, ...change };
    const { layout, follow, ground, trails, onion, snap } = this.view;
    remember(STORED, JSON.stringify({ layout, follow, ground, trails, onion, snap }));
    this.touch("view");
  }

  select(selection: Selection): void {
    this.selection = selection;
    this.touch("selection");
  }
}

function remembered(): Partial<ViewSettings> {
  try {
    const found: unknown = JSON.parse(recall(STORED) ?? "{}");
    return typeof found === "object" && found !== null ? (found as Partial<ViewSettings>) : {};
  } catch {
    return {};
  }
}
