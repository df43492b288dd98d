import { expect, test } from "vitest";
import { addClip } from "../src/document";
import { apart, endTogether, groupPaths, trimTogether } from "../src/group";
import { cameraOf, isCamera, placeAt } from "../src/stage/cameras";
import { clipOf } from "./clips";
import { EMPTY } from "./empty";

// 4 s at 10 a second; 3 s at 20; as long as the first, at another rate.
const CLIPS = [
  clipOf({ first_frame: 1 }),
  clipOf({ rate: 20, n_frames: 61, first_frame: 5 }),
  clipOf({ rate: 20, n_frames: 82 }),
];
const DOCUMENT = addClip(addClip(EMPTY, "camera.csv"), "prop.bvh");

test("clips that end elsewhere are told, those of another rate that last as long are not", () => {
  expect(apart(CLIPS)).toEqual([{ index: 1, seconds: -1 }]);
  expect(apart(CLIPS.slice(0, 1))).toEqual([]);
  expect(apart([])).toEqual([]);
});

test("they are aligned by an offset, or by using what the shortest has", () => {
  expect(endTogether(DOCUMENT, CLIPS, 1).clips.map((clip) => clip.offset)).toEqual([null, "1s", null]);
  const trimmed = trimTogether(DOCUMENT, CLIPS);
  // 3 s are frames 1 to 31 of the first as its file numbers them; the shortest keeps all.
  expect(trimmed.clips.map((clip) => clip.last_frame)).toEqual([31, null, 60]);
  const moved = trimTogether(endTogether(DOCUMENT, CLIPS, 2), CLIPS);
  expect(moved.clips.map((clip) => clip.last_frame)).toEqual([31, null, null]);
});

test("each clip of a group is written under its own name and ending, no two under one", () => {
  expect(groupPaths("/out/*_retimed", ["/a/walk.bvh", "/b/walk.bvh", "C:\\c\\cam.era.csv", "plain"])).toEqual([
    "/out/walk_retimed.bvh",
    "/out/walk-2_retimed.bvh",
    "/out/cam.era_retimed.csv",
    "/out/plain_retimed",
  ]);
});

test("a camera is between two frames where it is half way, and held at its ends", () => {
  const half = Math.SQRT1_2;
  const camera = clipOf({
    rate: 10,
    n_frames: 2,
    camera: Float32Array.of(0, 1, 2, 1, 0, 0, 0, 40, 2, 1, 0, half, 0, half, 0, 50),
  });
  expect([isCamera(camera), isCamera(clipOf({}))]).toEqual([true, false]);
  const { position, rotation, view } = placeAt(camera, 0.05);
  expect(position.toArray()).toEqual([1, 1, 1]);
  expect(view).toBeCloseTo(45, 6);
  // Half of a quarter turn about Y.
  expect(rotation.y).toBeCloseTo(Math.sin(Math.PI / 8), 6);
  expect(placeAt(camera, 9).position.toArray()).toEqual([2, 1, 0]);
  expect(placeAt(camera, -1).view).toBe(40);
  expect(cameraOf([clipOf({}), camera], 0)).toBe(camera);
  expect(cameraOf([clipOf({})], 0)).toBeNull();
});
