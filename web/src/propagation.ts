/** Propagation: a stretch that was retimed by hand is the example, and the rest of the clip follows. */

import type { Document, Example } from "./messages";
import { clamp } from "./scale";
import { spanText, type Units } from "./units";

/** The stretch of the input that was retimed by hand, as its keytimes and locks tell; null where there is none. */
export function retimedStretch({ keys, locks }: Document, inputEnd: number): Example | null {
  const times = [...keys.map((key) => key.input_time), ...locks.flatMap((lock) => [lock.start, lock.end])];
  if (times.length === 0) return null;
  // One moment alone ends a stretch that began with the clip.
  const low = Math.min(...times);
  const high = Math.max(...times);
  const start = high > low ? low : 0;
  const example = { start: clamp(start, 0, inputEnd), end: clamp(high, 0, inputEnd) };
  return example.end > example.start ? example : null;
}

export function setExample(document: Document, example: Example | null): Document {
  return { ...document, example };
}

/** Stretches in a few words: "5.33 to 7.27 s, 10.43 to 12.50 s". */
export function stretchesText(pairs: ArrayLike<number>, rate: number, units: Units): string {
  const words: string[] = [];
  for (let i = 0; i + 1 < pairs.length; i += 2) {
    words.push(spanText(pairs[i] as number, pairs[i + 1] as number, rate, units));
  }
  return words.join(", ");
}

/** Whether an input time lies in one of some stretches. */
export function isWithin(pairs: ArrayLike<number>, time: number): boolean {
  for (let i = 0; i + 1 < pairs.length; i += 2) {
    if ((pairs[i] as number) <= time && time <= (pairs[i + 1] as number)) return true;
  }
  return false;
}
