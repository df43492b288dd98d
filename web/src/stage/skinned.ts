/** The character's own mesh, where its file has one: it follows the joints as its skin says. */

import * as THREE from "three";
import type { Clip } from "../messages";
import { clamp } from "../scale";
import { at } from "../warp";

/** Whether a clip has a mesh of its own. */
export function hasSkin(clip: Clip): boolean {
  return clip.skin_triangles.length > 0;
}

/** The turn of a joint at a time, between frames by the shorter way. */
export function turnAt(clip: Clip, joint: number, time: number, out: THREE.Quaternion): THREE.Quaternion {
  const joints = clip.turns.length / (4 * clip.n_frames);
  const place = clamp(time * clip.rate, 0, clip.n_frames - 1);
  const before = Math.floor(place);
  const after = Math.min(before + 1, clip.n_frames - 1);
  quaternion(clip.turns, before * joints + joint, out);
  return out.slerp(quaternion(clip.turns, after * joints + joint, BESIDE), place - before);
}

const BESIDE = new THREE.Quaternion();

function quaternion(turns: Float32Array, index: number, out: THREE.Quaternion): THREE.Quaternion {
  const i = 4 * index;
  return out.set(at(turns, i + 1), at(turns, i + 2), at(turns, i + 3), at(turns, i));
}

/** How high the mesh reaches at a time: the highest of its points, or of so many of them. */
export function topOf(clip: Clip, positions: Float32Array, time: number, most = 4000): number {
  const places = [...clip.skin_joints].map((joint) => {
    const turn = turnAt(clip, joint, time, new THREE.Quaternion());
    return { turn, y: at(positions, 3 * joint + 1) };
  });
  const points = clip.skin_points.length / 3;
  const every = Math.max(1, Math.floor(points / most));
  const local = new THREE.Vector3();
  let top = -Infinity;
  for (let point = 0; point < points; point += every) {
    let y = 0;
    for (let k = 0; k < 4; k++) {
      const weight = at(clip.skin_weights, 4 * point + k);
      if (weight === 0) continue;
      const bone = at(clip.skin_follows, 4 * point + k);
      const along = (row: number): number =>
        [0, 1, 2].reduce(
          (sum, axis) => sum + at(clip.skin_bones, 12 * bone + 4 * row + axis) * at(clip.skin_points, 3 * point + axis),
          at(clip.skin_bones, 12 * bone + 4 * row + 3),
        );
      const place = places[bone];
      if (!place) continue;
      y += weight * (local.set(along(0), along(1), along(2)).applyQuaternion(place.turn).y + place.y);
    }
    top = Math.max(top, y);
  }
  return top;
}

/** What of a mesh is the same for all figures of a clip. */
export class SkinShape {
  readonly geometry = new THREE.BufferGeometry();
  readonly inverses: readonly THREE.Matrix4[];

  /** `sleeve`: the points lie so far outside of the mesh, as a share of its size. */
  constructor(
    readonly clip: Clip,
    sleeve = 0,
  ) {
    const { geometry } = this;
    geometry.setAttribute("position", new THREE.BufferAttribute(clip.skin_points, 3));
    geometry.setAttribute("skinIndex", new THREE.BufferAttribute(Uint16Array.from(clip.skin_follows), 4));
    geometry.setAttribute("skinWeight", new THREE.BufferAttribute(clip.skin_weights, 4));
    geometry.setIndex(new THREE.BufferAttribute(Uint32Array.from(clip.skin_triangles), 1));
    geometry.computeVertexNormals();
    if (sleeve > 0) geometry.setAttribute("position", new THREE.BufferAttribute(outside(geometry, sleeve), 3));
    this.inverses = [...clip.skin_joints].map((_, bone) => {
      const row = (i: number): number[] => [0, 1, 2, 3].map((k) => at(clip.skin_bones, 12 * bone + 4 * i + k));
      return new THREE.Matrix4().set(
        ...([...row(0), ...row(1), ...row(2), 0, 0, 0, 1] as Parameters<THREE.Matrix4["set"]>),
      );
    });
  }

  dispose(): void {
    this.geometry.dispose();
  }
}

/** The points of a mesh, each moved outward by a share of its size. */
function outside(geometry: THREE.BufferGeometry, share: number): Float32Array {
  const points = geometry.getAttribute("position").array;
  const normals = geometry.getAttribute("normal").array;
  geometry.computeBoundingBox();
  const by = share * (geometry.boundingBox?.getSize(new THREE.Vector3()).length() ?? 0);
  return Float32Array.from(points, (value, i) => value + by * (normals[i] ?? 0));
}

export class SkinnedBody {
  readonly object: THREE.SkinnedMesh;
  private readonly material = new THREE.MeshLambertMaterial({ side: THREE.DoubleSide, transparent: true });
  private readonly bones: readonly THREE.Bone[];
  private readonly skeleton: THREE.Skeleton;
  private readonly turn = new THREE.Quaternion();
  private readonly at = new THREE.Vector3();
  private readonly unit = new THREE.Vector3(1, 1, 1);

  constructor(
    private readonly shape: SkinShape,
    color: string,
    opacity = 1,
  ) {
    // One that is dense is drawn among those that are not, so that those of a lower order lie behind it everywhere.
    this.material.forceSinglePass = true;
    if (opacity < 1) {
      this.material.opacity = opacity;
      this.material.depthWrite = false;
    }
    this.bones = shape.inverses.map(() => new THREE.Bone());
    this.skeleton = new THREE.Skeleton([...this.bones], [...shape.inverses]);
    this.object = new THREE.SkinnedMesh(shape.geometry, this.material);
    this.object.bind(this.skeleton, new THREE.Matrix4());
    // The points are where the joints put them, and from there where `place` does.
    this.object.bindMode = THREE.DetachedBindMode;
    this.object.matrixAutoUpdate = false;
    this.object.frustumCulled = false;
    this.paint(color);
  }

  paint(color: string | THREE.Color): void {
    this.material.color.set(color);
  }

  /** Put the whole of it elsewhere than its joints are. */
  place(where: THREE.Matrix4): void {
    this.object.matrix.copy(where);
    this.object.matrixWorldNeedsUpdate = true;
  }

  /** Take the pose of a time; `positions` are those of the nodes then. */
  pose(positions: Float32Array, time: number): void {
    const { clip } = this.shape;
    this.bones.forEach((bone, i) => {
      const joint = at(clip.skin_joints, i);
      this.at.set(at(positions, 3 * joint), at(positions, 3 * joint + 1), at(positions, 3 * joint + 2));
      bone.matrixWorld.compose(this.at, turnAt(clip, joint, time, this.turn), this.unit);
    });
  }

  dispose(): void {
    this.material.dispose();
    this.skeleton.dispose();
    this.object.removeFromParent();
  }
}
