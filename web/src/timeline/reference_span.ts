/** A reference in its own time: all of it, and what of it is imitated. */

import type { Clip } from "../messages";
import { referencesOf } from "../references";
import { clamp } from "../scale";
import type { Store } from "../store";

export interface ReferenceSpan {
  /** Its place in the document; -1 where the document names none: then it is the clip itself. */
  readonly source: number;
  readonly clip: Clip;
  /** Time of its last frame, used or not, seconds. */
  readonly lastTime: number;
  /** What of it is imitated. */
  readonly start: number;
  readonly end: number;
  /** When a matched time of 0 lies in all of it. */
  readonly offset: number;
  /** The number that its file gives its first frame. */
  readonly firstFrame: number;
}

/** The reference that is shown, or another one. */
export function referenceSpan(store: Store, index = store.reference): ReferenceSpan | null {
  const own = store.clip;
  if (!own || !store.document || own.n_frames < 2) return null;
  if (store.document.references.length === 0) {
    const lastTime = (own.n_frames - 1) / own.rate;
    return { source: -1, clip: own, lastTime, start: 0, end: lastTime, offset: 0, firstFrame: own.first_frame };
  }
  const clip = store.references[index];
  if (!clip) return null;
  const file = store.document.references[index];
  const lastTime = (clip.n_whole - 1) / clip.rate;
  const firstFrame = clip.first_frame - Math.round(clip.start_time * clip.rate);
  // What the document says goes with the hand; the clip comes after it.
  const seconds = (frame: number): number => clamp((frame - firstFrame) / clip.rate, 0, lastTime);
  return {
    source: index,
    clip,
    lastTime,
    start: typeof file?.first_frame === "number" ? seconds(file.first_frame) : 0,
    end: typeof file?.last_frame === "number" ? seconds(file.last_frame) : lastTime,
    offset: clip.start_time,
    firstFrame,
  };
}

/** The range from one time to another, as the file numbers its frames; null where that is all of it. */
export function frameRange(span: ReferenceSpan, start: number, end: number): { first: number; last: number } | null {
  const frame = (seconds: number): number => Math.round(seconds * span.clip.rate) + span.firstFrame;
  const [first, last] = [frame(start), frame(end)];
  return first === span.firstFrame && last === frame(span.lastTime) ? null : { first, last };
}

/** What to call the references: those that are one name's are told apart by what of them is used. */
export function referenceNames(store: Store): string[] {
  if (!store.document) return [];
  const plain = referencesOf(store.document).map((file, i) =>
    file.path === null
      ? "The clip itself"
      : (store.references[i]?.name ?? file.path.split(/[\\/]/u).at(-1) ?? file.path),
  );
  return plain.map((name, i) => {
    if (plain.filter((other) => other === name).length < 2) return name;
    const span = referenceSpan(store, i);
    return span ? `${name}, ${span.start.toFixed(1)}–${span.end.toFixed(1)} s` : `${name} (${i + 1})`;
  });
}
