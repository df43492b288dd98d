/** Keytimes that are dragged near a beat land on it. */

import type { Store } from "../store";
import { inputY, type Layout, outputX, type Scales } from "../timeline/layout";
import { clockOfBeats } from "./beside";

/** Pixels. */
const REACH = 7;

/**
 * The beat that a keytime is near to, if it is: its output time, or for beats of the take's own sound its input time.
 * `straight` is what it is dragged along alone.
 */
export function snapToBeat(
  store: Store,
  layout: Layout,
  scales: Scales,
  wanted: { readonly inputTime: number; readonly outputTime: number },
  straight: "time" | "pose" | null,
): { inputTime?: number; outputTime?: number } {
  const { document, view } = store;
  const { beats } = store.beside;
  if (!document || !beats || !view.snapBeats) return {};
  const { clock, offset } = clockOfBeats(document, store.rate);
  if (straight === (clock === "output" ? "pose" : "time")) return {};
  const pixels = (time: number): number =>
    clock === "output" ? outputX(layout, scales, time) : inputY(layout, scales, time);
  const here = pixels(clock === "output" ? wanted.outputTime : wanted.inputTime);
  let best: number | null = null;
  let away = REACH;
  for (const time of beats.times) {
    const distance = Math.abs(pixels(time + offset) - here);
    if (distance <= away) [best, away] = [time + offset, distance];
  }
  if (best === null) return {};
  return clock === "output" ? { outputTime: best } : { inputTime: best };
}
