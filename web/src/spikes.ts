/** Where a curve plays much faster than on the whole, and a limit that takes it away. */

import type { Document } from "./messages";
import { at, type Knots, outputEnd, outputStart, slopes } from "./warp";

export interface Spike {
  /** The fastest that it plays, and when. */
  readonly speed: number;
  readonly time: number;
  /** A limit that leaves room for the length, as people type it. */
  readonly limit: number;
}

/** Speeds that people would type. */
const ROUND = [1.25, 1.5, 2, 2.5, 3, 4, 5, 6, 8];
/** A spike is so many times as fast as the whole; a limit leaves the search so much room. */
const SPIKE = 2.5;
const ROOM = 1.5;

/** The worst spike of a curve that has no limit yet; null where there is none. */
export function spikeOf(document: Document, knots: Knots): Spike | null {
  if (document.options.speed !== undefined || document.method === "linear" || document.method === "spline") return null;
  const speeds = slopes(knots);
  let worst = 0;
  for (let i = 0; i < speeds.length; i++) if (at(speeds, i) > at(speeds, worst)) worst = i;
  const { inputTimes, outputTimes } = knots;
  const mean =
    Math.abs(at(inputTimes, inputTimes.length - 1) - at(inputTimes, 0)) / (outputEnd(knots) - outputStart(knots));
  const speed = at(speeds, worst);
  if (!(speed > SPIKE * Math.max(mean, 1))) return null;
  const limit = ROUND.find((one) => one >= ROOM * mean);
  return limit === undefined || limit >= speed ? null : { speed, time: at(outputTimes, worst), limit };
}
