/** Flights: those that were found, put right by what the document says of some stretches. Times are of the input. */

import type { Clip, Curve, Document, FlightMark } from "./messages";
import { spanText, type Units } from "./units";
import { at } from "./warp";

/** A flight, or a stretch of which a person says that nothing flies there. */
export interface Flight {
  /** Of the mark; or of what was found, which a mark made of it keeps, so that it stays the same thing under a hand. */
  readonly id: string;
  readonly start: number;
  readonly end: number;
  readonly flies: boolean;
  /** Said by a person. */
  readonly marked: boolean;
}

type Span = readonly [number, number];

/** The flights that are left of those that were found: `corrected_flights` of retime.motion.flights does the same. */
export function correctedFlights(found: readonly Span[], marks: readonly FlightMark[]): Span[] {
  let left = found.filter(([a, b]) => marks.every(({ flies, start, end }) => !flies || b < start || a > end));
  for (const { flies, start, end } of marks) {
    if (flies) continue;
    left = left.flatMap(([a, b]): Span[] =>
      (
        [
          [a, Math.min(b, start)],
          [Math.max(a, end), b],
        ] as const
      ).filter(([from, to]) => to > from),
    );
  }
  return left;
}

/** All flights of the clips that are searched, and what was said of them, in the order of time. */
export function flightsOf(document: Document, clips: readonly Clip[]): Flight[] {
  const found: Span[] = [];
  clips.forEach((clip, place) => {
    if (document.clips[place]?.role !== "search") return;
    for (let i = 0; i + 1 < clip.flights.length; i += 2) found.push([at(clip.flights, i), at(clip.flights, i + 1)]);
  });
  const taken = new Set(document.flights.map((mark) => mark.id));
  const flights = document.flights.map((mark): Flight => ({ ...mark, marked: true }));
  for (const [start, end] of correctedFlights(found, document.flights)) {
    let id = `found ${start.toFixed(3)}`;
    while (taken.has(id)) id += "'";
    taken.add(id);
    flights.push({ id, start, end, flies: true, marked: false });
  }
  return flights.sort((a, b) => a.start - b.start || a.end - b.end);
}

export function findFlight(flights: readonly Flight[], id: string | null): Flight | null {
  return flights.find((flight) => flight.id === id) ?? null;
}

/** Say of a stretch that it is a flight, or none. */
export function markFlight(document: Document, { id, start, end, flies }: FlightMark): Document {
  const mark = { id, start, end, flies };
  const there = document.flights.some((one) => one.id === id);
  return {
    ...document,
    flights: there ? document.flights.map((one) => (one.id === id ? mark : one)) : [...document.flights, mark],
  };
}

/** Take a flight away: what was found is said to be none; what was said is said no more. */
export function removeFlight(document: Document, flight: Flight): Document {
  if (!flight.marked) return markFlight(document, { ...flight, flies: false });
  return { ...document, flights: document.flights.filter((mark) => mark.id !== flight.id) };
}

/** Whether the search kept flights at their own speed; of an example's own curve the page is not told. */
export function flightsCount({ example }: Document, curve: Curve | null): boolean {
  return example !== null || curve === null || curve.keep_flights > 0;
}

/** What a flight is called, and where it is. */
export function flightText({ start, end, flies, marked }: Flight, rate: number, units: Units): string {
  const source = marked ? "said by hand" : "found";
  return `${flies ? "in the air" : "not in the air"} from input ${spanText(start, end, rate, units)}, ${source}`;
}

/** Names of the feet that stand at an input time. */
export function standing(clip: Clip, time: number): string[] {
  const feet = new Set<number>();
  for (let i = 0; i + 2 < clip.contacts.length; i += 3) {
    if (at(clip.contacts, i + 1) <= time + 1e-9 && time <= at(clip.contacts, i + 2) + 1e-9)
      feet.add(at(clip.contacts, i));
  }
  return clip.feet.filter((_, i) => feet.has(i));
}
