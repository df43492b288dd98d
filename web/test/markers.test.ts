import { describe, expect, it } from "vitest";
import { addKey, changeClip, keyPlace } from "../src/document";
import {
  addMarker,
  changeMarker,
  deleteMarker,
  keysFromMarkers,
  markedTimes,
  nearestMark,
  playedStretch,
  setWorkArea,
} from "../src/markers";
import type { ClipFile } from "../src/messages";
import { advance, range, STILL } from "../src/playback";
import { trimClip, trimOf } from "../src/trim";
import { clipOf } from "./clips";
import { EMPTY } from "./empty";

const HALF = { outputTimes: Float64Array.of(0, 2), inputTimes: Float64Array.of(0, 4) };

describe("markers", () => {
  it("are made once at a time, changed and deleted", () => {
    const [one, id] = addMarker(EMPTY, "output", 1);
    expect(addMarker(one, "output", 1)).toEqual([one, id]);
    const [two, other] = addMarker(one, "input", 1);
    expect(other).not.toBe(id);
    expect(markedTimes(changeMarker(two, id, { time: 1.5 }), "output")).toEqual([1.5]);
    expect(deleteMarker(two, id).markers.map((marker) => marker.on)).toEqual(["input"]);
  });

  it("draw times near them, the nearest first", () => {
    expect(nearestMark([1, 1.2, 3], 1.15, 0.1)).toBe(1.2);
    expect(nearestMark([1, 1.2, 3], 1.1, 0.2)).toBeOneOf([1, 1.2]);
    expect(nearestMark([1, 1.2, 3], 2, 0.1)).toBeNull();
    const [document, id] = addKey(EMPTY, 2, 1);
    const snap = { output: (time: number) => nearestMark([1.234], time, 0.1) ?? time, input: () => 3.21 };
    const room = { inputEnd: 4, rate: 10, outputEnd: 2 };
    const placed = keyPlace(document, id, { inputTime: 3, outputTime: 1.3 }, room, snap);
    expect(placed).toEqual({ input_time: 3.21, output_time: 1.234 });
  });

  it("become keytimes on the curve, but not where there is one, nor at the ends", () => {
    let document = addKey(EMPTY, 2, 1)[0];
    for (const [on, time] of [
      ["output", 0.5],
      ["input", 3],
      ["output", 1],
      ["output", 0],
      ["input", 4],
      ["output", 9],
    ] as const)
      document = addMarker(document, on, time)[0];
    const [next, made] = keysFromMarkers(document, HALF, 10);
    expect(made).toBe(2);
    expect(next.keys.map((key) => [key.input_time, key.output_time])).toEqual([
      [2, 1],
      [1, 0.5],
      [3, 1.5],
    ]);
  });
});

describe("the work area", () => {
  it("is set end by end, and never backward", () => {
    const one = setWorkArea(EMPTY, "start", 0.5, 2);
    expect(one.work_area).toEqual({ start: 0.5, end: 2 });
    expect(setWorkArea(one, "end", 1, 2).work_area).toEqual({ start: 0.5, end: 1 });
    expect(setWorkArea(one, "end", 0.25, 2).work_area).toEqual({ start: 0, end: 0.25 });
    expect(setWorkArea(setWorkArea(one, "end", 1, 2), "start", 1.5, 2).work_area).toEqual({ start: 1.5, end: 2 });
    expect(setWorkArea(EMPTY, "end", 0, 2)).toBe(EMPTY);
  });

  it("is what is played and looped, by either clock, as far as the output has it", () => {
    const area = { start: 0.5, end: 1 };
    const playing = { ...STILL, rate: 1, linked: true, outputTime: 0.9 };
    expect(advance(playing, HALF, 4, 0.3, area).outputTime).toBeCloseTo(0.7);
    expect(advance({ ...playing, loop: false }, HALF, 4, 0.3, area)).toMatchObject({ outputTime: 1, rate: 0 });
    expect(advance({ ...playing, rate: -1, outputTime: 0.6 }, HALF, 4, 0.3, area).outputTime).toBeCloseTo(0.8);
    const byInput = { ...playing, clock: "input", inputTime: 1.9 } as const;
    expect(range(byInput, HALF, 4, area)).toEqual({ start: 1, end: 2 });
    expect(advance(byInput, HALF, 4, 0.3, area).inputTime).toBeCloseTo(1.2);
    expect(range({ ...byInput, linked: false }, HALF, 4, area)).toEqual({ start: 0.5, end: 1 });
    const outside = { ...EMPTY, work_area: { start: 3, end: 5 } };
    expect(playedStretch(outside, HALF)).toBeNull();
    expect(playedStretch({ ...EMPTY, work_area: { start: 1, end: 5 } }, HALF)).toEqual({ start: 1, end: 2 });
  });
});

describe("trimming a clip", () => {
  // 41 frames at 10 Hz are used of a file of 100, whose first frame is called 1; 20 come before.
  const clip = clipOf({ first_frame: 21, start_time: 2, n_whole: 100 });

  const USED = changeClip(EMPTY, 0, { first_frame: 21, last_frame: 61 });

  it("is said from the file's first frame", () => {
    const [file] = USED.clips as [ClipFile];
    expect(trimOf(file, clip)).toEqual({ start: 2, end: 6, last: 9.9 });
    expect(trimOf({ ...file, first_frame: null, last_frame: null }, clip)).toEqual({ start: 0, end: 9.9, last: 9.9 });
  });

  it("names frames as the file does, and none where all is used", () => {
    const one = trimClip(EMPTY, 0, clip, 1, 5).clips[0];
    expect([one?.first_frame, one?.last_frame]).toEqual([11, 51]);
    const all = trimClip(EMPTY, 0, clip, 0, 9.9).clips[0];
    expect([all?.first_frame, all?.last_frame]).toEqual([null, null]);
  });

  it("leaves what is told in the first clip's time on the same frames, and drops what is not used", () => {
    let document = addKey(addKey(USED, 0.5, 0.3)[0], 3, 2)[0];
    document = addMarker(addMarker(document, "input", 3.5)[0], "output", 0.1)[0];
    const span = { id: "a", start: 0.5, end: 2 };
    document = {
      ...document,
      locks: [{ ...span, slowest: 1, fastest: 1 }],
      flights: [{ ...span, end: 0.9, flies: true }],
      example: { start: 1.5, end: 4 },
    };
    const later = trimClip(document, 0, clip, 3, 5.5);
    expect(later.keys.map((key) => key.input_time)).toEqual([2]);
    expect(later.locks).toMatchObject([{ start: 0, end: 1 }]);
    expect(later.flights).toEqual([]);
    expect(later.example).toEqual({ start: 0.5, end: 2.5 });
    expect(later.markers.map((marker) => [marker.on, marker.time])).toEqual([
      ["input", 2.5],
      ["output", 0.1],
    ]);
    // Said twice, before the clip was read anew, it is what it was.
    expect(trimClip(later, 0, clip, 3, 5.5)).toEqual(later);
    // Another clip of the group has no times of its own in the document.
    const other = trimClip({ ...document, clips: [...document.clips, ...document.clips] }, 1, clip, 3, 5.5);
    expect(other.keys).toEqual(document.keys);
    expect(other.clips[1]?.first_frame).toBe(31);
  });
});
