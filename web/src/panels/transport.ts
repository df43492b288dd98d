/** The bar between stage and timeline: play, step, clocks, and where the playhead is. */

import { type Attributes, make, setAttribute, setText } from "../dom";
import { type IconName, icon } from "../icons";
import type { ClockName } from "../playback";
import type { Store, Topic } from "../store";
import { speedAt } from "../warp";

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
}

export class Transport {
  readonly root: HTMLElement;
  private readonly play: HTMLButtonElement;
  private readonly loop: HTMLButtonElement;
  private readonly link: HTMLButtonElement;
  private readonly snap: HTMLButtonElement;
  private readonly clocks: Record<ClockName, HTMLButtonElement>;
  private readonly output = make("b");
  private readonly outputFrame = make("span");
  private readonly input = make("b");
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
        this.output,
        this.outputFrame,
      ),
      make("span", { class: "readout", "data-is": "input" }, make("span", {}, "shows input"), this.input, this.speed),
      make("span", { class: "gap" }),
      this.status,
      this.snap,
      button("fit", "Show all of the output (F)", actions.fit),
    );
  }

  update(changed: Set<Topic>): void {
    if (!["playhead", "curve", "view", "status"].some((topic) => changed.has(topic as Topic))) return;
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
    setText(this.output, `${playback.outputTime.toFixed(2)} s`);
    setText(this.outputFrame, `f ${Math.round(playback.outputTime * rate)}`);
    if (knots) {
      const shown = this.store.shownInput(playback.outputTime);
      setText(this.input, `${shown.toFixed(2)} s`);
      setText(this.speed, `at ${speedAt(knots, playback.outputTime).toFixed(2)}×`);
    }
    const speed = Math.abs(playback.rate) > 1 || playback.rate < 0 ? `plays at ${playback.rate}×` : "";
    setText(this.status, speed || (curve || this.store.problem ? "" : "Solving…"));
  }
}

function button(name: IconName, label: string, action: () => void): HTMLButtonElement {
  const attributes: Attributes = { type: "button", class: "button bare", "aria-label": label, title: label };
  const made = make("button", attributes, icon(name));
  made.addEventListener("click", action);
  return made;
}
