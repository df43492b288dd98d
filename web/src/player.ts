/** The playhead: played, stepped, and put where a person wants it. */

import { markedTimes, playedStretch } from "./markers";
import { advance, type ClockName, leading, type PlaybackState, range, seek, shuttle, step } from "./playback";
import { clamp } from "./scale";
import type { Store } from "./store";
import { type Knots, outputAt, outputEnd, outputStart } from "./warp";

/** Seconds that the playhead goes on in a frame at most: while the page was in another tab, no time has passed for it. */
const LONGEST_FRAME = 0.25;

export class Player {
  /** When the last frame was drawn while playing, milliseconds; 0 where none was. */
  private before = 0;

  constructor(private readonly store: Store) {}

  get isPlaying(): boolean {
    return this.store.playback.rate !== 0;
  }

  /** Let time pass until `now`, milliseconds, as the browser counts for its frames. */
  goOn(now: number): void {
    const { store } = this;
    const { knots } = store;
    if (!this.isPlaying || !knots) {
      this.before = 0;
      return;
    }
    const seconds = this.before > 0 ? Math.min((now - this.before) / 1000, LONGEST_FRAME) : 0;
    this.before = now;
    store.setPlayback(advance(store.playback, knots, store.inputEnd, seconds, playedStretch(store.document, knots)));
  }

  /** Play, or pause; from its end the clip is played from its beginning. */
  toggle(): void {
    const { store } = this;
    const { knots } = store;
    if (!knots) return;
    if (this.isPlaying) return this.stop();
    const [time] = leading(store.playback, knots, store.inputEnd);
    const { start, end } = range(store.playback, knots, store.inputEnd, playedStretch(store.document, knots));
    if (time >= end - 1e-9 || time < start - 1e-9)
      store.setPlayback(seek(store.playback, knots, store.inputEnd, start));
    this.change({ rate: 1 });
  }

  stop(): void {
    this.change({ rate: 0 });
  }

  shuttle(direction: -1 | 1): void {
    this.change({ rate: shuttle(this.store.playback.rate, direction) });
  }

  step(frames: number): void {
    const { store } = this;
    if (!store.knots) return;
    store.setPlayback(step(store.playback, store.knots, store.inputEnd, store.rate, frames));
  }

  /** Stand at an output time, whichever clock leads: the timeline is in output time. */
  scrub(outputTime: number): void {
    if (this.store.knots) this.put(this.store.knots, outputTime, "output", { rate: 0 });
  }

  /** Stand at the output time that shows an input time, the nearest of several. */
  scrubInput(inputTime: number): void {
    const { knots, playback, inputEnd } = this.store;
    if (knots) this.scrub(outputAt(knots, clamp(inputTime, 0, inputEnd), playback.outputTime));
  }

  /** To the next marker of the output or the last one before. */
  toMarker(direction: -1 | 1): void {
    const { store } = this;
    const now = store.playback.outputTime;
    const times = markedTimes(store.document, "output").sort((a, b) => a - b);
    const next = direction > 0 ? times.find((time) => time > now + 1e-6) : times.findLast((time) => time < now - 1e-6);
    if (next !== undefined) this.scrub(next);
  }

  toEdge(edge: "start" | "end"): void {
    const { store } = this;
    if (!store.knots) return;
    const [, start, end] = leading(store.playback, store.knots, store.inputEnd);
    this.put(store.knots, edge === "start" ? start : end, store.playback.clock, { rate: 0 });
  }

  /** To the next keytime or the last one before, the ends included. */
  toKey(direction: -1 | 1): void {
    const { store } = this;
    const { knots, document } = store;
    if (!knots || !document) return;
    const now = store.playback.outputTime;
    const keys = document.keys.map((key) => key.output_time);
    const times = [outputStart(knots), ...keys, outputEnd(knots)].sort((a, b) => a - b);
    const next = direction > 0 ? times.find((time) => time > now + 1e-6) : times.findLast((time) => time < now - 1e-6);
    if (next === undefined) return;
    this.scrub(next);
    const key = document.keys.find((one) => one.output_time === next);
    store.select(key ? { kind: "key", id: key.id } : null);
  }

  lead(clock: ClockName): void {
    this.change({ clock });
  }

  otherClock(): void {
    this.lead(this.store.playback.clock === "output" ? "input" : "output");
  }

  toggleLoop(): void {
    this.change({ loop: !this.store.playback.loop });
  }

  /** Show the same moment of the action on both sides, or let each go its way. */
  toggleLink(): void {
    this.change({ linked: !this.store.playback.linked });
    if (!this.isPlaying) this.scrub(this.store.playback.outputTime);
  }

  /** The curve has changed: where the playhead stood may lie after the output's end now. */
  stayInside(): void {
    const { knots, playback } = this.store;
    if (!knots || this.isPlaying) return;
    this.put(knots, clamp(playback.outputTime, 0, outputEnd(knots)), "output");
  }

  /** Stand at the beginning of another document. */
  rewind(): void {
    this.change({ rate: 0, outputTime: 0, inputTime: 0 });
  }

  /** Put one clock at a time, and the other where it belongs then. */
  private put(knots: Knots, time: number, clock: ClockName, change: Partial<PlaybackState> = {}): void {
    const { store } = this;
    const { playback } = store;
    const moved = seek({ ...playback, clock }, knots, store.inputEnd, time);
    store.setPlayback({ ...moved, clock: playback.clock, ...change });
  }

  private change(change: Partial<PlaybackState>): void {
    this.store.setPlayback({ ...this.store.playback, ...change });
  }
}
