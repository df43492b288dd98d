/** Many keytimes as one: moved, scaled, deleted, copied and pasted. Functions from one document to the next. */

import { addKey, keysInOrder, lengthInFrames, type Room, setOption } from "./document";
import { parseKey, writtenKey } from "./grammar";
import type { Document, Key } from "./messages";
import { clamp, snapped } from "./scale";

/** Seconds: closer than this, two times are one. */
const NEAR = 1e-9;

/** Ids of keytimes. */
export type Ids = ReadonlySet<string>;

export function keysOf(document: Document, ids: Ids): Key[] {
  return keysInOrder(document).filter((key) => ids.has(key.id));
}

/** From the first of some keytimes to the last, on both axes; null where there is none. */
export interface Extent {
  readonly outputStart: number;
  readonly outputEnd: number;
  readonly inputStart: number;
  readonly inputEnd: number;
}

export function extentOf(keys: readonly Key[]): Extent | null {
  if (keys.length === 0) return null;
  const outputs = keys.map((key) => key.output_time);
  const inputs = keys.map((key) => key.input_time);
  return {
    outputStart: Math.min(...outputs),
    outputEnd: Math.max(...outputs),
    inputStart: Math.min(...inputs),
    inputEnd: Math.max(...inputs),
  };
}

/** How far keytimes are moved, seconds of output and of input. */
export interface Shift {
  readonly output: number;
  readonly input: number;
}

/**
 * Move keytimes by one shift, as far as there is room: on the output's axis none passes one that stays, and a frame is
 * left between them and to the ends; on the input's all stay inside. With `ripple` what comes after the first of them
 * in the output, its end included, is moved along.
 */
export function moveKeys(document: Document, ids: Ids, by: Shift, room: Room, ripple = false): Document {
  const chosen = keysOf(document, ids);
  const [first] = chosen;
  if (!first) return document;
  const isMoved = (key: Key): boolean => ids.has(key.id) || (ripple && key.output_time > first.output_time);
  const frame = 1 / room.rate;
  let least = -Infinity;
  let most = Infinity;
  for (const key of chosen) {
    const [before, after] = neighbours(document, key, isMoved, room, ripple);
    least = Math.max(least, before + frame - key.output_time);
    most = Math.min(most, after - frame - key.output_time);
  }
  // Where there is less room than a frame already, they stay where they are.
  const output = clamp(by.output, Math.min(least, 0), Math.max(most, 0));
  const { inputStart, inputEnd } = extentOf(chosen) as Extent;
  const input = clamp(by.input, Math.min(-inputStart, 0), Math.max(room.inputEnd - inputEnd, 0));
  const keys = document.keys.map((key) =>
    isMoved(key)
      ? { ...key, output_time: key.output_time + output, input_time: key.input_time + (ids.has(key.id) ? input : 0) }
      : key,
  );
  const next = { ...document, keys };
  return ripple ? moveEnd(next, room, output) : next;
}

/** Move the end of the output along, where a length is given or what is usual holds. */
function moveEnd(document: Document, room: Room, by: number): Document {
  const follows = document.method === "align" && document.example === null;
  if (document.options.length === "free" || follows || by === 0) return document;
  return setOption(document, "length", lengthInFrames(room.outputEnd + by, room.rate));
}

/** The output times between which a keytime may move: of the nearest ones that stay, or of the ends. */
function neighbours(
  document: Document,
  key: Key,
  isMoved: (key: Key) => boolean,
  room: Room,
  ripple: boolean,
): [before: number, after: number] {
  const still = document.keys.filter((other) => !isMoved(other)).map((other) => other.output_time);
  const before = Math.max(0, ...still.filter((time) => time < key.output_time));
  // Rippled, nothing that comes after stays.
  const after = ripple ? Infinity : Math.min(room.outputEnd, ...still.filter((time) => time > key.output_time));
  return [before, after];
}

/** About which time one axis is scaled, and by how much. */
export interface Scaling {
  readonly about: number;
  readonly factor: number;
}

/**
 * Scale keytimes on one axis or both. The order stays; on the output's axis a frame is left between them, to those that
 * are not scaled, and to the ends; input times stay inside the clip. With `snap` they land on frames.
 */
export function scaleKeys(
  document: Document,
  ids: Ids,
  { output, input }: { readonly output?: Scaling; readonly input?: Scaling },
  room: Room,
  snap: boolean,
): Document {
  const chosen = keysOf(document, ids);
  const place = (time: number): number => (snap ? snapped(time, room.rate) : time);
  const held = output && { ...output, factor: heldFactor(document, chosen, ids, output, room) };
  const scaled = (time: number, { about, factor }: Scaling): number => about + factor * (time - about);
  const keys = document.keys.map((key) => {
    if (!ids.has(key.id)) return key;
    const when = held ? place(scaled(key.output_time, held)) : key.output_time;
    const shown = input ? clamp(place(scaled(key.input_time, input)), 0, room.inputEnd) : key.input_time;
    return { ...key, output_time: when, input_time: shown };
  });
  return { ...document, keys };
}

/** The factor nearest to the one that is wanted for which there is room. */
function heldFactor(
  document: Document,
  chosen: readonly Key[],
  ids: Ids,
  { about, factor }: Scaling,
  room: Room,
): number {
  const frame = 1 / room.rate;
  let least = 0;
  let most = Infinity;
  chosen.forEach((key, i) => {
    const next = chosen[i + 1];
    const apart = next ? next.output_time - key.output_time : 0;
    if (apart > NEAR) least = Math.max(least, Math.min(1, frame / apart));
    const away = key.output_time - about;
    const [before, after] = neighbours(document, key, (other) => ids.has(other.id), room, false);
    // Its place, about + factor · away, lies between the two: each bounds the factor from above or from below.
    for (const [bound, side] of [
      [before + frame, -1],
      [after - frame, 1],
    ] as const) {
      if (Math.abs(away) < NEAR) continue;
      const there = (bound - about) / away;
      if (Math.sign(away) === side) most = Math.min(most, Math.max(there, 1));
      else least = Math.max(least, Math.min(there, 1));
    }
  });
  return clamp(factor, least, Math.max(most, least));
}

export function changeKeys(document: Document, ids: Ids, change: Partial<Omit<Key, "id">>): Document {
  return { ...document, keys: document.keys.map((key) => (ids.has(key.id) ? { ...key, ...change } : key)) };
}

export function deleteKeys(document: Document, ids: Ids): Document {
  return { ...document, keys: document.keys.filter((key) => !ids.has(key.id)) };
}

/** Keytimes as text, a line each, as they are typed on the command line: `5=3.5`, `300f=0:03.5@1/2`. */
export function keysText(document: Document, ids: Ids): string {
  return keysOf(document, ids).map(writtenKey).join("\n");
}

/** Read what `keysText` writes, or a person. Empty lines are passed over; throws a GrammarError for any other. */
export function readKeys(text: string, rate: number): Omit<Key, "id">[] {
  return text
    .split(/\r?\n/u)
    .filter((line) => line.trim() !== "")
    .map((line) => parseKey(line, rate));
}

/**
 * Put keytimes so that the first one comes to a place, or, without one, at their own times. One that is in the way of
 * a pasted one is replaced. Those that would lie outside the output or the input are left out.
 */
export function pasteKeys(
  document: Document,
  keys: readonly Omit<Key, "id">[],
  at: { readonly outputTime: number; readonly inputTime: number } | null,
  room: Room,
): [Document, Ids] {
  const ordered = [...keys].sort((a, b) => a.output_time - b.output_time);
  const [first] = ordered;
  if (!first) return [document, new Set()];
  const later = at ? at.outputTime - first.output_time : 0;
  const shownLater = at ? at.inputTime - first.input_time : 0;
  const frame = 1 / room.rate;
  let next = document;
  const ids = new Set<string>();
  for (const key of ordered) {
    const when = key.output_time + later;
    const shown = key.input_time + shownLater;
    const isInside =
      when > frame / 2 && when < room.outputEnd - frame / 2 && shown >= -NEAR && shown <= room.inputEnd + NEAR;
    if (!isInside) continue;
    const inTheWay = next.keys.filter((one) => !ids.has(one.id) && Math.abs(one.output_time - when) < frame / 2);
    next = deleteKeys(next, new Set(inTheWay.map((one) => one.id)));
    const [added, id] = addKey(next, clamp(shown, 0, room.inputEnd), when);
    next = changeKeys(added, new Set([id]), { speed: key.speed });
    ids.add(id);
  }
  return [next, ids];
}

/** The keytimes in a rectangle of the map. */
export function keysInside(document: Document, box: Extent): string[] {
  return document.keys
    .filter(
      ({ output_time, input_time }) =>
        output_time >= box.outputStart &&
        output_time <= box.outputEnd &&
        input_time >= box.inputStart &&
        input_time <= box.inputEnd,
    )
    .map((key) => key.id);
}
