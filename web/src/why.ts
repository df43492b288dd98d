/** Why the curve is as it is at a time: rows of the server's explanation, in a person's words. */

import { BINDINGS, type Why } from "./messages";
import { clamp } from "./scale";
import { at } from "./warp";

/** The row nearest to an output time. */
export function rowAt(why: Why, outputTime: number): number {
  const n = why.n_output;
  if (n < 2) return 0;
  const start = at(why.output_times, 0);
  const step = (at(why.output_times, n - 1) - start) / (n - 1);
  return clamp(Math.round((outputTime - start) / step), 0, n - 1);
}

export interface Match {
  readonly name: string;
  /** Place in the document's references; -1 for the clip itself. */
  readonly source: number;
  readonly mirrored: boolean;
  /** Seconds of the reference. */
  readonly time: number;
}

/** The reference frames that a row was matched with, the nearest first. */
export function matchesAt(why: Why, row: number): Match[] {
  const found: Match[] = [];
  for (let i = row * why.n_neighbors; i < (row + 1) * why.n_neighbors; i++) {
    const which = at(why.matched, i);
    if (which < 0) continue;
    found.push({
      name: why.references[which] ?? "",
      source: why.sources[which] ?? -1,
      mirrored: why.mirrored[which] ?? false,
      time: at(why.matched_times, i),
    });
  }
  return found;
}

export function nearestMatch(why: Why, outputTime: number): Match | null {
  return matchesAt(why, rowAt(why, outputTime))[0] ?? null;
}

const WORDS: Record<(typeof BINDINGS)[number], string> = {
  key: "a keytime",
  tangent: "the speed set at a keytime",
  hold: "a hold between two keytimes",
  lock: "a lock",
  flight: "a jump, which keeps its own speed",
  even: "what moves beside it: hurry is shared out",
  fastest: "the fastest speed allowed",
  slowest: "the slowest speed allowed",
};

/** What bound a row, in words; none where nothing did. */
export function bindingWords(bits: number): string[] {
  return BINDINGS.filter((_, i) => bits & (1 << i)).map((name) => WORDS[name]);
}

/** The scores in order, without the ends that have none: to say where one lies among them. */
export function rankedScores(why: Why): Float64Array {
  return why.scores.filter((score) => Number.isFinite(score)).sort();
}

/** The share of scores that are below one. */
export function rank(ranked: Float64Array, score: number): number {
  let low = 0;
  let high = ranked.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (at(ranked, middle) < score) low = middle + 1;
    else high = middle;
  }
  return ranked.length > 1 ? low / (ranked.length - 1) : 0;
}
