/** Where an axis of time has its marks, in the units that are shown, and what stands at them. */

import { ticks, timeLabel, type View } from "../scale";
import { timecode, timecodeFrames, type Units } from "../units";

export interface TimeTicks {
  readonly values: readonly number[];
  label(value: number): string;
}

/** Frames between marks within a second, and seconds between marks beyond it. */
const SECONDS = [1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600];

/** At most `most` marks of a view. */
export function timeTicks(view: View, most: number, rate: number, units: Units): TimeTicks {
  if (units === "seconds") {
    const { values, step } = ticks(view, most);
    return { values, label: (value) => `${timeLabel(value, step)} s` };
  }
  if (units === "frames") {
    const { values } = ticks({ from: view.from * rate, to: view.to * rate }, most);
    const whole = [...new Set(values.map((value) => Math.round(value)))];
    return { values: whole.map((value) => value / rate), label: (value) => `${Math.round(value * rate)}f` };
  }
  const counted = timecodeFrames(rate) ?? Math.max(1, Math.round(rate));
  const frames = ((view.to - view.from) * rate) / Math.max(most, 1);
  const steps = [...divisors(counted), ...SECONDS.map((seconds) => seconds * counted)];
  const step = steps.find((one) => one >= frames) ?? 3600 * counted * Math.ceil(frames / (3600 * counted));
  const values: number[] = [];
  for (let i = Math.ceil((view.from * rate) / step - 1e-9); i * step <= view.to * rate + 1e-9; i++)
    values.push((i * step) / rate);
  // An axis within the first hour need not say so at each mark.
  const isLong = Math.max(Math.abs(view.from), Math.abs(view.to)) >= 3600;
  return { values, label: (value) => timecode(value, rate).replace(/^00:/u, isLong ? "00:" : "") };
}

/** Numbers of frames that a second is made of evenly, the second itself left out. */
function divisors(counted: number): number[] {
  return Array.from({ length: counted - 1 }, (_, i) => i + 1).filter((n) => counted % n === 0);
}
