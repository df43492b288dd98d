/** What of a clip is used. Trimming the first one moves all that is told in its time along with its frames. */

import { changeClip } from "./document";
import type { Clip, ClipFile, Document } from "./messages";

/** The stretch used of a file, seconds from its first frame. */
export interface Trim {
  readonly start: number;
  readonly end: number;
  /** The last frame of the file. */
  readonly last: number;
}

/** The number that its file gives its first frame. */
function firstOf({ first_frame, start_time, rate }: Clip): number {
  return first_frame - Math.round(start_time * rate);
}

/** What the document says is used of a clip, which comes after it. */
export function trimOf(file: ClipFile, clip: Clip): Trim {
  const seconds = (frame: number): number => (frame - firstOf(clip)) / clip.rate;
  const last = (clip.n_whole - 1) / clip.rate;
  return {
    start: file.first_frame === null ? 0 : seconds(file.first_frame),
    end: file.last_frame === null ? last : Math.min(seconds(file.last_frame), last),
    last,
  };
}

/**
 * Use a clip from one time of its file to another. Of the first clip keytimes, locks, flights, markers and the example
 * stay with the frames that they were put on; what lies wholly outside of what is used now is gone.
 */
export function trimClip(document: Document, index: number, clip: Clip, start: number, end: number): Document {
  const { rate, n_whole } = clip;
  const ownFirst = firstOf(clip);
  const file = document.clips[index];
  if (!file) return document;
  const [first, last] = [Math.round(start * rate), Math.round(end * rate)];
  const next = changeClip(document, index, {
    first_frame: first === 0 ? null : first + ownFirst,
    last_frame: last === n_whole - 1 ? null : last + ownFirst,
  });
  if (index !== 0) return next;
  const by = trimOf(file, clip).start - first / rate;
  const length = (last - first) / rate;
  const isInside = (time: number): boolean => time > -1e-9 && time < length + 1e-9;
  const held = (time: number): number => Math.min(Math.max(time, 0), length);
  const shifted = <T extends { readonly start: number; readonly end: number }>(spans: readonly T[]): T[] =>
    spans
      .map((span) => ({ ...span, start: held(span.start + by), end: held(span.end + by) }))
      .filter((span) => span.end - span.start > 1.5 / rate);
  const [example] = next.example ? shifted([next.example]) : [];
  return {
    ...next,
    keys: next.keys
      .map((key) => ({ ...key, input_time: key.input_time + by }))
      .filter((key) => isInside(key.input_time)),
    locks: shifted(next.locks),
    flights: shifted(next.flights),
    example: example ?? null,
    markers: next.markers
      .map((marker) => (marker.on === "input" ? { ...marker, time: marker.time + by } : marker))
      .filter((marker) => marker.on === "output" || isInside(marker.time)),
  };
}
