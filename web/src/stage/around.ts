/** Trails and onion skins: what the output shows a little before and after the frame that is looked at. */

import { inputAt, type Knots, outputEnd, outputStart } from "../warp";
import type { Cast } from "./cast";

/** Seconds of output to each side of the playhead that they cover, and between onion skins. */
const AROUND = 1.2;
const ONION_STEP = 0.2;
/** Seconds between the dots of a trail at least: of faster clips they would lie on top of each other. */
const TRAIL_STEP = 1 / 30;

export interface Shown {
  readonly trails: boolean;
  readonly onion: boolean;
}

/** Draw them for one clip, whose frames come `rate` times a second. */
export function showAround(cast: Cast, knots: Knots, outputTime: number, rate: number, shown: Shown): void {
  cast.trails.object.visible = shown.trails;
  if (!shown.onion) cast.showOnion(null);
  if (shown.trails) {
    const { times, nearness } = around(knots, outputTime, Math.max(1 / rate, TRAIL_STEP));
    cast.trails.show(times, nearness);
  }
  if (shown.onion) {
    const { times, nearness, outputs } = around(knots, outputTime, ONION_STEP);
    const skins = times.map((time, i) => ({
      time,
      near: nearness[i] as number,
      isLater: (outputs[i] as number) > outputTime,
    }));
    // The one at the playhead is the figure itself.
    cast.showOnion(skins.filter((_, i) => Math.abs((outputs[i] as number) - outputTime) > ONION_STEP / 4));
  }
}

/** Input times shown at whole multiples of a step, and how near those are: from 0 to 0.9. */
function around(
  knots: Knots,
  outputTime: number,
  step: number,
): { times: number[]; nearness: number[]; outputs: number[] } {
  const low = Math.max(outputStart(knots), outputTime - AROUND);
  const high = Math.min(outputEnd(knots), outputTime + AROUND);
  const times: number[] = [];
  const nearness: number[] = [];
  const outputs: number[] = [];
  for (let i = Math.ceil(low / step - 1e-6); i <= Math.floor(high / step + 1e-6); i++) {
    outputs.push(i * step);
    times.push(inputAt(knots, i * step));
    nearness.push(0.9 * (1 - Math.abs(i * step - outputTime) / AROUND) ** 0.7 || 0);
  }
  return { times, nearness, outputs };
}
