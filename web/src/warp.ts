/** The warp as the page evaluates it: a polyline from output time to input time, as `retime.warp.curve` defines it. */

export interface Knots {
  /** Seconds of output, strictly increasing. */
  readonly outputTimes: Float64Array;
  /** Seconds of input, one for each output time. */
  readonly inputTimes: Float64Array;
}

/** A number of an array that is known to be long enough. */
export function at(array: ArrayLike<number>, index: number): number {
  return array[index] as number;
}

/** The piece whose first knot is the last one at or before `time`, kept inside the polyline. */
export function pieceAt(times: ArrayLike<number>, time: number): number {
  let low = 0;
  let high = times.length - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (at(times, middle) <= time) low = middle;
    else high = middle;
  }
  return low;
}

/** The input time shown at an output time; held at the ends outside. */
export function inputAt({ outputTimes, inputTimes }: Knots, time: number): number {
  const last = outputTimes.length - 1;
  if (time <= at(outputTimes, 0)) return at(inputTimes, 0);
  if (time >= at(outputTimes, last)) return at(inputTimes, last);
  const i = pieceAt(outputTimes, time);
  const share = (time - at(outputTimes, i)) / (at(outputTimes, i + 1) - at(outputTimes, i));
  return at(inputTimes, i) + share * (at(inputTimes, i + 1) - at(inputTimes, i));
}

/** Playback speed at an output time; at a knot, that of the piece after it. */
export function speedAt({ outputTimes, inputTimes }: Knots, time: number): number {
  const i = pieceAt(outputTimes, time);
  return (at(inputTimes, i + 1) - at(inputTimes, i)) / (at(outputTimes, i + 1) - at(outputTimes, i));
}

/** Playback speed of each piece between knots. */
export function slopes({ outputTimes, inputTimes }: Knots): Float64Array {
  const found = new Float64Array(outputTimes.length - 1);
  for (let i = 0; i < found.length; i++) {
    found[i] = (at(inputTimes, i + 1) - at(inputTimes, i)) / (at(outputTimes, i + 1) - at(outputTimes, i));
  }
  return found;
}

/**
 * An output time at which the warp shows an input time; of several (a hold, a backward span) the one nearest to `near`.
 * Where none shows it, the output time whose pose comes nearest to it.
 */
export function outputAt({ outputTimes, inputTimes }: Knots, inputTime: number, near = 0): number {
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

export function outputStart({ outputTimes }: Knots): number {
  return at(outputTimes, 0);
}

export function outputEnd({ outputTimes }: Knots): number {
  return at(outputTimes, outputTimes.length - 1);
}
