/** The literal way to find when a warp shows an input time: look at all pieces. */

import { at, type Knots } from "../src/warp";

export function outputByScan({ outputTimes, inputTimes }: Knots, inputTime: number, near = 0): number {
  let best = at(outputTimes, 0);
  let bestMiss = Infinity;
  let bestAway = Infinity;
  const consider = (time: number, miss: number): void => {
    const away = Math.abs(time - near);
    if (miss < bestMiss - 1e-12 || (miss < bestMiss + 1e-12 && away < bestAway)) {
      best = time;
      bestMiss = Math.min(miss, bestMiss);
      bestAway = away;
    }
  };
  for (let i = 0; i + 1 < outputTimes.length; i++) {
    const a = at(inputTimes, i);
    const b = at(inputTimes, i + 1);
    const from = at(outputTimes, i);
    const to = at(outputTimes, i + 1);
    if (a === b) consider(Math.min(Math.max(near, from), to), Math.abs(inputTime - a));
    else {
      const share = Math.min(Math.max((inputTime - a) / (b - a), 0), 1);
      consider(from + share * (to - from), Math.abs(inputTime - (a + share * (b - a))));
    }
  }
  return best;
}

/** Numbers that look random and are the same in each run; Mulberry32. */
export function randomNumbers(seed: number): () => number {
  let state = seed;
  return () => {
    state = (state + 0x6d2b79f5) | 0;
    let mixed = Math.imul(state ^ (state >>> 15), 1 | state);
    mixed = (mixed + Math.imul(mixed ^ (mixed >>> 7), 61 | mixed)) ^ mixed;
    return ((mixed ^ (mixed >>> 14)) >>> 0) / 2 ** 32;
  };
}
