import { describe, expect, it } from "vitest";
import { splineOf } from "../src/spline";
import { inputAt, type Knots, outputAt, pieceAt, slopes, speedAt } from "../src/warp";
import { outputByScan, randomNumbers } from "./outputs";
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

describe.each(golden.splines)("a spline with $name", (one) => {
  const spline = splineOf({
    rate: one.rate,
    key_output_times: Float64Array.from(one.key_output_times),
    key_input_times: Float64Array.from(one.key_input_times),
    spline_begins: Float64Array.from(one.spline_begins),
    spline_ends: Float64Array.from(one.spline_ends),
  });

  it("has Python's knots", () => {
    expect(spline.outputTimes).toHaveLength(one.output_times.length);
    one.output_times.forEach((time, i) => expect(spline.outputTimes[i]).toBeCloseTo(time, 12));
    one.input_times.forEach((time, i) => expect(spline.inputTimes[i]).toBeCloseTo(time, 12));
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

describe("the inverse, found quickly", () => {
  const random = randomNumbers(19);
  const warps = (turns: number): Knots[] =>
    Array.from({ length: 60 }, () => {
      const n = 2 + Math.floor(random() * 30);
      const outputTimes = new Float64Array(n);
      const inputTimes = new Float64Array(n);
      for (let i = 1; i < n; i++) {
        outputTimes[i] = (outputTimes[i - 1] as number) + 0.05 + random();
        // A third of the pieces holds; whole numbers, so that several of them meet at the same input time.
        const step = random() < 1 / 3 ? 0 : Math.ceil(random() * 3);
        inputTimes[i] = (inputTimes[i - 1] as number) + (random() < turns ? -step : step);
      }
      return { outputTimes, inputTimes };
    });

  it.each([0, 0.3, 1])("is what looking at all pieces finds, with a share of %d of them backward", (turns) => {
    for (const warp of warps(turns)) {
      for (let i = 0; i < 40; i++) {
        const wanted = i % 2 ? random() * 40 - 10 : Math.round(random() * 40 - 10);
        const near = random() * 30 - 5;
        const [found, expected] = [outputAt(warp, wanted, near), outputByScan(warp, wanted, near)];
        // Of two moments that are equally near, either will do.
        if (Math.abs(Math.abs(found - near) - Math.abs(expected - near)) > 1e-9) expect(found).toBeCloseTo(expected, 9);
        expect(inputAt(warp, found)).toBeCloseTo(inputAt(warp, expected), 9);
      }
    }
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
