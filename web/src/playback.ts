/** Where the playhead is, and how it moves: two clocks, linked or not. */

import { clamp, snapped } from "./scale";
import { inputAt, type Knots, outputAt, outputEnd, outputStart } from "./warp";

/** Whose seconds are true seconds while playing. */
export type ClockName = "output" | "input";

export interface PlaybackState {
  readonly outputTime: number;
  readonly inputTime: number;
  readonly clock: ClockName;
  /** Both figures show one moment of the action; else each plays by its own clock from its own beginning. */
  readonly linked: boolean;
  readonly loop: boolean;
  /** 0: it stands still. 1: it plays in true seconds; 2: twice as fast; -1: backward. */
  readonly rate: number;
}

export const STILL: PlaybackState = {
  outputTime: 0,
  inputTime: 0,
  clock: "output",
  linked: false,
  loop: true,
  rate: 0,
};

/** Put the playhead at a time of the clock that leads. */
export function seek(state: PlaybackState, warp: Knots, inputEnd: number, time: number): PlaybackState {
  const start = outputStart(warp);
  const end = outputEnd(warp);
  if (state.clock === "output") {
    const outputTime = clamp(time, start, end);
    const inputTime = state.linked ? inputAt(warp, outputTime) : clamp(outputTime - start, 0, inputEnd);
    return { ...state, outputTime, inputTime };
  }
  const inputTime = clamp(time, 0, inputEnd);
  const outputTime = state.linked ? outputAt(warp, inputTime, state.outputTime) : clamp(start + inputTime, start, end);
  return { ...state, outputTime, inputTime };
}

/** The leading clock's time, and the range that it runs through. */
export function leading(state: PlaybackState, warp: Knots, inputEnd: number): [number, number, number] {
  if (state.clock === "input") {
    // Unlinked, a figure that has come to its end rests there while the other one plays on.
    return [state.inputTime, 0, inputEnd];
  }
  return [state.outputTime, outputStart(warp), outputEnd(warp)];
}

/** A stretch of the output. */
export interface Stretch {
  readonly start: number;
  readonly end: number;
}

/** From when to when the leading clock runs: all of it, or a stretch of the output. */
export function range(state: PlaybackState, warp: Knots, inputEnd: number, part: Stretch | null): Stretch {
  const [, start, end] = leading(state, warp, inputEnd);
  if (!part) return { start, end };
  if (state.clock === "output") return part;
  // Unlinked, the input's clock counts from its own beginning, as the output's does.
  const times = [part.start, part.end].map((time) => (state.linked ? inputAt(warp, time) : time - outputStart(warp)));
  const [first, last] = times.sort((a, b) => a - b).map((time) => clamp(time, 0, inputEnd)) as [number, number];
  return last > first ? { start: first, end: last } : { start, end };
}

/** Let `seconds` pass. At the end, or that of the part that is played, it begins anew, or stands. */
export function advance(
  state: PlaybackState,
  warp: Knots,
  inputEnd: number,
  seconds: number,
  part: Stretch | null = null,
): PlaybackState {
  if (state.rate === 0) return state;
  const [time] = leading(state, warp, inputEnd);
  const { start, end } = range(state, warp, inputEnd, part);
  let next = time + seconds * state.rate;
  let rate = state.rate;
  if (next > end || next < start) {
    if (state.loop && end > start) {
      next = start + ((((next - start) % (end - start)) + (end - start)) % (end - start));
    } else {
      next = clamp(next, start, end);
      rate = 0;
    }
  }
  return { ...seek(state, warp, inputEnd, next), rate };
}

/** Stand, and go a number of the clip's frames on. */
export function step(
  state: PlaybackState,
  warp: Knots,
  inputEnd: number,
  frameRate: number,
  frames: number,
): PlaybackState {
  const [time] = leading(state, warp, inputEnd);
  return seek({ ...state, rate: 0 }, warp, inputEnd, snapped(time, frameRate) + frames / frameRate);
}

/** J, K and L: backward, stand, forward; again, faster. */
export function shuttle(rate: number, direction: -1 | 1): number {
  return Math.sign(rate) === direction ? clamp(rate * 2, -8, 8) : direction;
}
