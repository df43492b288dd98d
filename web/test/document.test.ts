import { describe, expect, it } from "vitest";
import {
  addClip,
  addKey,
  addLock,
  changeKey,
  deleteKey,
  keyPlace,
  lengthInFrames,
  lengthText,
  removeClip,
  setOption,
  setRole,
  throughKeys,
} from "../src/document";
import type { Document, Key } from "../src/messages";
import { PLAIN_REFERENCE } from "../src/references";
import { EMPTY } from "./empty";

function withKeys(...outputTimes: number[]): Document {
  const keys = outputTimes.map(
    (time, i): Key => ({ id: `k${i + 1}`, input_time: time, output_time: time, speed: null }),
  );
  return { ...EMPTY, keys };
}

describe("keys", () => {
  it("are added with an id that none has, and leave the old document as it was", () => {
    const before = withKeys(1, 2);
    const [after, id] = addKey(deleteKey(before, "k1"), 0.5, 0.25);
    expect(id).toBe("k1");
    expect(after.keys.map((key) => key.id)).toEqual(["k2", "k1"]);
    expect(before.keys).toHaveLength(2);
  });

  it("are not added twice at one output time", () => {
    const before = withKeys(1);
    expect(addKey(before, 0.3, 1)).toEqual([before, "k1"]);
  });

  it("change alone", () => {
    const after = changeKey(withKeys(1, 2), "k2", { speed: 0.5 });
    expect(after.keys.map((key) => key.speed)).toEqual([null, 0.5]);
  });
});

describe("where a dragged key lands", () => {
  const room = { inputEnd: 4, rate: 10, outputEnd: 3 };
  const place = (
    wanted: { inputTime: number; outputTime: number },
    snap = true,
  ): { input_time: number; output_time: number } => keyPlace(withKeys(1, 2), "k1", wanted, room, snap);

  it("is on whole frames, or anywhere", () => {
    expect(place({ inputTime: 1.234, outputTime: 0.777 })).toEqual({ input_time: 1.2, output_time: 0.8 });
    expect(place({ inputTime: 1.234, outputTime: 0.777 }, false)).toEqual({ input_time: 1.234, output_time: 0.777 });
  });

  it("is between its neighbours, a frame from each", () => {
    expect(place({ inputTime: 1, outputTime: 2.5 }).output_time).toBeCloseTo(1.9);
    expect(place({ inputTime: 1, outputTime: -1 }).output_time).toBeCloseTo(0.1);
  });

  it("is inside the input", () => {
    expect(place({ inputTime: 9, outputTime: 1 }).input_time).toBe(4);
    expect(place({ inputTime: -9, outputTime: 1 }).input_time).toBe(0);
  });

  it("is midway where neighbours leave no room", () => {
    const crowded = withKeys(1, 1.05, 1.1);
    expect(keyPlace(crowded, "k2", { inputTime: 1, outputTime: 2 }, room, true).output_time).toBeCloseTo(1.05);
  });
});

it("a group's clips follow, or are searched", () => {
  const group = addClip(EMPTY, "camera.csv");
  expect(group.clips.map((clip) => clip.role)).toEqual(["search", "follow"]);
  expect(setRole(group, 1, "search").clips.map((clip) => clip.role)).toEqual(["search", "search"]);
});

it("a clip that goes takes its counterparts along, and the others keep theirs", () => {
  const group = addClip(addClip(EMPTY, "b.bvh"), "c.bvh");
  const beside = (clip: number) => ({
    clip,
    path: `like ${clip}`,
    fps: null,
    skeleton: null,
    up: null,
    root: null,
    channels: null,
    gaps: null,
  });
  const imitating = {
    ...group,
    references: [{ ...PLAIN_REFERENCE, path: "a.bvh", counterparts: [beside(1), beside(2)] }],
  };
  const left = removeClip(imitating, 1);
  expect(left.clips.map((clip) => clip.path)).toEqual(["walk.bvh", "c.bvh"]);
  expect(left.references[0]?.counterparts).toEqual([{ ...beside(2), clip: 1 }]);
});

describe("options", () => {
  it("are held where they are given, and only there", () => {
    const given = setOption(setOption(EMPTY, "smoothness", 0.5), "rate", "20");
    expect(given.options).toEqual({ smoothness: 0.5, rate: "20" });
    expect(setOption(given, "smoothness", null).options).toEqual({ rate: "20" });
    expect(EMPTY.options).toEqual({});
  });

  it("that speak of a free length go with it", () => {
    const free = { ...EMPTY, options: { length: "free", min_length: "2s", free_weight: "sum", loop: true } as const };
    expect(setOption(free, "length", "free")).toEqual(free);
    expect(setOption(free, "loop", null).options).toEqual({ length: "free", min_length: "2s", free_weight: "sum" });
    expect(setOption(free, "length", "65%").options).toEqual({ length: "65%", loop: true });
    expect(setOption(free, "length", null).options).toEqual({ loop: true });
  });
});

it("draws straight lines through keytimes, in order, without those at one time", () => {
  const { outputTimes, inputTimes } = throughKeys(withKeys(2, 1, 2), 4);
  expect([...outputTimes]).toEqual([0, 1, 2, 4]);
  expect([...inputTimes]).toEqual([0, 1, 2, 4]);
});

it("writes lengths as frames, two at least", () => {
  expect(lengthInFrames(2, 30)).toBe("61f");
  expect(lengthInFrames(-5, 30)).toBe("2f");
  // What was asked for as 8s is called 8 s.
  expect(lengthText(480, { n_frames: 816, rate: 60 })).toBe("8.00 s, 480 frames: 59 % of the input");
});

it("adds locks beside keys, each with an id of its own", () => {
  const [one] = addLock(withKeys(1), 0, 1);
  const [two] = addLock(one, 2, 3);
  expect(two.locks.map((lock) => lock.id)).toEqual(["l1", "l2"]);
});
