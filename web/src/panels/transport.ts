/** The bar between stage and timeline: play, step, clocks, and where the playhead is. */

import { type Attributes, make, setAttribute, setText } from "../dom";
import { parseTime } from "../grammar";
import { type IconName, icon } from "../icons";
import type { ClockName } from "../playback";
import type { Store, Topic } from "../store";
import { rateText, said, timecodeFrames, UNITS, type Units, unitsOf } from "../units";
import { speedAt } from "../warp";
import { type Field, textField } from "./fields";

export interface TransportActions {
  play(): void;
  toStart(): void;
  toEnd(): void;
  step(frames: number): void;
  loop(): void;
  clock(clock: ClockName): void;
  link(): void;
  snap(): void;
  fit(): void;
  /** Put the playhead at an output time, or where an input time is shown. */
  scrub(axis: "output" | "input", time: number): void;
  units(units: Units): void;
}

export class Transport {
  readonly root: HTMLElement;
  private readonly play: HTMLButtonElement;
  private readonly loop: HTMLButtonElement;
  private readonly link: HTMLButtonElement;
  private readonly snap: HTMLButtonElement;
  private readonly clocks: Record<ClockName, HTMLButtonElement>;
  private readonly output: Field;
  private readonly outputFrame = make("span", { class: "frame" });
  private readonly input: Field;
  private readonly units: HTMLSelectElement;
  private readonly rate = make("span", { class: "note rate", title: "Frames a second of the first clip" });
  private readonly speed = make("span");
  private readonly status = make("span", { class: "status" });

  constructor(
    private readonly store: Store,
    actions: TransportActions,
  ) {
    this.play = button("play", "Play (Space)", actions.play);
    this.loop = button("loop", "Loop", actions.loop);
    this.link = button("link", "Linked: both sides show the same moment of the action", actions.link);
    this.snap = button("snap", "Snap to frames", actions.snap);
    const clock = (name: ClockName, text: string, title: string): HTMLButtonElement => {
      const made = make("button", { type: "button", class: "button", title }, text);
      made.addEventListener("click", () => actions.clock(name));
      return made;
    };
    this.clocks = {
      output: clock("output", "Output time", "Play the output at true rate (C)"),
      input: clock("input", "Input time", "Play the input at true rate (C)"),
    };
    const playhead = (axis: "output" | "input", label: string, now: () => number): Field => {
      const hint = "seconds, 105f, 1:03.5, or timecode 00:01:03:12";
      const commit = (text: string): boolean => {
        actions.scrub(axis, parseTime(text, store.rate));
        return true;
      };
      const field = textField(label, `${label}: ${hint}`, commit, () => {
        const start = now();
        return (steps) => actions.scrub(axis, start + steps / store.rate);
      });
      field.input.classList.add("playfield");
      field.input.setAttribute("aria-label", label);
      return field;
    };
    this.output = playhead("output", "Playhead, output time", () => store.playback.outputTime);
    this.input = playhead("input", "Playhead, input time shown", () => store.shownInput(store.playback.outputTime));
    this.units = make("select", { class: "field units", "aria-label": "Units of time", title: "Units of time (U)" });
    this.units.addEventListener("change", () => actions.units(this.units.value as Units));
    this.root = make(
      "div",
      { class: "transport", role: "toolbar", "aria-label": "Playback" },
      button("first", "To the beginning (Home)", actions.toStart),
      button("previous", "A frame back (←)", () => actions.step(-1)),
      this.play,
      button("next", "A frame on (→)", () => actions.step(1)),
      button("last", "To the end (End)", actions.toEnd),
      this.loop,
      make("span", { class: "rule" }),
      make("span", { class: "segments", role: "group", "aria-label": "Clock" }, this.clocks.output, this.clocks.input),
      this.link,
      make("span", { class: "rule" }),
      make(
        "span",
        { class: "readout", "data-is": "output" },
        make("span", {}, "Output"),
        this.output.input,
        this.outputFrame,
      ),
      make(
        "span",
        { class: "readout", "data-is": "input" },
        make("span", {}, "shows input"),
        this.input.input,
        this.speed,
      ),
      make("span", { class: "gap" }),
      this.status,
      this.output.trouble,
      this.input.trouble,
      this.units,
      this.rate,
      this.snap,
      button("fit", "Show all of the output (F)", actions.fit),
    );
  }

  update(changed: Set<Topic>): void {
    if (!["playhead", "curve", "view", "status", "clips"].some((topic) => changed.has(topic as Topic))) return;
    const { playback, view, knots, rate, curve } = this.store;
    const playing = playback.rate !== 0;
    if ((this.play.dataset.playing === "yes") !== playing) {
      this.play.dataset.playing = playing ? "yes" : "no";
      this.play.replaceChildren(icon(playing ? "pause" : "play"));
      setAttribute(this.play, "aria-label", playing ? "Pause (Space)" : "Play (Space)");
    }
    setAttribute(this.loop, "aria-pressed", String(playback.loop));
    setAttribute(this.link, "aria-pressed", String(playback.linked));
    setAttribute(this.snap, "aria-pressed", String(view.snap));
    for (const name of ["output", "input"] as const)
      setAttribute(this.clocks[name], "aria-pressed", String(playback.clock === name));
    this.showUnits();
    this.output.show(said(this.store, playback.outputTime));
    setText(this.outputFrame, `f ${Math.round(playback.outputTime * rate)}`);
    if (knots) {
      const shown = this.store.shownInput(playback.outputTime);
      this.input.show(said(this.store, shown));
      setText(this.speed, `at ${speedAt(knots, playback.outputTime).toFixed(2)}×`);
    }
    const speed = Math.abs(playback.rate) > 1 || playback.rate < 0 ? `plays at ${playback.rate}×` : "";
    setText(this.status, speed || (curve || this.store.problem ? "" : "Solving…"));
  }

  private showUnits(): void {
    const { units, store } = this;
    const now = unitsOf(store);
    const has = timecodeFrames(store.rate) === null ? UNITS.filter((one) => one !== "timecode") : UNITS;
    if (units.options.length !== has.length)
      units.replaceChildren(...has.map((one) => make("option", { value: one }, NAMES[one])));
    if (units.value !== now) units.value = now;
    setText(this.rate, store.clip ? rateText(store.rate) : "");
    this.root.dataset.units = now;
  }
}

const NAMES: Record<Units, string> = { seconds: "Seconds", frames: "Frames", timecode: "Timecode" };

function button(name: IconName, label: string, action: () => void): HTMLButtonElement {
  const attributes: Attributes = { type: "button", class: "button bare", "aria-label": label, title: label };
  const made = make("button", attributes, icon(name));
  made.addEventListener("click", action);
  return made;
}
