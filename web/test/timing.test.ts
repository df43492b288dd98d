import { describe, expect, it } from "vitest";
import { advance, STILL, seek, shuttle, step } from "../src/playback";
import { clamp, panned, snapped, ticks, timeLabel, toPixels, toValue, within, zoomed } from "../src/scale";
import {
  inputTimeAt,
  inputView,
  inputY,
  layoutOf,
  levelSpeed,
  outputTimeAt,
  outputX,
  referenceView,
  speedAtY,
  speedLevel,
  speedView,
  speedY,
} from "../src/timeline/layout";

const HALF = { outputTimes: Float64Array.of(0, 2), inputTimes: Float64Array.of(0, 4) };

describe("playback", () => {
  it("runs in true seconds of the output, and shows what the warp shows where linked", () => {
    const playing = { ...STILL, rate: 1, linked: true };
    const later = advance(playing, HALF, 4, 0.5);
    expect([later.outputTime, later.inputTime]).toEqual([0.5, 1]);
  });

  it("runs in true seconds of the input by the input's clock", () => {
    const later = advance({ ...STILL, rate: 1, linked: true, clock: "input" }, HALF, 4, 0.5);
    expect([later.outputTime, later.inputTime]).toEqual([0.25, 0.5]);
  });

  it("lets each side play on its own where it is not linked, and rest at its end", () => {
    const later = advance({ ...STILL, rate: 1, clock: "input" }, HALF, 4, 3);
    expect([later.outputTime, later.inputTime]).toEqual([2, 3]);
  });

  it("loops, forward and backward, or stops", () => {
    const near = seek({ ...STILL, rate: 1 }, HALF, 4, 1.9);
    expect(advance(near, HALF, 4, 0.3).outputTime).toBeCloseTo(0.2);
    expect(advance({ ...STILL, rate: -1 }, HALF, 4, 0.3).outputTime).toBeCloseTo(1.7);
    const stopped = advance({ ...near, loop: false }, HALF, 4, 0.3);
    expect([stopped.outputTime, stopped.rate]).toEqual([2, 0]);
  });

  it("steps whole frames from wherever it is, and stops to do so", () => {
    const stepped = step({ ...STILL, rate: 1, outputTime: 0.51 }, HALF, 4, 10, 1);
    expect([stepped.outputTime, stepped.rate]).toEqual([0.6, 0]);
    expect(step(STILL, HALF, 4, 10, -1).outputTime).toBe(0);
  });

  it("shuttles as editors do", () => {
    expect([0, 1, 2, 8, -1].map((rate) => shuttle(rate, 1))).toEqual([1, 2, 4, 8, 1]);
    expect([0, -1, 4].map((rate) => shuttle(rate, -1))).toEqual([-1, -2, -1]);
  });
});

describe("scales", () => {
  it("go there and back", () => {
    const view = { from: 2, to: 7 };
    for (const value of [2, 3.3, 7, 9]) expect(toValue(view, 640, toPixels(view, 640, value))).toBeCloseTo(value, 12);
  });

  it("zoom about what is under the pointer", () => {
    const view = zoomed({ from: 0, to: 10 }, { from: 0, to: 20 }, 0.5, 4, 0.1);
    expect(view).toEqual({ from: 2, to: 7 });
  });

  it("zoom no further than a few frames, or than all", () => {
    const whole = { from: 0, to: 20 };
    const close = zoomed({ from: 0, to: 10 }, whole, 1e-9, 4, 0.1);
    expect(close.to - close.from).toBeCloseTo(0.1);
    expect(zoomed({ from: 0, to: 10 }, whole, 99, 4, 0.1)).toEqual(whole);
  });

  it("pan, and stay inside", () => {
    expect(panned({ from: 2, to: 4 }, { from: 0, to: 10 }, 3)).toEqual({ from: 5, to: 7 });
    expect(panned({ from: 2, to: 4 }, { from: 0, to: 10 }, 99)).toEqual({ from: 8, to: 10 });
    expect(within({ from: -5, to: 50 }, { from: 0, to: 10 })).toEqual({ from: 0, to: 10 });
  });

  it.each([
    [0, 10, 10, 1],
    [0, 13.6, 12, 2],
    [0, 0.4, 5, 0.1],
    [3, 3.2, 5, 0.05],
  ])("ticks from %d to %d, at most %d: steps of %d", (from, to, most, wanted) => {
    const { values, step: found } = ticks({ from, to }, most);
    expect(found).toBeCloseTo(wanted, 12);
    expect(values.every((value) => value >= from - 1e-9 && value <= to + 1e-9)).toBe(true);
  });

  it("label with the digits that a step needs", () => {
    expect([timeLabel(2, 1), timeLabel(2, 0.5), timeLabel(2, 0.05)]).toEqual(["2", "2.0", "2.00"]);
  });

  it("snap to frames", () => {
    expect(snapped(0.349, 30)).toBeCloseTo(10 / 30, 12);
    expect(clamp(5, 0, 3)).toBe(3);
  });
});

describe("the timeline's layout", () => {
  const layout = layoutOf(1000, 320);
  const scales = {
    output: { from: 0, to: 8 },
    input: inputView(0, 12, 12),
    speed: speedView([0.1, 1, 5]),
    share: { from: 0, to: 1 },
  };

  it("has room for everything, one below the other", () => {
    const boxes = [layout.ruler, layout.map, layout.speed, layout.heat, layout.reference, layout.foot];
    boxes
      .slice(1)
      .forEach((box, i) => expect(box.y).toBeGreaterThanOrEqual((boxes[i]?.y ?? 0) + (boxes[i]?.height ?? 0)));
    expect(layout.foot.y + layout.foot.height).toBeLessThanOrEqual(320);
  });

  it("finds back what it draws", () => {
    expect(outputTimeAt(layout, scales, outputX(layout, scales, 3.3))).toBeCloseTo(3.3);
    expect(inputTimeAt(layout, scales, inputY(layout, scales, 7.7))).toBeCloseTo(7.7);
    expect(speedAtY(layout, scales, speedY(layout, scales, 2.5))).toBeCloseTo(2.5);
  });

  it("has a place for holds and for what plays backward, one below the other", () => {
    const wide = { ...scales, speed: speedView([-2, 0, 5]) };
    const levels = [8, 4, 1, 0.5, 0.1, 0.01, 0, -0.01, -1, -2].map((speed) => speedY(layout, wide, speed));
    levels.slice(1).forEach((y, i) => expect(y).toBeGreaterThan(levels[i] as number));
    for (const speed of [5, 1, 0.2, 0, -0.5, -2])
      expect(speedAtY(layout, wide, speedY(layout, wide, speed))).toBeCloseTo(speed, 9);
    expect(levels.at(-1)).toBeLessThan(layout.speed.y + layout.speed.height);
  });

  it("is a scale of octaves where it matters", () => {
    expect(speedLevel(1)).toBeCloseTo(0, 12);
    for (const octave of [-2, -1, 1, 2, 3]) expect(speedLevel(2 ** octave)).toBeCloseTo(octave, 1);
    for (const speed of [-3, 0, 0.3, 7]) expect(levelSpeed(speedLevel(speed))).toBeCloseTo(speed, 12);
  });

  it("shows whole octaves, as much speed as there is, up to sixteen times", () => {
    expect(speedView([1, 1])).toEqual({ from: -1.25, to: 2.25 });
    expect(speedView([1, 1000]).to).toBe(4.25);
    expect(speedView([0, 1]).from).toBeLessThanOrEqual(speedLevel(0) - 0.2);
    expect(speedView([-1000, 1]).from).toBeLessThanOrEqual(speedLevel(-16));
  });

  it("does not jump: what was in view stays so", () => {
    const before = speedView([0.1, 5]);
    expect(speedView([1, 1], before)).toEqual(before);
    expect(speedView([0.1, 15], before)).toEqual({ from: before.from, to: 4.25 });
  });

  it("gives the map 240 pixels of the 432 that the timeline has at 720p", () => {
    expect(layoutOf(980, 432, { hasFeet: true }).map.height).toBeGreaterThanOrEqual(240);
  });

  it("shows as large a share of the reference as of the output", () => {
    expect(referenceView({ ...scales, share: { from: 0.25, to: 0.5 } }, 8)).toEqual({ from: 2, to: 4 });
  });
});
