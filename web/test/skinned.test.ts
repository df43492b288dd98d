import * as THREE from "three";
import { describe, expect, it } from "vitest";
import { hasSkin, SkinnedBody, SkinShape, topOf, turnAt } from "../src/stage/skinned";
import { clipOf } from "./clips";

/** A flag of three points on a joint that turns a quarter about Z in a second, and goes up by 2. */
const HALF = Math.SQRT1_2;
const CLIP = clipOf({
  rate: 1,
  n_frames: 2,
  n_nodes: 1,
  names: ["pole"],
  parents: [-1],
  positions: Float32Array.of(0, 1, 0, 0, 3, 0),
  skin_points: Float32Array.of(0, 0, 0, 2, 0, 0, 1, 0, 1),
  skin_triangles: Int32Array.of(0, 1, 2),
  // Half as large, and a little to the right, in the joint's space.
  skin_bones: Float32Array.of(0.5, 0, 0, 1, 0, 0.5, 0, 0, 0, 0, 0.5, 0),
  skin_joints: Int32Array.of(0),
  skin_follows: new Int32Array(12),
  skin_weights: Float32Array.of(1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0),
  turns: Float32Array.of(1, 0, 0, 0, HALF, 0, 0, HALF),
});

describe("a mesh of a character", () => {
  it("is there where the file has one", () => {
    expect(hasSkin(CLIP)).toBe(true);
    expect(hasSkin(clipOf({}))).toBe(false);
  });

  it("turns the shorter way between frames", () => {
    const turned = new THREE.Vector3(1, 0, 0).applyQuaternion(turnAt(CLIP, 0, 0.5, new THREE.Quaternion()));
    expect([turned.x, turned.y]).toEqual([expect.closeTo(HALF), expect.closeTo(HALF)]);
    // A quaternion and its negative are one turn.
    const other = { ...CLIP, turns: Float32Array.of(1, 0, 0, 0, -HALF, 0, 0, -HALF) };
    const same = new THREE.Vector3(1, 0, 0).applyQuaternion(turnAt(other, 0, 0.5, new THREE.Quaternion()));
    expect([same.x, same.y]).toEqual([expect.closeTo(HALF), expect.closeTo(HALF)]);
  });

  it("has its points where its joint puts them", () => {
    const body = new SkinnedBody(new SkinShape(CLIP), "#ffffff");
    body.pose(Float32Array.of(0, 3, 0), 1);
    body.object.updateMatrixWorld(true);
    body.object.skeleton.update();
    const tip = body.object.applyBoneTransform(1, new THREE.Vector3(2, 0, 0));
    // 2 is 1 in the joint's space, and 1 to the right: turned upward, on top of the joint at 3.
    expect([tip.x, tip.y, tip.z].map((one) => one + 0)).toEqual([
      expect.closeTo(0, 5),
      expect.closeTo(5, 5),
      expect.closeTo(0, 5),
    ]);
    expect(topOf(CLIP, Float32Array.of(0, 3, 0), 1)).toBeCloseTo(5, 5);
    expect(topOf(CLIP, Float32Array.of(0, 1, 0), 0)).toBeCloseTo(1, 5);
    body.dispose();
  });
});
