/** How times are shown: seconds, frames or timecode. What is shown can be typed again, in the one grammar. */

export type Units = "seconds" | "frames" | "timecode";

export const UNITS: readonly Units[] = ["seconds", "frames", "timecode"];

/** What times are shown by: the units that were chosen, and the first clip's frames a second. */
export interface Shown {
  readonly view: { readonly units: Units };
  readonly rate: number;
}

/** Frames are counted as whole, where they are as near to it as what a file rounds. */
const NEAR = 1e-4;

/** Frames that timecode counts in a second; null at a rate that has none. */
export function timecodeFrames(rate: number): number | null {
  for (const counted of [Math.round(rate), Math.round(rate * 1.001)]) {
    const ratio = rate / counted;
    if (counted > 0 && (Math.abs(ratio - 1) < 1e-9 || Math.abs(ratio * 1.001 - 1) < 1e-7)) return counted;
  }
  return null;
}

/** The timecode of the nearest frame, without drop-frame. */
export function timecode(seconds: number, rate: number): string {
  const counted = timecodeFrames(rate) ?? Math.max(1, Math.round(rate));
  const all = Math.round(Math.abs(seconds) * rate);
  const whole = Math.floor(all / counted);
  const two = (value: number, wide = 2): string => String(value).padStart(wide, "0");
  const digits = String(counted - 1).length;
  const parts = [two(Math.floor(whole / 3600)), two(Math.floor(whole / 60) % 60), two(whole % 60)];
  return `${seconds < 0 && all > 0 ? "-" : ""}${parts.join(":")}:${two(all % counted, Math.max(2, digits))}`;
}

/** Frames as they are typed, with a fraction where there is one: `150f`, `150.25f`. */
export function framesText(seconds: number, rate: number): string {
  const frames = seconds * rate;
  const whole = Math.round(frames);
  return `${Math.abs(frames - whole) < NEAR ? whole : Number(frames.toFixed(2))}f`;
}

/** A time as a field shows it. */
export function fieldTime(seconds: number, rate: number, units: Units, digits = 3): string {
  if (units === "frames") return framesText(seconds, rate);
  return units === "timecode" ? timecode(seconds, rate) : seconds.toFixed(digits);
}

/** A time as it is said: in a label, a caption, a reason. */
export function saidTime(seconds: number, rate: number, units: Units, digits = 2): string {
  if (units === "frames") return framesText(seconds, rate);
  return units === "timecode" ? timecode(seconds, rate) : `${seconds.toFixed(digits)} s`;
}

/** The units in use: at a rate that has no timecode frames stand in for it. */
export function unitsOf({ view, rate }: Shown): Units {
  return view.units === "timecode" && timecodeFrames(rate) === null ? "frames" : view.units;
}

/** The units after those in use. */
export function nextUnits(store: Shown): Units {
  const all: readonly Units[] = timecodeFrames(store.rate) === null ? ["seconds", "frames"] : UNITS;
  return all[(all.indexOf(unitsOf(store)) + 1) % all.length] as Units;
}

/** A time of the first clip's clock, as a field shows it. */
export function inField(store: Shown, seconds: number, digits = 3): string {
  return fieldTime(seconds, store.rate, unitsOf(store), digits);
}

/** A time of the first clip's clock, as it is said. */
export function said(store: Shown, seconds: number, digits = 2): string {
  return saidTime(seconds, store.rate, unitsOf(store), digits);
}

/** From one time to another, as it is said: `6.12 to 6.53 s`, `367f to 392f`. */
export function spanText(start: number, end: number, rate: number, units: Units): string {
  if (units === "seconds") return `${start.toFixed(2)} to ${end.toFixed(2)} s`;
  return `${saidTime(start, rate, units)} to ${saidTime(end, rate, units)}`;
}

/** A stretch of the first clip's clock, as it is said. */
export function saidSpan(store: Shown, { start, end }: { readonly start: number; readonly end: number }): string {
  return spanText(start, end, store.rate, unitsOf(store));
}

/** A rate as people write it: 60 Hz, 29.97 Hz. */
export function rateText(rate: number): string {
  return `${Number(rate.toFixed(3))} Hz`;
}
