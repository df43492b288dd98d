import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { WhenQuiet } from "../src/quiet";

describe("work that can wait", () => {
  beforeEach(() => void vi.useFakeTimers());
  afterEach(() => void vi.useRealTimers());

  it("is done once, when nothing asks any more", () => {
    const run = vi.fn();
    const work = new WhenQuiet(run, 100, 1000);
    for (let i = 0; i < 5; i++) {
      work.ask();
      vi.advanceTimersByTime(60);
    }
    expect(run).not.toHaveBeenCalled();
    vi.advanceTimersByTime(40);
    expect(run).toHaveBeenCalledTimes(1);
    vi.advanceTimersByTime(5000);
    expect(run).toHaveBeenCalledTimes(1);
  });

  it("is done all the same where asking does not end", () => {
    const run = vi.fn();
    const work = new WhenQuiet(run, 100, 1000);
    for (let i = 0; i < 55; i++) {
      work.ask();
      vi.advanceTimersByTime(50);
    }
    expect(run).toHaveBeenCalledTimes(2);
  });

  it("is not done when it was taken back", () => {
    const run = vi.fn();
    const work = new WhenQuiet(run, 100, 1000);
    work.ask();
    work.cancel();
    vi.advanceTimersByTime(5000);
    expect(run).not.toHaveBeenCalled();
  });
});
