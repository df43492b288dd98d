/** The scores, as a strip: pale is good. */

import { clamp } from "../../scale";
import { at, type Knots, outputEnd } from "../../warp";
import { rowAt } from "../../why";
import { outputTimeAt, outputX } from "../layout";
import { type Canvas, label } from "./canvas";

export function heat(canvas: Canvas, knots: Knots): void {
  const { pen, layout, scales, palette, store } = canvas;
  const { why, curve } = store;
  const strip = layout.heat;
  const within = (x: number): number => clamp(x, strip.x, strip.x + strip.width);
  const start = within(outputX(layout, scales, 0));
  const end = within(outputX(layout, scales, curve ? outputEnd(knots) : 0));
  pen.fillStyle = palette["heat-low"];
  pen.fillRect(start, strip.y, end - start, strip.height);
  if (!why || why.n_output < 3) {
    label(canvas, "no search, no scores", strip.x + 8, strip.y + strip.height / 2);
    return;
  }
  const { low, high } = rangeOf(why.scores);
  const colors = heatColors(palette["heat-low"], palette["heat-high"]);
  const colorAt = (x: number): string => {
    const score = at(why.scores, rowAt(why, outputTimeAt(layout, scales, x)));
    const share = clamp((score - low) / (high - low), 0, 1);
    return Number.isFinite(score) ? (colors[Math.round(share * (colors.length - 1))] ?? "") : palette["heat-low"];
  };
  // Rows are as wide as they come out; neighbours of one colour are one rectangle.
  let runStart = start;
  let runColor = "";
  const finishRun = (x: number): void => {
    if (!runColor) return;
    pen.fillStyle = runColor;
    pen.fillRect(runStart, strip.y, x - runStart, strip.height);
  };
  for (let x = Math.floor(start); x <= Math.ceil(end); x++) {
    const color = colorAt(x + 0.5);
    if (color === runColor) continue;
    finishRun(x);
    runStart = x;
    runColor = color;
  }
  finishRun(end);
}

const ranges = new WeakMap<Float64Array, { low: number; high: number }>();

/** The range of an explanation's scores, found once. */
function rangeOf(scores: Float64Array): { low: number; high: number } {
  const known = ranges.get(scores);
  if (known) return known;
  const found = scoreRange(scores);
  ranges.set(scores, found);
  return found;
}

/** From the 5th to the 95th of a hundred scores: one outlier does not make the rest pale. */
export function scoreRange(scores: Float64Array): { low: number; high: number } {
  const ordered = scores.filter((score) => Number.isFinite(score)).sort();
  const pick = (share: number): number => ordered[Math.round(share * (ordered.length - 1))] ?? 0;
  const low = pick(0.05);
  const high = pick(0.95);
  return { low, high: high > low ? high : low + 1 };
}

const mixed = new Map<string, string[]>();

/** Colours from one to another, mixed once. Both are written as #rrggbb. */
export function heatColors(low: string, high: string): string[] {
  const name = `${low} ${high}`;
  let colors = mixed.get(name);
  if (!colors) {
    const part = (color: string, i: number): number => Number.parseInt(color.slice(1 + 2 * i, 3 + 2 * i), 16);
    colors = Array.from({ length: 32 }, (_, n) => {
      const channels = [0, 1, 2].map((i) => Math.round(part(low, i) + (n / 31) * (part(high, i) - part(low, i))));
      return `rgb(${channels.join(" ")})`;
    });
    mixed.set(name, colors);
  }
  return colors;
}
