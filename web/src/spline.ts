/** The spline through a curve's keytimes, as `retime.warp.spline` works it out. */

import type { Curve } from "./messages";
import { at, type Knots } from "./warp";

/** Seconds: a knot closer than this to a keytime is that. */
const SAME_TIME = 1e-9;

export type SplineSpans = Pick<
  Curve,
  "rate" | "key_output_times" | "key_input_times" | "spline_begins" | "spline_ends"
>;

const known = new WeakMap<SplineSpans, Knots>();

/** The knots of the spline, as many a second as the output has frames; worked out once a curve. */
export function splineOf(curve: SplineSpans): Knots {
  let found = known.get(curve);
  if (!found) {
    found = sampled(curve);
    known.set(curve, found);
  }
  return found;
}

function sampled({ rate, key_output_times, key_input_times, spline_begins, spline_ends }: SplineSpans): Knots {
  const last = key_output_times.length - 1;
  const start = at(key_output_times, 0);
  const length = at(key_output_times, last) - start;
  const pieces = Math.max(1, Math.round(length * rate));
  const outputTimes = new Float64Array(pieces + key_output_times.length);
  const inputTimes = new Float64Array(outputTimes.length);
  let n = 0;
  const put = (output: number, input: number): void => {
    outputTimes[n] = output;
    inputTimes[n++] = input;
  };
  let knot = 0;
  for (let span = 0; span < last; span++) {
    const [from, to] = [at(key_output_times, span), at(key_output_times, span + 1)];
    const [first, then] = [at(key_input_times, span), at(key_input_times, span + 1)];
    const [begins, ends] = [at(spline_begins, span), at(spline_ends, span)];
    const width = to - from;
    const mean = (then - first) / width;
    const excess = (begins + ends - 2 * mean) / width;
    const [square, cubic] = [(mean - begins) / width - excess, excess / width];
    put(from, first);
    for (; knot <= pieces; knot++) {
      const time = start + knot * (length / pieces);
      if (time <= from + SAME_TIME) continue;
      if (time >= to - SAME_TIME) break;
      const t = time - from;
      put(time, first + begins * t + square * (t * t) + cubic * (t * t * t));
    }
  }
  put(at(key_output_times, last), at(key_input_times, last));
  return { outputTimes: outputTimes.subarray(0, n), inputTimes: inputTimes.subarray(0, n) };
}
