import { describe, expect, it } from "vitest";
import { inputAt, type Knots, outputAt, pieceAt, slopes, speedAt } from "../src/warp";
import golden from "./warp_golden.json";

describe.each(golden.cases)("a warp with $name", (one) => {
  const warp: Knots = {
    outputTimes: Float64Array.from(one.output_times),
    inputTimes: Float64Array.from(one.input_times),
  };

  it("shows what Python's shows", () => {
    one.at.forEach((time, i) => expect(inputAt(warp, time)).toBeCloseTo(one.shows[i] as number, 12));
  });

  it("plays at Python's speeds", () => {
    one.at.forEach((time, i) => expect(speedAt(warp, time)).toBeCloseTo(one.speeds[i] as number, 9));
  });
});

describe("the inverse", () => {
  const bent: Knots = {
    outputTimes: Float64Array.of(0, 1, 1.5, 2.5, 3),
    inputTimes: Float64Array.of(0, 1, 1, 0.25, 2),
  };

  it("is where the warp shows the time", () => {
    for (const wanted of [0, 0.2, 0.6, 1, 1.5, 2])
      expect(inputAt(bent, outputAt(bent, wanted))).toBeCloseTo(wanted, 12);
  });

  it("takes the nearest of several", () => {
    expect(outputAt(bent, 0.5, 0)).toBeCloseTo(0.5);
    expect(outputAt(bent, 0.5, 2)).toBeCloseTo(1.5 + 0.5 / 0.75);
    expect(outputAt(bent, 0.5, 3)).toBeCloseTo(2.5 + 0.25 / 3.5);
  });

  it("stays where one is in a hold", () => {
    expect(outputAt(bent, 1, 1.2)).toBeCloseTo(1.2);
  });

  it("takes the nearest pose where none is shown", () => {
    expect(outputAt(bent, 9)).toBe(3);
  });
});

it("finds pieces, the last one at the end", () => {
  const times = Float64Array.of(0, 1, 2);
  expect([-1, 0, 0.5, 1, 1.5, 2, 9].map((time) => pieceAt(times, time))).toEqual([0, 0, 0, 1, 1, 1, 1]);
});

it("knows the slope of each piece", () => {
  expect([...slopes({ outputTimes: Float64Array.of(0, 1, 3), inputTimes: Float64Array.of(0, 2, 1) })]).toEqual([
    2, -0.5,
  ]);
});
