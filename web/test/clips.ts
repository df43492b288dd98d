/** Clips and curves to try the page with. */

import type { Clip, Curve } from "../src/messages";

/** A clip of 41 frames at 10 a second, without a figure. */
export function clipOf(change: Partial<Clip>): Clip {
  return {
    type: "clip",
    what: "clip",
    index: 0,
    count: 1,
    name: "made",
    holds: "motion",
    rate: 10,
    n_frames: 41,
    n_nodes: 0,
    first_frame: 0,
    start_time: 0,
    n_whole: 41,
    counterparts: [],
    camera: new Float32Array(),
    names: [],
    parents: [],
    positions: new Float32Array(),
    values: new Float64Array(),
    kinds: [],
    flights: new Float64Array(),
    feet: [],
    contacts: new Float64Array(),
    ...change,
  };
}

/** The curve of a warp that plays 4 s twice as fast. */
export const CURVE: Curve = {
  type: "curve",
  revision: 1,
  rate: 10,
  n_output: 21,
  method: "guided",
  analysis_rate: 10,
  max_skip: 8,
  upsample: 1,
  evenness: 0,
  keep_flights: 0,
  total: 1,
  lower_bound: 1,
  optimal: true,
  solve_ms: 1,
  key_output_times: Float64Array.of(0, 2),
  key_input_times: Float64Array.of(0, 4),
  output_times: Float64Array.of(0, 2),
  input_times: Float64Array.of(0, 4),
  linear_output_times: Float64Array.of(0, 2),
  linear_input_times: Float64Array.of(0, 4),
  spline_output_times: Float64Array.of(0, 2),
  spline_input_times: Float64Array.of(0, 4),
  costs: new Float64Array(),
  given_up: [],
  spoken_share: null,
  unspoken: new Float64Array(),
  example_warnings: [],
  hand_output_times: new Float64Array(),
  hand_input_times: new Float64Array(),
};
