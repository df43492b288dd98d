/** What the stage shows of a channel between frames. */

import { describe, expect, it } from "vitest";
import { fullTurn, valueAt } from "../src/stage/signals";
import { clipOf } from "./clips";

function channel(kind: string, ...values: number[]) {
  return clipOf({
    holds: "signal",
    n_frames: values.length,
    names: ["x"],
    kinds: [kind],
    values: Float64Array.from(values),
  });
}

describe("a channel between two frames", () => {
  it("of lengths shows the mean", () => {
    expect(valueAt(channel("linear", 179, -179), 0, 0.05)).toBeCloseTo(0);
  });
  it("of angles turns the short way, and passes from one end of its range to the other", () => {
    const yaw = channel("angle:deg", 178, -178, 177);
    expect([0.025, 0.075, 0.1, 0.125, 0.175].map((time) => valueAt(yaw, 0, time))).toEqual(
      [179, -179, -178, -179.25, 178.25].map((value) => expect.closeTo(value)),
    );
    const more = channel("angle:rad", 6.2, 0.1);
    expect(valueAt(more, 0, 0.09)).toBeCloseTo(0.1 - 0.1 * (0.1 + 2 * Math.PI - 6.2));
  });
  it("of angles keeps turns that were counted", () => {
    expect(valueAt(channel("angle:deg", 710, 730), 0, 0.05)).toBeCloseTo(720);
  });
  it("of labels shows the nearer frame", () => {
    const id = channel("label", 7, 0);
    expect([0.04, 0.06].map((time) => valueAt(id, 0, time))).toEqual([7, 0]);
  });
});

it("only angles have a full turn", () => {
  expect(["linear", "angle:deg", "angle:rad", "label"].map(fullTurn)).toEqual([0, 360, 2 * Math.PI, 0]);
});
