/** Influence over time: a line through points, painted on the timeline or typed as on the command line. */

import { GrammarError, parseTime } from "./grammar";
import type { Document, InfluencePoint } from "./messages";
import { clamp } from "./scale";

/** A point that is nearer than this to the line through its neighbours says nothing. */
const TOLERANCE = 0.006;

/** The influence that holds at a time: of the curve, or everywhere the same. */
export function influenceAt({ influence, options }: Document, time: number): number {
  const [first] = influence;
  if (!first) return typeof options.influence === "number" ? options.influence : 1;
  const next = influence.findIndex((point) => point.time > time);
  if (next === 0) return first.share;
  const before = influence[(next < 0 ? influence.length : next) - 1] as InfluencePoint;
  const after = influence[next];
  if (!after) return before.share;
  const share = (time - before.time) / (after.time - before.time);
  return before.share + share * (after.share - before.share);
}

/** Where a hand went on the row. */
export interface Spot {
  readonly time: number;
  readonly share: number;
}

/**
 * Paint a straight stroke from one spot to another; before and after it, `edge` seconds away, all is as it was. The
 * curve reaches from 0 to `end`.
 */
export function painted(document: Document, from: Spot, to: Spot, end: number, edge: number): Document {
  const [left, right] = from.time <= to.time ? [from, to] : [to, from];
  const at = (time: number): InfluencePoint => ({ time, share: influenceAt(document, time) });
  const kept = document.influence.length > 0 ? document.influence : [at(0), at(end)];
  const low = clamp(left.time, 0, end);
  const high = clamp(right.time, 0, end);
  const points = [
    ...kept.filter((point) => point.time < low - edge),
    ...(low - edge > 0 ? [at(low - edge)] : []),
    { time: low, share: clamp(left.share, 0, 1) },
    ...(high > low ? [{ time: high, share: clamp(right.share, 0, 1) }] : []),
    ...(high + edge < end ? [at(high + edge)] : []),
    ...kept.filter((point) => point.time > high + edge),
  ];
  return {
    ...document,
    influence: simplified(points.filter((point, i) => i === 0 || point.time > (points[i - 1] as Spot).time)),
  };
}

/** Leave out points that the line through the others meets anyway (Ramer, Douglas, Peucker; by share alone). */
export function simplified(points: readonly InfluencePoint[]): InfluencePoint[] {
  if (points.length < 3) return [...points];
  const first = points[0] as InfluencePoint;
  const last = points.at(-1) as InfluencePoint;
  let farthest = 0;
  let away = TOLERANCE;
  points.forEach((point, i) => {
    const line = first.share + ((point.time - first.time) / (last.time - first.time)) * (last.share - first.share);
    if (Math.abs(point.share - line) > away) [farthest, away] = [i, Math.abs(point.share - line)];
  });
  if (farthest === 0) return [first, last];
  return [...simplified(points.slice(0, farthest + 1)).slice(0, -1), ...simplified(points.slice(farthest))];
}

/** Read `0s=0, 2s=1`: output times, and how much the search has to say there. */
export function parseInfluence(text: string, rate: number): InfluencePoint[] {
  if (text.trim() === "") return [];
  const points = text.split(",").map((part) => {
    const [time = "", share = "", ...more] = part.split("=");
    const value = /^\s*(\d+(\.\d*)?|\.\d+)\s*(%?)\s*$/u.exec(share);
    const number = value ? Number(value[1]) / (value[3] === "%" ? 100 : 1) : Number.NaN;
    if (more.length > 0 || !(number >= 0 && number <= 1))
      throw new GrammarError(
        `expected times and shares from 0 to 1, such as 0s=0, 2s=1; found '${part.trim().slice(0, 40)}'`,
      );
    return { time: parseTime(time, rate), share: number };
  });
  points.forEach((point, i) => {
    if (i > 0 && point.time <= (points[i - 1] as InfluencePoint).time)
      throw new GrammarError("expected times that increase");
  });
  return points;
}

export function influenceText(points: readonly InfluencePoint[]): string {
  return points.map(({ time, share }) => `${Number(time.toFixed(3))}s=${Number(share.toFixed(2))}`).join(", ");
}
