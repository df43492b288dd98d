import { describe, expect, it } from "vitest";
import table from "../../tests/motion/flight_corrections.json";
import { correctedFlights, findFlight, flightsOf, markFlight, removeFlight, standing } from "../src/flights";
import type { Document } from "../src/messages";
import { clipOf } from "./clips";
import { EMPTY } from "./empty";

const CLIP = clipOf({ flights: Float64Array.of(1, 1.5, 3, 3.5) });
const said = (document: Document): (string | number | boolean)[][] =>
  flightsOf(document, [CLIP]).map(({ start, end, flies, marked }) => [start, end, flies, marked]);

describe("flights", () => {
  for (const row of table) {
    it(`are put right as the search does it: ${row.is}`, () => {
      const marks = row.marks.map(([start, end, flies], i) => ({
        id: `f${i}`,
        start: start as number,
        end: end as number,
        flies: flies as boolean,
      }));
      const found = row.found.map(([start, end]) => [start, end] as [number, number]);
      expect(correctedFlights(found, marks)).toEqual(row.left);
    });
  }

  it("keep their id when a hand moves them, and are found again when that is taken back", () => {
    const [first] = flightsOf(EMPTY, [CLIP]);
    if (!first) throw new Error("there is one");
    const moved = markFlight(EMPTY, { ...first, start: 1.2 });
    expect(said(moved)).toEqual([
      [1.2, 1.5, true, true],
      [3, 3.5, true, false],
    ]);
    const now = findFlight(flightsOf(moved, [CLIP]), first.id);
    expect(now?.start).toBe(1.2);
    expect(markFlight(moved, { ...first, start: 1.3 }).flights).toHaveLength(1);
    expect(now && said(removeFlight(moved, now))).toEqual(said(EMPTY));
  });

  it("that were found are denied, not forgotten", () => {
    const [first] = flightsOf(EMPTY, [CLIP]);
    if (!first) throw new Error("there is one");
    const denied = removeFlight(EMPTY, first);
    expect(said(denied)[0]).toEqual([1, 1.5, false, true]);
  });

  it("have ids of their own, also where a mark was moved away from what it was made of", () => {
    const [first] = flightsOf(EMPTY, [CLIP]);
    if (!first) throw new Error("there is one");
    const away = markFlight(EMPTY, { ...first, start: 2, end: 2.2 });
    const ids = flightsOf(away, [CLIP]).map((flight) => flight.id);
    expect(new Set(ids).size).toBe(3);
  });

  it("are those of all clips that are searched", () => {
    const [one] = EMPTY.clips;
    if (!one) throw new Error("there is one");
    const group: Document = { ...EMPTY, clips: [one, { ...one, role: "follow" }, { ...one, role: "search" }] };
    const clips = [clipOf({}), CLIP, clipOf({ flights: Float64Array.of(2, 2.5) })];
    expect(flightsOf(group, clips).map(({ start }) => start)).toEqual([2]);
  });
});

describe("feet", () => {
  it("stand from the first moment of a contact to the last", () => {
    const clip = clipOf({ feet: ["left", "right"], contacts: Float64Array.of(0, 0, 1, 0, 2, 3, 1, 0.5, 2) });
    expect([0, 0.75, 1, 1.5, 2, 3.1].map((time) => standing(clip, time))).toEqual([
      ["left"],
      ["left", "right"],
      ["left", "right"],
      ["right"],
      ["left", "right"],
      [],
    ]);
  });
});
