/** What stands beside the stage: when it shows what, its waveform, and its beats. */

import { GrammarError, parseTime } from "../grammar";
import type { Document, MediaFile } from "../messages";
import { inputAt, type Knots, outputAt } from "../warp";
import type { Peaks } from "./peaks";

/** Moments to put keytimes on, in the time of the file that they were found in. */
export interface Beats {
  readonly times: readonly number[];
  /** From 0 to 1. */
  readonly strengths: readonly number[];
  readonly names: readonly string[];
}

/** What was found of the files that the document names. */
export interface Beside {
  /** Of the sound; null where there is none, or none that can be drawn. */
  readonly peaks: Peaks | null;
  readonly beats: Beats | null;
  /** What can't be shown, heard or found, and why. */
  readonly mediaTrouble: string | null;
  readonly beatsTrouble: string | null;
  /** Beats are being looked for. */
  readonly listening: boolean;
}

export const NOTHING_BESIDE: Beside = {
  peaks: null,
  beats: null,
  mediaTrouble: null,
  beatsTrouble: null,
  listening: false,
};

/** When the media begin, seconds after the clock's 0; what can't be read is said beside its field, and counts as 0. */
export function offsetOf(media: MediaFile, rate: number): number {
  if (media.offset === null) return 0;
  try {
    return parseTime(media.offset, rate);
  } catch (error) {
    if (error instanceof GrammarError) return 0;
    throw error;
  }
}

/** The moment of the media that belongs to an output time. */
export function mediaTimeAt(media: MediaFile, knots: Knots, rate: number, outputTime: number): number {
  return (media.clock === "input" ? inputAt(knots, outputTime) : outputTime) - offsetOf(media, rate);
}

/** Whose time beats are in, and by how much they are later there than in their file. */
export function clockOfBeats(document: Document, rate: number): { clock: "input" | "output"; offset: number } {
  const { beats, media } = document;
  if (beats?.path !== null || !media) return { clock: "output", offset: 0 };
  return { clock: media.clock, offset: offsetOf(media, rate) };
}

let known: { readonly of: readonly unknown[]; readonly times: readonly number[] } = { of: [], times: [] };

/** When the beats fall in the output; those of the input, where the warp shows them. Found once for each curve. */
export function beatsInOutput(document: Document, beats: Beats, knots: Knots, rate: number): readonly number[] {
  const { clock, offset } = clockOfBeats(document, rate);
  const of = [beats, clock, offset, clock === "output" ? null : knots.outputTimes];
  if (of.some((part, i) => part !== known.of[i])) {
    const place = (time: number): number => (clock === "output" ? time : outputAt(knots, time, time));
    known = { of, times: beats.times.map((time) => place(time + offset)) };
  }
  return known.times;
}
