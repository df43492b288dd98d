import { describe, expect, it } from "vitest";
import { keysInOrder } from "../src/document";
import type { Document, Key } from "../src/messages";
import {
  deleteKeys,
  extentOf,
  keysInside,
  keysOf,
  keysText,
  moveKeys,
  pasteKeys,
  readKeys,
  scaleKeys,
} from "../src/together";
import { EMPTY } from "./empty";

const ROOM = { inputEnd: 10, rate: 30, outputEnd: 8 };
const FRAME = 1 / 30;

function made(...pairs: readonly [input: number, output: number, speed?: number][]): Document {
  const keys = pairs.map(([input_time, output_time, speed], i) => ({
    id: `k${i + 1}`,
    input_time,
    output_time,
    speed: speed ?? null,
  }));
  return { ...EMPTY, keys };
}

const THREE = made([2, 1], [4, 3, 0.5], [7, 5]);
const times = (document: Document): [number, number][] =>
  keysInOrder(document).map((key) => [key.input_time, key.output_time]);

/** A generator of numbers from 0 to 1 that gives the same ones every time. */
function numbers(seed: number): () => number {
  let state = seed;
  return () => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return state / 2 ** 32;
  };
}

describe("moving keytimes together", () => {
  it("moves what is chosen, and nothing else", () => {
    const moved = moveKeys(THREE, new Set(["k1", "k2"]), { output: 0.5, input: -1 }, ROOM);
    expect(times(moved)).toEqual([
      [1, 1.5],
      [3, 3.5],
      [7, 5],
    ]);
    expect(moved.keys[1]?.speed).toBe(0.5);
  });

  it("stops a frame before what stays, before the ends, and at the ends of the input", () => {
    const right = moveKeys(THREE, new Set(["k1", "k2"]), { output: 9, input: 9 }, ROOM);
    expect(times(right)[1]?.[1]).toBeCloseTo(5 - FRAME);
    expect(times(right)[0]?.[1]).toBeCloseTo(3 - FRAME);
    expect(times(right)[1]?.[0]).toBe(10);
    const left = moveKeys(THREE, new Set(["k1", "k2", "k3"]), { output: -9, input: -9 }, ROOM);
    expect(times(left)[0]?.[1]).toBeCloseTo(FRAME);
    expect(times(left)[0]?.[0]).toBe(0);
  });

  it("with ripple moves what follows and the end along, and leaves what comes before", () => {
    const moved = moveKeys(THREE, new Set(["k2"]), { output: 1, input: 0.5 }, ROOM, true);
    expect(times(moved)).toEqual([
      [2, 1],
      [4.5, 4],
      [7, 6],
    ]);
    expect(moved.options.length).toBe(`${9 * 30 + 1}f`);
    const back = moveKeys(THREE, new Set(["k2"]), { output: -9, input: 0 }, ROOM, true);
    expect(times(back)[1]?.[1]).toBeCloseTo(1 + FRAME);
    expect(times(back)[2]?.[1]).toBeCloseTo(3 + FRAME);
  });

  it("leaves a length that the search or a reference chooses", () => {
    for (const change of [{ options: { length: "free" } }, { method: "align" }] as const) {
      const moved = moveKeys({ ...THREE, ...change }, new Set(["k2"]), { output: 1, input: 0 }, ROOM, true);
      expect(moved.options.length).toBe((change as Partial<Document>).options?.length);
    }
  });

  it("keeps the order and the room between all keytimes, whatever is asked for", () => {
    const random = numbers(7);
    for (let trial = 0; trial < 300; trial++) {
      const n = 1 + Math.floor(7 * random());
      const outputs = Array.from({ length: n }, () => (1 + Math.floor(238 * random())) / 30).sort((a, b) => a - b);
      const distinct = [...new Set(outputs)];
      const document = made(...distinct.map((output): [number, number] => [10 * random(), output]));
      const ids = new Set(document.keys.filter(() => random() < 0.5).map((key) => key.id));
      const by = { output: 20 * (random() - 0.5), input: 20 * (random() - 0.5) };
      const ripple = random() < 0.4;
      const moved = moveKeys(document, ids, by, ROOM, ripple);
      const scaled = scaleKeys(
        document,
        ids,
        { output: { about: 8 * random(), factor: 3 * random() } },
        ROOM,
        random() < 0.5,
      );
      for (const next of ripple ? [moved] : [moved, scaled]) {
        const ordered = keysInOrder(next);
        expect(ordered.map((key) => key.id)).toEqual(keysInOrder(document).map((key) => key.id));
        ordered.forEach((key, i) => {
          const before = ordered[i - 1];
          expect(key.output_time - (before?.output_time ?? 0)).toBeGreaterThan(FRAME - 1e-9);
          expect(key.input_time).toBeGreaterThan(-1e-9);
          expect(key.input_time).toBeLessThan(10 + 1e-9);
        });
        if (next === scaled || !ripple) expect(ordered.at(-1)?.output_time).toBeLessThan(8 - FRAME + 1e-9);
      }
    }
  });
});

describe("scaling keytimes together", () => {
  it("scales each axis about a time, on frames where they snap", () => {
    const ids = new Set(["k1", "k2", "k3"]);
    const scaled = scaleKeys(
      THREE,
      ids,
      { output: { about: 1, factor: 0.5 }, input: { about: 7, factor: 0.2 } },
      ROOM,
      false,
    );
    expect(times(scaled)).toEqual([
      [6, 1],
      [6.4, 2],
      [7, 3],
    ]);
    const snapped = scaleKeys(THREE, ids, { output: { about: 1, factor: 0.51 } }, ROOM, true);
    for (const [, output] of times(snapped)) expect(output * 30).toBeCloseTo(Math.round(output * 30), 9);
  });

  it("leaves a frame between them, whatever they are squeezed to", () => {
    const scaled = scaleKeys(THREE, new Set(["k1", "k2", "k3"]), { output: { about: 1, factor: 0 } }, ROOM, true);
    expect(times(scaled).map(([, output]) => Math.round(output * 30))).toEqual([30, 31, 32]);
  });
});

describe("keytimes as text", () => {
  it("are copied digit for digit, and pasted where the playhead is", () => {
    const text = keysText(THREE, new Set(["k2", "k3"]));
    expect(text).toBe("4=3@0.5\n7=5");
    const [pasted, ids] = pasteKeys(THREE, readKeys(text, 30), { outputTime: 5.5, inputTime: 7 }, ROOM);
    expect(ids.size).toBe(2);
    expect(keysOf(pasted, ids).map(({ input_time, output_time, speed }) => [input_time, output_time, speed])).toEqual([
      [7, 5.5, 0.5],
      [10, 7.5, null],
    ]);
  });

  it("replace what is in their way, and are left out where they would lie outside", () => {
    const [pasted, ids] = pasteKeys(THREE, readKeys("1=3\n2=4\n3=99", 30), null, ROOM);
    expect(ids.size).toBe(2);
    expect(times(pasted)).toEqual([
      [2, 1],
      [1, 3],
      [2, 4],
      [7, 5],
    ]);
    expect(pasted.keys.some((key: Key) => key.id === "k2" && key.input_time === 4)).toBe(false);
  });

  it("are refused where they are none", () => {
    expect(() => readKeys("4=3\nhello", 30)).toThrow("expected input time = output time");
    expect(readKeys("\r\n 4=3 \r\n", 30)).toEqual([{ input_time: 4, output_time: 3, speed: null }]);
  });
});

it("a rectangle chooses the keytimes in it", () => {
  expect(keysInside(THREE, { outputStart: 0.5, outputEnd: 3, inputStart: 2, inputEnd: 4 })).toEqual(["k1", "k2"]);
  expect(extentOf(keysOf(THREE, new Set(["k1", "k3"])))).toEqual({
    outputStart: 1,
    outputEnd: 5,
    inputStart: 2,
    inputEnd: 7,
  });
  expect(extentOf([])).toBeNull();
  expect(deleteKeys(THREE, new Set(["k1", "k3"])).keys.map((key) => key.id)).toEqual(["k2"]);
});
