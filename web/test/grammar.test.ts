import { describe, expect, it } from "vitest";
import table from "../../tests/grammar/table.json";
import {
  GrammarError,
  parseKey,
  parseLength,
  parseLockSpeeds,
  parseNumber,
  parseRate,
  parseSpeed,
  parseSpeeds,
  parseTime,
  rateValue,
  speedsText,
  writtenKey,
} from "../src/grammar";

interface Row {
  readonly kind: string;
  readonly text: string;
  readonly value?: unknown;
  readonly error?: string;
  readonly rate?: string;
  readonly n_frames?: number;
}

const rate = (row: Row): number => rateValue(row.rate ?? "");
const READERS: Record<string, (row: Row) => unknown> = {
  time: (row) => parseTime(row.text, rate(row)),
  length: (row) => parseLength(row.text, row.n_frames ?? 0, rate(row)),
  speed: (row) => parseSpeed(row.text),
  speeds: (row) => parseSpeeds(row.text).map((speed) => (speed === Number.POSITIVE_INFINITY ? null : speed)),
  number: (row) => parseNumber(row.text, row as object),
  rate: (row) => parseRate(row.text),
  key: (row) => {
    const { input_time, output_time, speed } = parseKey(row.text, rate(row));
    return speed === null ? [input_time, output_time] : [input_time, output_time, speed];
  },
};
// The page has fields or handles for the parts of these, and nothing where they are typed as a whole.
const NOT_TYPED_HERE = new Set(["span", "lock", "frames", "share"]);

const rows = (table as readonly Row[]).filter((row) => !NOT_TYPED_HERE.has(row.kind));

it("the table speaks of every kind that is typed here", () => {
  expect(new Set(rows.map((row) => row.kind))).toEqual(new Set(Object.keys(READERS)));
});

describe("what people type means what it means on the command line", () => {
  it.each(rows.filter((row) => row.error === undefined))("$kind $text", (row) => {
    const value = READERS[row.kind]?.(row);
    if (row.kind === "rate") {
      // The page leaves it to Python to find the exact rate that rounded digits stand for.
      expect(rateValue(value as string)).toBeCloseTo(rateValue(row.value as string), 4);
    } else if (typeof row.value === "number") {
      expect(value).toBeCloseTo(row.value, 9);
    } else {
      expect(value).toEqual(row.value);
    }
  });
});

describe("what says nothing is refused in the same words", () => {
  it.each(rows.filter((row) => row.error !== undefined))("$kind $text", (row) => {
    expect(() => READERS[row.kind]?.(row)).toThrow(new GrammarError(row.error));
  });
});

describe("a lock's speeds", () => {
  it("need a fastest one", () => {
    expect(parseLockSpeeds("1/2 to 2")).toEqual([0.5, 2]);
    expect(() => parseLockSpeeds("1/2..")).toThrow("a lock needs a fastest speed");
  });

  it("are shown as they can be typed", () => {
    for (const text of ["uncut", "1", "0.5..2", "0..2"]) expect(speedsText(...parseLockSpeeds(text))).toBe(text);
  });
});

it("a keytime is written as it can be read", () => {
  for (const key of [
    { input_time: 5, output_time: 3.5, speed: null },
    { input_time: 1 / 3, output_time: 1e-9, speed: 0.1 + 0.2 },
    { input_time: 0, output_time: 1234.000_000_1, speed: 1 / 7 },
  ])
    expect(parseKey(writtenKey(key), 60)).toEqual(key);
});

it("a letter that only looks like an s is none", () => {
  expect(() => parseTime("5ſ", 30)).toThrow(GrammarError);
});
