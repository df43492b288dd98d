/** A document with nothing done to it. */

import type { Document } from "../src/messages";

export const EMPTY: Document = {
  clips: [
    { path: "walk.bvh", role: "search", first_frame: null, last_frame: null, fps: null, skeleton: null, up: null },
  ],
  references: [],
  keys: [],
  locks: [],
  length: null,
  min_length: null,
  max_length: null,
  free_weight: "neutral",
  influence: 1,
  options: {
    method: "guided",
    rate: null,
    max_skip: null,
    upsample: null,
    slowest: null,
    fastest: null,
    smoothness: 0,
    smoothing: null,
    n_neighbors: null,
    time_scale: null,
    low_pass: null,
    features: null,
    score: "joint",
    loop: false,
    average: true,
  },
  kept: [],
};
