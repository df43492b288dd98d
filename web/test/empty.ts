/** A document with nothing done to it. */

import type { Document } from "../src/messages";

export const EMPTY: Document = {
  clips: [
    {
      path: "walk.bvh",
      role: "search",
      first_frame: null,
      last_frame: null,
      fps: null,
      skeleton: null,
      up: null,
      root: null,
      channels: null,
      gaps: null,
      offset: null,
    },
  ],
  references: [],
  keys: [],
  locks: [],
  method: "guided",
  repeat: 1,
  flights: [],
  example: null,
  average: true,
  options: {},
  kept: [],
  influence: [],
  media: null,
  beats: null,
  markers: [],
  work_area: null,
};
