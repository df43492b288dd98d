import { describe, expect, it } from "vitest";
import { addKey, addLock } from "../src/document";
import { isWithin, retimedStretch, stretchesText } from "../src/propagation";
import { EMPTY } from "./empty";

describe("the stretch that was retimed by hand", () => {
  it("reaches from the first keytime or lock to the last", () => {
    const keys = addKey(addKey(EMPTY, 2, 1)[0], 3, 3)[0];
    expect(retimedStretch(keys, 10)).toEqual({ start: 2, end: 3 });
    expect(retimedStretch(addLock(keys, 0.5, 1)[0], 10)).toEqual({ start: 0.5, end: 3 });
  });

  it("begins with the clip where there is one keytime alone", () => {
    expect(retimedStretch(addKey(EMPTY, 2, 1)[0], 10)).toEqual({ start: 0, end: 2 });
  });

  it("is none where nothing was done", () => {
    expect(retimedStretch(EMPTY, 10)).toBeNull();
    expect(retimedStretch(addKey(EMPTY, 0, 1)[0], 10)).toBeNull();
  });
});

describe("stretches", () => {
  it("are said, and asked for a time", () => {
    const pairs = Float64Array.of(1, 2, 3.456, 4);
    expect(stretchesText(pairs, 10, "seconds")).toBe("1.00 to 2.00 s, 3.46 to 4.00 s");
    expect(stretchesText(pairs, 10, "frames")).toBe("10f to 20f, 34.56f to 40f");
    expect([0.5, 1, 2.5, 4].map((time) => isWithin(pairs, time))).toEqual([false, true, false, true]);
  });
});
