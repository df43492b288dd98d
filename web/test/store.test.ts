import { describe, expect, it, vi } from "vitest";
import type { Problem } from "../src/messages";
import { Store } from "../src/store";
import { CURVE, clipOf } from "./clips";
import { EMPTY } from "./empty";

const PROBLEM: Problem = {
  type: "problem",
  revision: 2,
  message: "it can't be done",
  key: null,
  lock: null,
  clip: null,
  reference: null,
  field: "length",
};

describe("the store", () => {
  it("tells once what changed since the last frame, and wakes who draws", () => {
    const wake = vi.fn();
    const store = new Store(wake);
    store.setDocument(EMPTY);
    store.setCurve(CURVE);
    expect(wake).toHaveBeenCalledTimes(2);
    expect(store.hasChanged("curve")).toBe(true);
    expect(store.take()).toEqual(new Set(["document", "curve", "status"]));
    expect(store.take()).toEqual(new Set());
  });

  it("keeps the last curve beside a problem, and no problem beside a curve", () => {
    const store = new Store(() => undefined);
    store.setCurve(CURVE);
    store.setProblem(PROBLEM);
    expect([store.curve, store.problem]).toEqual([CURVE, PROBLEM]);
    store.setCurve(CURVE);
    expect(store.problem).toBeNull();
  });

  it("holds as many clips as there are, and gives who has read them values that stay", () => {
    const store = new Store(() => undefined);
    for (const index of [0, 1, 2]) store.setClip(clipOf({ index, count: 3 }));
    store.setClip(clipOf({ what: "reference" }));
    const before = store.clips;
    store.setClip(clipOf({ index: 0, count: 2, name: "other" }));
    expect(store.clips.map((clip) => [clip.index, clip.name])).toEqual([
      [0, "other"],
      [1, "made"],
    ]);
    expect([before.length, store.references.length]).toEqual([3, 1]);
  });

  it("forgets what was found, and not how it is looked at, when another document is opened", () => {
    const store = new Store(() => undefined);
    store.setClip(clipOf({}));
    store.setCurve(CURVE);
    store.look({ trails: true });
    store.take();
    store.clear();
    expect([store.clips, store.curve, store.problem, store.knots]).toEqual([[], null, null, null]);
    expect(store.view.trails).toBe(true);
    expect(store.take()).toContain("clips");
  });

  it("says nothing new of a pointer that has not moved, or of a drag that goes on", () => {
    const wake = vi.fn();
    const store = new Store(wake);
    store.point(null);
    store.beginDrag();
    store.beginDrag();
    expect([store.dragging, wake.mock.calls.length]).toEqual([true, 0]);
    store.endDrag();
    expect([store.dragging, store.take()]).toEqual([false, new Set(["view"])]);
  });
});
