import { describe, expect, it } from "vitest";
import { rebased } from "../src/merge";
import type { Document, Key } from "../src/messages";
import { EMPTY } from "./empty";

const key = (id: string, output_time: number): Key => ({ id, input_time: 1, output_time, speed: null });
const base: Document = { ...EMPTY, keys: [key("a", 1), key("b", 2)], options: { length: "80%", rate: "30" } };

describe("what one window did, on what another made", () => {
  it("changes only what it changed", () => {
    const mine = { ...base, keys: [key("a", 1.5), key("b", 2)] };
    const theirs: Document = { ...base, keys: [key("a", 1), key("b", 2.5), key("c", 3)], method: "spline" };
    expect(rebased(base, mine, theirs)).toEqual({ ...theirs, keys: [key("a", 1.5), key("b", 2.5), key("c", 3)] });
  });

  it("adds and removes", () => {
    const mine = { ...base, keys: [key("b", 2), key("d", 4)] };
    expect(rebased(base, mine, base).keys).toEqual([key("b", 2), key("d", 4)]);
    const theirs = { ...base, keys: [key("a", 1), key("b", 2), key("c", 3)] };
    expect(rebased(base, mine, theirs).keys).toEqual([key("b", 2), key("c", 3), key("d", 4)]);
  });

  it("brings back what they removed and it moved", () => {
    const mine = { ...base, keys: [key("a", 1.5), key("b", 2)] };
    expect(rebased(base, mine, { ...base, keys: [] }).keys).toEqual([key("a", 1.5)]);
  });

  it("merges options one by one", () => {
    const mine: Document = { ...base, options: { length: "70%" } };
    const theirs: Document = { ...base, options: { length: "80%", rate: "25", n_neighbors: 2 } };
    expect(rebased(base, mine, theirs).options).toEqual({ length: "70%", n_neighbors: 2 });
  });

  it("wins where both changed the same, and is theirs where it changed nothing", () => {
    const theirs: Document = { ...base, options: { length: "60%" } };
    expect(rebased(base, { ...base, options: { length: "70%", rate: "30" } }, theirs).options.length).toBe("70%");
    expect(rebased(base, structuredClone(base), theirs)).toEqual(theirs);
  });
});
