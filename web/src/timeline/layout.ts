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
  /** Influence over time; where it is the same everywhere it has no height. */
  readonly influence: Box;
  /** The sound beside the stage; without one it has no height. */
  readonly sound: Box;
  readonly reference: Box;
  /** Which line is which, and what of the output is in view. */
  readonly foot: Box;
}

export const GUTTER = 72;
/** Heights, pixels. */
const RULER = 28;
const HEAT = 13;
const FEET = 17;
const INFLUENCE = 34;
const SOUND = 30;
const REFERENCE = 30;
const FOOT = 18;
/** Of what the map and the speed have together, the speed gets this, within bounds. */
const SPEED_SHARE = 0.22;
/** From a keytime to an end of its tangent. */
const TANGENT = 46;

export function layoutOf(
  width: number,
  height: number,
  { hasFeet = false, hasSound = false, hasInfluence = false } = {},
): Layout {
  const wide = Math.max(width - GUTTER - 10, 40);
  const feetHeight = hasFeet ? FEET : 0;
  const feetRoom = hasFeet ? FEET + 4 : 0;
  const influenceHeight = hasInfluence ? INFLUENCE : 0;
  const influenceRoom = hasInfluence ? INFLUENCE + 4 : 0;
  const soundHeight = hasSound ? SOUND : 0;
  const soundRoom = hasSound ? SOUND + 4 : 0;
  const rest = Math.max(height - RULER - HEAT - feetRoom - influenceRoom - soundRoom - REFERENCE - FOOT - 12, 80);
  const speedHeight = Math.round(clamp(rest * SPEED_SHARE, Math.min(60, rest / 2), 150));
  const map = { x: GUTTER, y: RULER, width: wide, height: rest - speedHeight };
  const speed = { x: GUTTER, y: map.y + map.height + 4, width: wide, height: speedHeight };
  const heat = { x: GUTTER, y: speed.y + speed.height + 4, width: wide, height: HEAT };
  const feet = { x: GUTTER, y: heat.y + heat.height + 4, width: wide, height: feetHeight };
  const influence = { x: GUTTER, y: heat.y + heat.height + 4 + feetRoom, width: wide, height: influenceHeight };
  const sound = { x: GUTTER, y: influence.y + influenceRoom, width: wide, height: soundHeight };
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
    influence,
    sound,
    reference,
    foot: { x: 8, y: reference.y + REFERENCE, width: Math.max(width - 16, 40), height: FOOT },
  };
}

/** The scales in use: output time, input time, and the level of speed. */
export interface Scales {
  readonly output: View;
  readonly input: View;
  readonly speed: View;
  /** What is in view of what there is to see, from 0 to 1: the reference is shown as closely. */
  readonly share: View;
}

/** Speeds below this are drawn as far apart as they are; above it, by their logarithm. */
const SLOW = 1 / 32;

/**
 * Where a speed stands on its axis: nearly its binary logarithm, and 0 for a speed of 1. Holds and what plays backward
 * have a place too, in one smooth scale.
 */
export function speedLevel(speed: number): number {
  return (Math.asinh(speed / (2 * SLOW)) - UNIT) / Math.LN2;
}

export function levelSpeed(level: number): number {
  return 2 * SLOW * Math.sinh(level * Math.LN2 + UNIT);
}

const UNIT = Math.asinh(1 / (2 * SLOW));

export function outputX(layout: Layout, scales: Scales, time: number): number {
  return layout.map.x + toPixels(scales.output, layout.map.width, time);
}

export function inputY(layout: Layout, scales: Scales, time: number): number {
  return layout.map.y + layout.map.height - toPixels(scales.input, layout.map.height, time);
}

export function speedY(layout: Layout, scales: Scales, speed: number): number {
  const level = clamp(speedLevel(speed), scales.speed.from, scales.speed.to);
  return layout.speed.y + layout.speed.height - toPixels(scales.speed, layout.speed.height, level);
}

export function outputTimeAt(layout: Layout, scales: Scales, x: number): number {
  return toValue(scales.output, layout.map.width, x - layout.map.x);
}

export function inputTimeAt(layout: Layout, scales: Scales, y: number): number {
  return toValue(scales.input, layout.map.height, layout.map.y + layout.map.height - y);
}

export function speedAtY(layout: Layout, scales: Scales, y: number): number {
  return levelSpeed(toValue(scales.speed, layout.speed.height, layout.speed.y + layout.speed.height - y));
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

/**
 * Speeds shown: wide enough for the curve, in whole octaves, never less than from 1/2 to 4 and never more than 16 times,
 * forward or backward. What was shown before stays in view: the axis does not jump.
 */
export function speedView(speeds: ArrayLike<number>, before: View | null = null): View {
  let low = speedLevel(0.5);
  let high = speedLevel(4);
  for (let i = 0; i < speeds.length; i++) {
    const level = speedLevel(clamp(speeds[i] as number, -FASTEST_SHOWN, FASTEST_SHOWN));
    low = Math.min(low, level);
    high = Math.max(high, level);
  }
  // A hand that rounds is no reason for another octave.
  const from = Math.floor(low + 0.02) - 0.25;
  const to = Math.ceil(high - 0.02) + 0.25;
  return before ? { from: Math.min(from, before.from), to: Math.max(to, before.to) } : { from, to };
}

const FASTEST_SHOWN = 16;

/** What of the reference is in view: as large a share of it as of the output. */
export function referenceView(scales: Scales, lastTime: number): View {
  return { from: scales.share.from * lastTime, to: scales.share.to * lastTime };
}

/** The input times to show so that what is in view of the map fills it. */
export function inputView(low: number, high: number, end: number): View {
  const width = Math.max(high - low, 0.02 * end, 1e-3);
  const margin = 0.07 * width;
  const middle = (low + high) / 2;
  return { from: middle - width / 2 - margin, to: middle + width / 2 + margin };
}
