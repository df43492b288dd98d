import { describe, expect, it } from "vitest";
import { parseTime } from "../src/grammar";
import { timeTicks } from "../src/timeline/time_ticks";
import { fieldTime, framesText, rateText, saidTime, spanText, timecode, timecodeFrames, UNITS } from "../src/units";

const RATES = [24, 25, 29.97, 30000 / 1001, 24000 / 1001, 60, 120, 59.94];

describe("times as they are shown", () => {
  it.each(RATES)("can be typed again, and mean the same frame, at %d Hz", (rate) => {
    for (const frame of [0, 1, 7, rate < 25 ? 23 : 24, 1799, 107_892, 360_001]) {
      for (const units of UNITS) {
        if (units === "timecode" && timecodeFrames(rate) === null) continue;
        const typed = parseTime(fieldTime(frame / rate, rate, units), rate);
        expect(Math.round(typed * rate), `${units} ${frame}`).toBe(frame);
        expect(Math.round(parseTime(saidTime(frame / rate, rate, units, 4), rate) * rate)).toBe(frame);
      }
    }
  });

  it("say fractions of a frame, and round seconds", () => {
    expect(framesText(4.675, 60)).toBe("280.5f");
    expect(framesText(2.0000001, 60)).toBe("120f");
    expect(fieldTime(1.23456, 60, "seconds")).toBe("1.235");
    expect(saidTime(1.23456, 60, "seconds")).toBe("1.23 s");
    expect(spanText(1, 2, 60, "seconds")).toBe("1.00 to 2.00 s");
    expect(spanText(1, 2, 60, "timecode")).toBe("00:00:01:00 to 00:00:02:00");
    expect(timecode(-0.5, 60)).toBe("-00:00:00:30");
    expect(timecode(2.05, 120)).toBe("00:00:02:006");
  });

  it("know which rates have a timecode", () => {
    expect([24, 30000 / 1001, 60000 / 1001, 120000 / 1001, 120].map(timecodeFrames)).toEqual([24, 30, 60, 120, 120]);
    expect([12.5, 29.5, 100.3].map(timecodeFrames)).toEqual([null, null, null]);
    expect(rateText(30000 / 1001)).toBe("29.97 Hz");
  });
});

describe("marks of an axis", () => {
  it("lie on whole frames where frames are counted, and never above each other", () => {
    for (const [from, to] of [
      [0, 0.1],
      [1.03, 2.2],
      [-0.1, 9],
      [0, 300],
    ] as const) {
      for (const units of UNITS) {
        for (const rate of [24, 60, 30000 / 1001]) {
          const { values, label } = timeTicks({ from, to }, 9, rate, units);
          expect(values.length).toBeLessThanOrEqual(11);
          expect(values.length).toBeGreaterThan(0);
          const labels = values.filter((value) => value >= 0).map(label);
          expect(new Set(labels).size, `${units} ${rate} ${labels}`).toBe(labels.length);
          for (const value of units === "seconds" ? [] : values)
            expect(Math.abs(value * rate - Math.round(value * rate))).toBeLessThan(1e-6);
        }
      }
    }
  });
});
