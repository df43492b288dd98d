/** Where the timeline's panels lie, and its scales. Pure geometry. */

import { clamp, toPixels, toValue, type View } from "../scale";

export interface Box {
  readonly x: number;
  readonly y: number;
  readonly width: number;
  readonly height: number;
}

export interface Layout {
  readonly width: number;
  readonly height: number;
  /** Output times along it. */
  readonly ruler: Box;
  /** The time map: output time to the right, input time upward. */
  readonly map: Box;
  /** Input times, and locks, beside the map. */
  readonly gutter: Box;
  readonly speed: Box;
  readonly heat: Box;
  /** When feet stand, and flights; without a figure it has no height. */
  readonly feet: Box;
  /** The sound beside the stage; without one it has no height. */
  readonly sound: Box;
  readonly reference: Box;
}

export const GUTTER = 72;
/** Heights, pixels. */
const RULER = 22;
const HEAT = 15;
const FEET = 17;
const SOUND = 30;
const REFERENCE = 30;
/** From a keytime to an end of its tangent. */
const TANGENT = 46;

export function layoutOf(width: number, height: number, { hasFeet = false, hasSound = false } = {}): Layout {
  const wide = Math.max(width - GUTTER - 10, 40);
  const feetHeight = hasFeet ? FEET : 0;
  const feetRoom = hasFeet ? FEET + 4 : 0;
  const soundHeight = hasSound ? SOUND : 0;
  const soundRoom = hasSound ? SOUND + 4 : 0;
  const rest = Math.max(height - RULER - HEAT - feetRoom - soundRoom - REFERENCE - 12, 80);
  const speedHeight = Math.round(clamp(rest * 0.36, 48, 150));
  const map = { x: GUTTER, y: RULER, width: wide, height: rest - speedHeight };
  const speed = { x: GUTTER, y: map.y + map.height + 4, width: wide, height: speedHeight };
  const heat = { x: GUTTER, y: speed.y + speed.height + 4, width: wide, height: HEAT };
  const feet = { x: GUTTER, y: heat.y + heat.height + 4, width: wide, height: feetHeight };
  const sound = { x: GUTTER, y: heat.y + heat.height + 4 + feetRoom, width: wide, height: soundHeight };
  const reference = { x: GUTTER, y: sound.y + soundRoom, width: wide, height: REFERENCE };
  return {
    width,
    height,
    ruler: { x: GUTTER, y: 0, width: wide, height: RULER },
    map,
    gutter: { x: 0, y: map.y, width: GUTTER, height: map.height },
    speed,
    heat,
    feet,
    sound,
    reference,
  };
}

/** The scales in use: output time, input time, and the binary logarithm of speed. */
export interface Scales {
  readonly output: View;
  readonly input: View;
  readonly speed: View;
}

export function outputX(layout: Layout, scales: Scales, time: number): number {
  return layout.map.x + toPixels(scales.output, layout.map.width, time);
}

export function inputY(layout: Layout, scales: Scales, time: number): number {
  return layout.map.y + layout.map.height - toPixels(scales.input, layout.map.height, time);
}

export function speedY(layout: Layout, scales: Scales, speed: number): number {
  // A log axis has no place for holds and reversals: they run along its lower edge.
  const level = clamp(Math.log2(Math.max(speed, 1e-9)), scales.speed.from, scales.speed.to);
  return layout.speed.y + layout.speed.height - toPixels(scales.speed, layout.speed.height, level);
}

export function outputTimeAt(layout: Layout, scales: Scales, x: number): number {
  return toValue(scales.output, layout.map.width, x - layout.map.x);
}

export function inputTimeAt(layout: Layout, scales: Scales, y: number): number {
  return toValue(scales.input, layout.map.height, layout.map.y + layout.map.height - y);
}

export function speedAtY(layout: Layout, scales: Scales, y: number): number {
  return 2 ** toValue(scales.speed, layout.speed.height, layout.speed.y + layout.speed.height - y);
}

/** The line from a keytime to the end of its tangent, for a speed there: pixels to the right, and downward. */
export function tangentArm(layout: Layout, scales: Scales, speed: number): [number, number] {
  const dx = layout.map.width / (scales.output.to - scales.output.from);
  const dy = (-speed * layout.map.height) / (scales.input.to - scales.input.from);
  const length = Math.hypot(dx, dy);
  return [(TANGENT * dx) / length, (TANGENT * dy) / length];
}

export function inside(box: Box, x: number, y: number): boolean {
  return x >= box.x && x <= box.x + box.width && y >= box.y && y <= box.y + box.height;
}

/** All of the output, with room to pull its end out; and all that one may zoom out to. */
export function wholeOutput(outputEnd: number, inputEnd: number): { home: View; whole: View } {
  const longest = Math.max(outputEnd, inputEnd);
  return {
    home: { from: -0.012 * outputEnd, to: 1.06 * outputEnd },
    whole: { from: -0.02 * longest, to: 1.6 * longest },
  };
}

/** Speeds shown: wide enough for the curve, never less than from 1/2 to 3, and never more than from 1/16 to 16. */
export function speedView(speeds: ArrayLike<number>): View {
  let low = -1;
  let high = Math.log2(3);
  for (let i = 0; i < speeds.length; i++) {
    const speed = speeds[i] as number;
    if (speed <= 0) continue;
    low = Math.min(low, Math.log2(speed));
    high = Math.max(high, Math.log2(speed));
  }
  return { from: Math.max(low, -4) - 0.25, to: Math.min(high, 4) + 0.25 };
}

/** The input times to show so that what is in view of the map fills it. */
export function inputView(low: number, high: number, end: number): View {
  const width = Math.max(high - low, 0.02 * end, 1e-3);
  const margin = 0.07 * width;
  const middle = (low + high) / 2;
  return { from: middle - width / 2 - margin, to: middle + width / 2 + margin };
}
