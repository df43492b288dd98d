import * as THREE from "three";
import { describe, expect, it } from "vitest";
import { MOST_POINTS, mostBodies, OnionMeshes } from "../src/stage/onion";
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

  it("is put elsewhere as a whole, mirrored or turned", () => {
    const body = new SkinnedBody(new SkinShape(CLIP), "#ffffff", 0.4);
    body.pose(Float32Array.of(0, 3, 0), 1);
    // Mirrored in x, and 10 ahead.
    body.place(new THREE.Matrix4().set(-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 10, 0, 0, 0, 1));
    body.object.updateMatrixWorld(true);
    body.object.skeleton.update();
    const base = body.object.applyBoneTransform(2, new THREE.Vector3(1, 0, 1)).applyMatrix4(body.object.matrixWorld);
    // 1 along x and z is half of that in the joint's space, and 1 to the right: turned upward, above the joint at 3.
    expect([base.x, base.y, base.z]).toEqual([expect.closeTo(0, 5), expect.closeTo(4.5, 5), expect.closeTo(10.5, 5)]);
    body.dispose();
  });

  it("has a sleeve around it, as far off everywhere", () => {
    const [plain, sleeve] = [new SkinShape(CLIP), new SkinShape(CLIP, 0.1)].map(
      ({ geometry }) => geometry.getAttribute("position").array,
    );
    const size = Math.hypot(2, 1);
    for (let i = 0; i < 9; i++) {
      const off = (sleeve?.[i] ?? 0) - (plain?.[i] ?? 0);
      expect(Math.abs(off)).toBeCloseTo(i % 3 === 1 ? 0.1 * size : 0, 5);
    }
    // The clip's own points are as they were.
    expect([...CLIP.skin_points]).toEqual([0, 0, 0, 2, 0, 0, 1, 0, 1]);
  });
});

describe("onion skins of a mesh", () => {
  const tints = { before: new THREE.Color(1, 0, 0), after: new THREE.Color(0, 0, 1), far: new THREE.Color(0, 0, 0) };
  const colors = (onion: OnionMeshes): string[] =>
    onion.object.children
      .filter((child) => child.visible)
      .map((child) => ((child as THREE.SkinnedMesh).material as THREE.MeshLambertMaterial).color.getHexString());

  it("are the nearest moments, tinted by what they are and how near", () => {
    const onion = new OnionMeshes(CLIP, new SkinShape(CLIP), tints, 2, 2);
    onion.show([
      { time: 0, near: 0.2, isLater: false },
      { time: 0.5, near: 0.9, isLater: true },
      { time: 1, near: 0.6, isLater: false },
    ]);
    const [nearest, next] = colors(onion).map((hex) => new THREE.Color(`#${hex}`));
    expect(onion.object.children.length).toBe(2);
    expect([nearest?.r, next?.b]).toEqual([0, 0]);
    expect(nearest?.b).toBeGreaterThan(next?.r ?? 1);
    expect(next?.r).toBeGreaterThan(0.3);
    const [, bone] = onion.object.children.map((child) => (child as THREE.SkinnedMesh).skeleton.bones[0]);
    expect(bone?.matrixWorld.elements[13]).toBeCloseTo(3, 5);
    onion.show([{ time: 0, near: 0.5, isLater: true }]);
    expect(colors(onion).length).toBe(1);
    onion.dispose();
  });

  it("are fewer where a body has many points, and none where they would cost too much", () => {
    expect([1, 5000, MOST_POINTS / 14, MOST_POINTS / 4, MOST_POINTS, MOST_POINTS + 1].map(mostBodies)).toEqual([
      14, 14, 14, 4, 1, 0,
    ]);
  });
});
