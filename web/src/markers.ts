/** Markers and the work area: functions from one document to the next. */

import { addKey, freshId } from "./document";
import type { Document, Marker, WorkArea } from "./messages";
import { clamp } from "./scale";
import { inputAt, type Knots, outputAt, outputEnd } from "./warp";

export type Axis = Marker["on"];

/** Seconds: closer than this, two times are one. */
const NEAR = 1e-6;

export function findMarker(document: Document, id: string | null): Marker | null {
  return document.markers.find((marker) => marker.id === id) ?? null;
}

/** Mark a time; returns the document and the marker's id. Where there is one already, it is that one's. */
export function addMarker(document: Document, on: Axis, time: number): [Document, string] {
  const there = document.markers.find((marker) => marker.on === on && Math.abs(marker.time - time) < NEAR);
  if (there) return [document, there.id];
  const marker: Marker = { id: freshId(document, "m"), time, name: "", on };
  return [{ ...document, markers: [...document.markers, marker] }, marker.id];
}

export function changeMarker(document: Document, id: string, change: Partial<Omit<Marker, "id">>): Document {
  return { ...document, markers: document.markers.map((one) => (one.id === id ? { ...one, ...change } : one)) };
}

export function deleteMarker(document: Document, id: string): Document {
  return { ...document, markers: document.markers.filter((marker) => marker.id !== id) };
}

/** The times that are marked on an axis. */
export function markedTimes(document: Document | null, on: Axis): number[] {
  return (document?.markers ?? []).filter((marker) => marker.on === on).map((marker) => marker.time);
}

/** The marked time nearest to one, as far as it is within reach; else null. */
export function nearestMark(times: readonly number[], time: number, reach: number): number | null {
  let best: number | null = null;
  for (const one of times) {
    if (Math.abs(one - time) <= Math.min(reach, best === null ? Infinity : Math.abs(best - time))) best = one;
  }
  return best;
}

/**
 * Put a keytime at each marker, on the curve as it is: a beat of the output gets what is shown at it, a moment of the
 * input the time at which it is shown. Returns the document and how many are new.
 */
export function keysFromMarkers(document: Document, knots: Knots, rate: number): [Document, number] {
  let next = document;
  let made = 0;
  const end = outputEnd(knots);
  for (const marker of document.markers) {
    const when = marker.on === "output" ? marker.time : outputAt(knots, marker.time);
    const shown = marker.on === "output" ? inputAt(knots, when) : marker.time;
    // The ends are keytimes already, and where one is there is no room for another.
    const isFree = next.keys.every((key) => Math.abs(key.output_time - when) > 0.5 / rate);
    if (when < 0.5 / rate || when > end - 0.5 / rate || !isFree) continue;
    [next] = addKey(next, shown, when);
    made++;
  }
  return [next, made];
}

/** The stretch of the output that is played: the work area as far as it lies in the output; null: all of it. */
export function playedStretch(document: Document | null, knots: Knots): WorkArea | null {
  const area = document?.work_area;
  if (!area) return null;
  const end = outputEnd(knots);
  const start = clamp(area.start, 0, end);
  const stop = clamp(area.end, 0, end);
  return stop - start > NEAR ? { start, end: stop } : null;
}

/** Begin or end the work area at a time; the other end is where it was, or the output's own. */
export function setWorkArea(document: Document, side: "start" | "end", time: number, outputEnds: number): Document {
  const before = document.work_area ?? { start: 0, end: outputEnds };
  let start = side === "start" ? Math.max(0, time) : before.start;
  let end = side === "end" ? time : before.end;
  // Put on the far side of the other end, it takes that one's place, and all beyond is worked on.
  if (end <= start) [start, end] = side === "start" ? [start, outputEnds] : [0, end];
  return end > start ? { ...document, work_area: { start, end } } : document;
}

export function clearWorkArea(document: Document): Document {
  return { ...document, work_area: null };
}
