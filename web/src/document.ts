/** Edits of the document: functions from one document value to the next. They check nothing that the server checks. */

import type { ClipFile, Document, Key, LockedTime, Options } from "./messages";
import { OPTIONS, type OptionName } from "./options";
import { clamp, snapped } from "./scale";
import type { Knots } from "./warp";

/** An id that no key or lock of the document has. */
export function freshId(document: Document, letter: string): string {
  const taken = new Set(
    [...document.keys, ...document.locks, ...document.flights, ...document.markers].map((one) => one.id),
  );
  let n = 1;
  while (taken.has(`${letter}${n}`)) n++;
  return `${letter}${n}`;
}

export function keysInOrder(document: Document): Key[] {
  return [...document.keys].sort((a, b) => a.output_time - b.output_time);
}

/** Straight lines through the keytimes, from the beginning to the end of the input: what there is before any curve. */
export function throughKeys(document: Document, inputEnd: number): Knots {
  const inside = keysInOrder(document).filter((key, i, all) => key.output_time > (all[i - 1]?.output_time ?? 0));
  const last = inside.at(-1) ?? { output_time: 0, input_time: 0 };
  const end = last.output_time + Math.max(inputEnd - last.input_time, 0.1);
  return {
    outputTimes: Float64Array.of(0, ...inside.map((key) => key.output_time), end),
    inputTimes: Float64Array.of(0, ...inside.map((key) => key.input_time), inputEnd),
  };
}

export function findKey(document: Document, id: string | null): Key | null {
  return document.keys.find((key) => key.id === id) ?? null;
}

export function findLock(document: Document, id: string | null): LockedTime | null {
  return document.locks.find((lock) => lock.id === id) ?? null;
}

/** Add a keytime; returns the document and the key's id. If a key is at that output time already, it is that one's. */
export function addKey(document: Document, inputTime: number, outputTime: number): [Document, string] {
  const there = document.keys.find((key) => Math.abs(key.output_time - outputTime) < 1e-9);
  if (there) return [document, there.id];
  const key: Key = { id: freshId(document, "k"), input_time: inputTime, output_time: outputTime, speed: null };
  return [{ ...document, keys: [...document.keys, key] }, key.id];
}

export function changeKey(document: Document, id: string, change: Partial<Omit<Key, "id">>): Document {
  return { ...document, keys: document.keys.map((key) => (key.id === id ? { ...key, ...change } : key)) };
}

export function deleteKey(document: Document, id: string): Document {
  return { ...document, keys: document.keys.filter((key) => key.id !== id) };
}

export interface Room {
  /** Time of the last frame of the first clip, seconds. */
  readonly inputEnd: number;
  /** Frames a second of the first clip. */
  readonly rate: number;
  /** Seconds of the output. Its end is not one of the keys. */
  readonly outputEnd: number;
}

/** Where times snap to on each axis. */
export interface Snap {
  output(time: number): number;
  input(time: number): number;
}

/**
 * Where a key lands that is dragged to a place: on whole frames if so wished, inside the input, and in output time at
 * least a frame from its neighbours and the ends. What is `exact` was snapped to something else than frames.
 */
export function keyPlace(
  document: Document,
  id: string,
  wanted: { inputTime: number; outputTime: number },
  room: Room,
  snap: boolean | Snap,
  exact: { readonly inputTime?: number; readonly outputTime?: number } = {},
): { input_time: number; output_time: number } {
  const others = document.keys.filter((key) => key.id !== id).map((key) => key.output_time);
  const own = findKey(document, id)?.output_time ?? wanted.outputTime;
  const frame = 1 / room.rate;
  const before = Math.max(0, ...others.filter((time) => time < own));
  const after = Math.min(room.outputEnd, ...others.filter((time) => time > own));
  const plain = (time: number): number => (snap ? snapped(time, room.rate) : time);
  const place: Snap = typeof snap === "boolean" ? { output: plain, input: plain } : snap;
  const wantedOutput = exact.outputTime === undefined ? place.output(wanted.outputTime) : wanted.outputTime;
  const wantedInput = exact.inputTime === undefined ? place.input(wanted.inputTime) : wanted.inputTime;
  // Neighbours less than two frames apart leave no room: the key goes midway between them.
  const low = before + frame;
  const high = after - frame;
  const outputTime = low <= high ? clamp(wantedOutput, low, high) : (before + after) / 2;
  return { input_time: clamp(wantedInput, 0, room.inputEnd), output_time: outputTime };
}

/** Add a span that may not be cut: slowed down at most. */
export function addLock(document: Document, start: number, end: number): [Document, string] {
  const lock: LockedTime = { id: freshId(document, "l"), start, end, slowest: 1, fastest: 1 };
  return [{ ...document, locks: [...document.locks, lock] }, lock.id];
}

export function changeLock(document: Document, id: string, change: Partial<Omit<LockedTime, "id">>): Document {
  return { ...document, locks: document.locks.map((lock) => (lock.id === id ? { ...lock, ...change } : lock)) };
}

export function deleteLock(document: Document, id: string): Document {
  return { ...document, locks: document.locks.filter((lock) => lock.id !== id) };
}

/** Give an option, or, with null, give it no more. */
export function setOption(document: Document, name: OptionName, value: string | number | boolean | null): Document {
  const gone = new Set<OptionName>(value === null ? [name] : []);
  // What is said of a free length goes with it.
  if (name === "length" && value !== "free") for (const one of OPTIONS) if (one.needsFree) gone.add(one.name);
  const given = Object.entries({ ...document.options, [name]: value }).filter(([key]) => !gone.has(key as OptionName));
  return { ...document, options: Object.fromEntries(given) as Options };
}

/** Add a clip that gets the same warp. */
export function addClip(document: Document, path: string): Document {
  const clip: ClipFile = {
    path,
    role: "follow",
    first_frame: null,
    last_frame: null,
    fps: null,
    skeleton: null,
    up: null,
    channels: null,
    gaps: null,
    root: null,
    offset: null,
  };
  return { ...document, clips: [...document.clips, clip] };
}

/** Take a clip out of the group, and what other clips of it were to move like in its place. */
export function removeClip(document: Document, index: number): Document {
  const references = document.references.map((reference) => ({
    ...reference,
    counterparts: reference.counterparts
      .filter((one) => one.clip !== index)
      .map((one) => (one.clip > index ? { ...one, clip: one.clip - 1 } : one)),
  }));
  return { ...document, references, clips: document.clips.filter((_, i) => i !== index) };
}

export function changeClip(document: Document, index: number, change: Partial<ClipFile>): Document {
  return { ...document, clips: document.clips.map((clip, i) => (i === index ? { ...clip, ...change } : clip)) };
}

/** Search on a clip of the group too, or let it only follow. */
export function setRole(document: Document, index: number, role: ClipFile["role"]): Document {
  return changeClip(document, index, { role });
}

/** A length as frames of output, as the document writes it. */
export function lengthInFrames(outputEnd: number, rate: number): string {
  return `${Math.max(2, Math.round(outputEnd * rate) + 1)}f`;
}

/** The length of an output of so many frames, as the command line says it: each frame is shown for a frame period. */
export function lengthText(frames: number, input: { readonly n_frames: number; readonly rate: number }): string {
  const share = ((100 * frames) / input.n_frames).toFixed(0);
  return `${(frames / input.rate).toFixed(2)} s, ${frames} frames: ${share} % of the input`;
}
