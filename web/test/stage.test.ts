import { describe, expect, it, vi } from "vitest";
import type { Clip, Why } from "../src/messages";
import { keyName, listen, type Shortcut, shownKey } from "../src/shortcuts";
import {
  groundMove,
  mirrored,
  moved,
  pairsByName,
  pairsOf,
  poseAt,
  sideOf,
  sidesOf,
  trailNodes,
} from "../src/stage/align";
import { bindingWords, matchesAt, rank, rankedScores, rowAt } from "../src/why";
import { clipOf } from "./clips";

/** A clip of a few nodes; positions are given frame by frame. */
function figureOf(names: string[], parents: number[], frames: number[][]): Clip {
  const positions = Float32Array.from(frames.flat());
  return clipOf({ n_frames: frames.length, n_nodes: names.length, names, parents, positions });
}

const BODY = Float32Array.of(0, 1, 0, 0.5, 1.5, 0, -0.5, 1.5, 0.2, 0, 0, 0.3);
const PAIRS = [0, 1, 2, 3].map((i): [number, number] => [i, i]);

describe("a reference laid over the output", () => {
  const clip = figureOf(["Hips", "LeftFoot", "RightFoot"], [-1, 0, 0], [[0, 0, 0, 0, 0, 0, 0, 0, 0]]);
  const other = { ...clip, names: ["a", "b", "c"] };

  it("is matched as the search matched it, the sides swapped in a mirror", () => {
    const matched = { ...other, counterparts: ["b", "", "a"] };
    expect(pairsOf(matched, clip)).toEqual([
      [1, 0],
      [0, 2],
    ]);
    expect(pairsOf(matched, clip, true)).toEqual([
      [1, 0],
      [0, 1],
    ]);
  });

  it("is matched by name where nobody matched it", () => {
    expect(pairsOf({ ...other, names: ["RightFoot", "Hips", "x"] }, clip)).toEqual([
      [0, 2],
      [1, 0],
    ]);
    expect(pairsOf({ ...other, names: ["RightFoot", "Hips", "x"] }, clip, true)).toEqual([
      [0, 1],
      [1, 0],
    ]);
  });
});

describe("poses", () => {
  const clip = figureOf(
    ["hips"],
    [-1],
    [
      [0, 0, 0],
      [2, 4, 6],
    ],
  );

  it("are between frames, and held at the ends", () => {
    expect([...poseAt(clip, 0.05, new Float32Array(3))]).toEqual([1, 2, 3]);
    expect([...poseAt(clip, -1, new Float32Array(3))]).toEqual([0, 0, 0]);
    expect([...poseAt(clip, 9, new Float32Array(3))]).toEqual([2, 4, 6]);
  });

  it("are laid over each other by a turn and a shift on the ground", () => {
    const turned = moved(BODY.slice(), { cos: Math.cos(0.8), sin: Math.sin(0.8), x: 3, z: -2 });
    const back = moved(turned.slice(), groundMove(turned, BODY, PAIRS));
    back.forEach((value, i) => expect(value).toBeCloseTo(BODY[i] as number, 5));
  });

  it("fit best where they differ: no other turn is nearer", () => {
    const other = BODY.map((value, i) => value + 0.1 * Math.sin(7 * i));
    const miss = (cos: number, sin: number): number => {
      const { x, z } = groundMove(other, BODY, PAIRS);
      const laid = moved(other.slice(), { cos, sin, x, z });
      return laid.reduce((sum, value, i) => sum + (i % 3 === 1 ? 0 : (value - (BODY[i] as number)) ** 2), 0);
    };
    // About the centre of the nodes; the shift of the best turn is right for its neighbours to second order only.
    const { cos, sin } = groundMove(other, BODY, PAIRS);
    const angle = Math.atan2(sin, cos);
    expect(miss(cos, sin)).toBeLessThan(miss(Math.cos(angle + 0.1), Math.sin(angle + 0.1)));
    expect(miss(cos, sin)).toBeLessThan(miss(Math.cos(angle - 0.1), Math.sin(angle - 0.1)));
  });

  it("are mirrored twice to themselves", () => {
    expect([...mirrored(mirrored(BODY.slice()))]).toEqual([...BODY]);
  });
});

describe("names of nodes", () => {
  it.each([
    ["LeftArm", "left"],
    ["arm.L", "left"],
    ["rHand", "right"],
    ["thigh_r", "right"],
    ["RightFoot", "right"],
    ["Spine", ""],
    ["lowerback", ""],
  ])("%s is %j", (name, side) => expect(sideOf(name)).toBe(side));

  it("tell sides by a first letter only where both are there", () => {
    expect(sidesOf(["lfemur", "rfemur", "lowerback", "end of lfemur"])).toEqual(["left", "right", "", "left"]);
    expect(sidesOf(["LeftFoot", "end of LeftFoot"])).toEqual(["left", "left"]);
  });

  it("pair with the same, with the other side where mirrored, or by place", () => {
    expect(pairsByName(["Hips", "LeftArm"], ["leftarm", "hips"])).toEqual([
      [0, 1],
      [1, 0],
    ]);
    expect(pairsByName(["LeftArm", "RightArm"], ["LeftArm", "RightArm"], true)).toEqual([
      [0, 1],
      [1, 0],
    ]);
    expect(pairsByName(["a", "b"], ["c", "d"])).toEqual([
      [0, 0],
      [1, 1],
    ]);
    expect(pairsByName(["a", "b"], ["c"])).toEqual([]);
  });
});

it("trails follow the root and the limbs' ends, of fingers one", () => {
  const names = ["hips", "hand", "finger1", "finger2", "foot"];
  const clip = figureOf(names, [-1, 0, 1, 1, 0], [[0, 1, 0, 0.6, 1.4, 0, 0.7, 1.4, 0, 0.7, 1.4, 0.02, 0, 0, 0]]);
  const chosen = trailNodes(clip).map((node) => names[node]);
  expect(chosen).toHaveLength(3);
  expect(chosen).toContain("hips");
  expect(chosen).toContain("foot");
});

describe("why", () => {
  const why: Why = {
    type: "why",
    revision: 1,
    n_output: 4,
    n_neighbors: 2,
    references: ["itself", "limp"],
    mirrored: [false, true],
    sources: [-1, 0],
    output_times: Float64Array.of(0.5, 0.6, 0.7, 0.8),
    input_times: Float64Array.of(0, 1, 2, 3),
    speeds: Float64Array.of(1, 1, 1, 1),
    scores: Float64Array.of(Number.NaN, 3, 1, Number.NaN),
    matched: Int32Array.of(-1, -1, 1, 0, 0, 0, -1, -1),
    matched_times: Float64Array.of(Number.NaN, Number.NaN, 0.3, 0.9, 1, 2, Number.NaN, Number.NaN),
    binding: Uint8Array.of(1, 0b11000, 0, 1),
  };

  it("finds the row of a time", () => {
    expect([0, 0.5, 0.64, 0.66, 9].map((time) => rowAt(why, time))).toEqual([0, 0, 1, 2, 3]);
  });

  it("names what a row was matched with", () => {
    expect(matchesAt(why, 1)).toEqual([
      { name: "limp", source: 0, mirrored: true, time: 0.3 },
      { name: "itself", source: -1, mirrored: false, time: 0.9 },
    ]);
    expect(matchesAt(why, 0)).toEqual([]);
  });

  it("says in words what bound a row", () => {
    expect(bindingWords(0b1001000)).toEqual(["a lock", "the fastest speed allowed"]);
    expect(bindingWords(0)).toEqual([]);
  });

  it("ranks a score among the others", () => {
    const ranked = rankedScores(why);
    expect([...ranked]).toEqual([1, 3]);
    expect([rank(ranked, 1), rank(ranked, 3)]).toEqual([0, 1]);
  });
});

describe("shortcuts", () => {
  const press = (
    key: string,
    held: Partial<Record<"ctrlKey" | "metaKey" | "shiftKey" | "altKey", boolean>> = {},
  ): string => keyName({ key, ctrlKey: false, metaKey: false, shiftKey: false, altKey: false, ...held });

  it("are named as the table has them", () => {
    expect(press(" ")).toBe("Space");
    expect(press("j")).toBe("J");
    expect(press("z", { ctrlKey: true })).toBe("Ctrl+Z");
    expect(press("Z", { metaKey: true, shiftKey: true })).toBe("Ctrl+Shift+Z");
    expect(press("?", { shiftKey: true })).toBe("?");
    expect(press("ArrowLeft", { shiftKey: true })).toBe("Shift+ArrowLeft");
  });

  it("are shown as people read them", () => {
    expect(["Shift+ArrowLeft", "+", "Ctrl+Z", "Delete"].map(shownKey)).toEqual(["Shift+←", "+", "Ctrl+Z", "Del"]);
  });

  it("can be listened for, and no more", () => {
    const target = new EventTarget();
    let played = 0;
    const end = listen(
      target as Window,
      [{ group: "Playing", keys: ["Space"], does: "", action: () => played++ }],
      () => false,
    );
    const event = (): Event => Object.assign(new Event("keydown", { cancelable: true }), { key: " " });
    const first = event();
    target.dispatchEvent(first);
    expect([played, first.defaultPrevented]).toEqual([1, true]);
    end();
    target.dispatchEvent(event());
    expect(played).toBe(1);
  });

  it("are a field's own while it takes text, but for those with Control that mean nothing to it", () => {
    class Field extends EventTarget {
      dataset: Record<string, string> = {};
      blurs = 0;
      matches = (selector: string): boolean => selector.startsWith("input");
      blur = (): number => this.blurs++;
      focus = (): void => undefined;
    }
    vi.stubGlobal("HTMLElement", Field);
    const field = new Field();
    const did: string[] = [];
    const shortcut = (name: string): Shortcut => ({
      group: "Playing",
      keys: [name],
      does: "",
      action: () => did.push(name),
    });
    listen(field as unknown as HTMLElement, ["K", "Ctrl+Z", "Ctrl+S", "Ctrl+A"].map(shortcut), () => false);
    const press = (key: string, ctrlKey: boolean): void => {
      const event = Object.assign(new Event("keydown", { cancelable: true }), {
        key,
        ctrlKey,
        metaKey: false,
        altKey: false,
      });
      Object.defineProperty(event, "target", { value: field });
      field.dispatchEvent(event);
    };
    press("k", false);
    press("a", true);
    press("z", true);
    expect(did).toEqual(["Ctrl+Z"]);
    field.dataset.typing = "true";
    press("z", true);
    press("s", true);
    expect(did).toEqual(["Ctrl+Z", "Ctrl+S"]);
    // It was left once, so that what was typed in it counts.
    expect(field.blurs).toBe(1);
    vi.unstubAllGlobals();
  });
});
