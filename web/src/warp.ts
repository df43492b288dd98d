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

const knownSlopes = new WeakMap<Float64Array, Float64Array>();

/** Playback speed of each piece between knots; found once for each warp. */
export function slopes({ outputTimes, inputTimes }: Knots): Float64Array {
  let found = knownSlopes.get(inputTimes);
  if (!found) {
    found = new Float64Array(outputTimes.length - 1);
    for (let i = 0; i < found.length; i++) {
      found[i] = (at(inputTimes, i + 1) - at(inputTimes, i)) / (at(outputTimes, i + 1) - at(outputTimes, i));
    }
    knownSlopes.set(inputTimes, found);
  }
  return found;
}

/** Knots between which the input time does not turn round: from the first to the last of them, upward or downward. */
interface Run {
  readonly first: number;
  readonly last: number;
  readonly up: boolean;
}

const knownRuns = new WeakMap<Float64Array, readonly Run[]>();

/** The runs of a warp, found once; most warps are one. */
function runsOf(inputTimes: Float64Array): readonly Run[] {
  const known = knownRuns.get(inputTimes);
  if (known) return known;
  const runs: Run[] = [];
  let first = 0;
  // Which way it goes; 0 while it holds.
  let way = 0;
  for (let i = 1; i < inputTimes.length; i++) {
    const turn = Math.sign(at(inputTimes, i) - at(inputTimes, i - 1));
    if (turn * way < 0) {
      runs.push({ first, last: i - 1, up: way > 0 });
      first = i - 1;
      way = 0;
    }
    if (turn !== 0) way = turn;
  }
  runs.push({ first, last: inputTimes.length - 1, up: way >= 0 });
  knownRuns.set(inputTimes, runs);
  return runs;
}

/**
 * An output time at which the warp shows an input time; of several (a hold, a backward span) the one nearest to `near`.
 * Where none shows it, the output time whose pose comes nearest to it.
 */
export function outputAt({ outputTimes, inputTimes }: Knots, inputTime: number, near = 0): number {
  let best = at(outputTimes, 0);
  let bestMiss = Infinity;
  let bestAway = Infinity;
  for (const { first, last, up } of runsOf(inputTimes)) {
    const low = at(inputTimes, up ? first : last);
    const high = at(inputTimes, up ? last : first);
    const shown = Math.min(Math.max(inputTime, low), high);
    const miss = Math.abs(inputTime - shown);
    if (miss >= bestMiss + 1e-12) continue;
    // All moments of this run that show it: one, or the whole of a hold.
    const from = momentOf(outputTimes, inputTimes, shown, firstKnot(inputTimes, first, last, shown, up, true));
    const to = momentOf(outputTimes, inputTimes, shown, firstKnot(inputTimes, first, last, shown, up, false));
    const time = Math.min(Math.max(near, from), Math.max(from, to));
    const away = Math.abs(time - near);
    if (miss < bestMiss - 1e-12 || away < bestAway) {
      best = time;
      bestMiss = Math.min(miss, bestMiss);
      bestAway = away;
    }
  }
  return best;
}

/** Of a run, the first knot that has come to an input time, or the last one that has not gone past it. */
function firstKnot(
  inputTimes: Float64Array,
  first: number,
  last: number,
  value: number,
  up: boolean,
  begins: boolean,
): { readonly knot: number; readonly other: number } {
  let low = first;
  let high = last;
  const sign = up ? 1 : -1;
  while (low < high) {
    const middle = begins ? (low + high) >> 1 : (low + high + 1) >> 1;
    const ahead = sign * (at(inputTimes, middle) - value);
    if (begins) {
      if (ahead >= 0) high = middle;
      else low = middle + 1;
    } else if (ahead <= 0) low = middle;
    else high = middle - 1;
  }
  return { knot: low, other: begins ? Math.max(low - 1, first) : Math.min(low + 1, last) };
}

/** When an input time is shown between two neighbouring knots. */
function momentOf(
  outputTimes: Float64Array,
  inputTimes: Float64Array,
  value: number,
  { knot, other }: { readonly knot: number; readonly other: number },
): number {
  const a = at(inputTimes, knot);
  const b = at(inputTimes, other);
  if (a === value || a === b) return at(outputTimes, knot);
  const share = (value - a) / (b - a);
  return at(outputTimes, knot) + share * (at(outputTimes, other) - at(outputTimes, knot));
}

export function outputStart({ outputTimes }: Knots): number {
  return at(outputTimes, 0);
}

export function outputEnd({ outputTimes }: Knots): number {
  return at(outputTimes, outputTimes.length - 1);
}
