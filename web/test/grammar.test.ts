import { describe, expect, it } from "vitest";
import { parseLength, parseRate, parseSpeed, parseSpeeds, parseTime, rateValue, speedsText } from "../src/grammar";

describe("what people type", () => {
  it.each([
    ["65%", "65%"],
    [" 9.3 s ", "9.3s"],
    ["280F", "280f"],
    ["2.5", "2.5s"],
    [".5s", ".5s"],
    ["0", null],
    ["-3s", null],
    ["soon", null],
    ["65 % of it", null],
  ])("length %j", (text, length) => expect(parseLength(text)).toBe(length));

  it("rates are numbers", () => {
    expect(rateValue("24")).toBe(24);
    expect(rateValue("30000/1001")).toBeCloseTo(29.97, 3);
  });

  it.each([
    ["30", "30"],
    ["29.97 fps", "29.97"],
    ["30000/1001", "30000/1001"],
    ["24Hz", "24"],
    ["0", null],
    ["30/0", null],
    ["often", null],
  ])("rate %j", (text, rate) => expect(parseRate(text)).toBe(rate));

  it.each([
    ["3.5", 3.5],
    ["3.5s", 3.5],
    ["105f", 3.5],
    ["1:03.5", 63.5],
    [".25", 0.25],
    ["1_0", null],
    ["", null],
    ["1e3", null],
    ["3,5", null],
  ])("time %j", (text, seconds) => expect(parseTime(text, 30)).toBe(seconds));

  it.each([
    ["1.5", 1.5],
    ["1/2", 0.5],
    ["50%", 0.5],
    ["2×", 2],
    ["0", null],
    ["-1", null],
    ["1/0", null],
    ["fast", null],
  ])("speed %j", (text, speed) => expect(parseSpeed(text)).toBe(speed));

  it.each([
    ["uncut", [0, 1]],
    ["1", [1, 1]],
    ["0.5-2", [0.5, 2]],
    ["0-1", [0, 1]],
    ["50% to 1", [0.5, 1]],
    ["2-1", null],
    ["0", null],
    ["1-2-3", null],
  ])("speeds %j", (text, speeds) => expect(parseSpeeds(text)).toEqual(speeds));

  it("speeds are shown as they are typed", () => {
    for (const text of ["uncut", "1", "0.5-2"])
      expect(speedsText(...(parseSpeeds(text) as [number, number]))).toBe(text);
  });
});
