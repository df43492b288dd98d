/** The sound of a film of the stage: what of the media is heard when. */

import type { MediaFile } from "../messages";
import { leading, type PlaybackState, seek } from "../playback";
import { type Knots, outputStart } from "../warp";
import { mediaTimeAt } from "./beside";

/** Seconds of the film, and of the media, as many of each; between them it goes on evenly. */
export interface Heard {
  readonly times: readonly number[];
  readonly values: readonly number[];
  /** Those of the film at which there are keytimes: there it is to be exact. */
  readonly keys: readonly number[];
}

/**
 * What is heard while the leading clock runs once from its beginning to its end.
 *
 * @param keys output times of the keytimes
 */
export function heardIn(
  playback: PlaybackState,
  knots: Knots,
  inputEnd: number,
  media: MediaFile,
  rate: number,
  keys: readonly number[],
): Heard {
  const state: PlaybackState = { ...playback, rate: 0, loop: false };
  const [, start, end] = leading(state, knots, inputEnd);
  const first = outputStart(knots);
  // The leading clock at the knots of the warp: between them all is straight.
  const places = state.clock === "output" ? knots.outputTimes : clockAt(knots, first, state.linked);
  const moments = [...new Set([start, ...places, end])].filter((time) => time >= start && time <= end);
  moments.sort((a, b) => a - b);
  let at = seek(state, knots, inputEnd, start);
  const values = moments.map((time) => {
    at = seek(at, knots, inputEnd, time);
    return mediaTimeAt(media, knots, rate, at.outputTime);
  });
  // Where the input leads, keytimes are where its own clock has them, and nothing is to be met.
  const exact = state.clock === "output" ? keys.filter((key) => key > start && key < end) : [];
  return {
    times: moments.map((time) => time - start),
    values,
    keys: exact.map((key) => key - start).sort((a, b) => a - b),
  };
}

/** The input's clock at the knots: linked it shows their poses, else it runs along with the output's. */
function clockAt({ outputTimes, inputTimes }: Knots, first: number, linked: boolean): Float64Array {
  return linked ? inputTimes : outputTimes.map((time) => time - first);
}
