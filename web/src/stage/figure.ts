/** A figure of the stage: tapered bones and round joints, drawn as two sets of instances. */

import * as THREE from "three";
import { mergeVertices } from "three/examples/jsm/utils/BufferGeometryUtils.js";
import type { Clip } from "../messages";
import { at } from "../warp";
import { sidesOf } from "./align";

const UP = new THREE.Vector3(0, 1, 0);

export interface Look {
  color: string;
  opacity: number;
}

/** Parent and child of each bone. */
export function linksOf(clip: Clip): readonly (readonly [number, number])[] {
  return clip.parents.flatMap((parent, node) => (parent >= 0 ? [[parent, node] as const] : []));
}

/** A bone of length and thickness 1, upward from its joint, thinner toward its end; open, for both ends lie inside of joints. */
export function boneGeometry(): THREE.CylinderGeometry {
  const bone = new THREE.CylinderGeometry(0.62, 1, 1, 7, 1, true);
  bone.translate(0, 0.5, 0);
  return bone;
}

/** A ball of radius 1, whose faces share their corners: where the processor draws, each corner is worked out once. */
export function jointGeometry(): THREE.BufferGeometry {
  const ball = new THREE.IcosahedronGeometry(1, 1);
  // Where a picture would lie on it differs from face to face, and there is none.
  ball.deleteAttribute("uv");
  const shared = mergeVertices(ball);
  ball.dispose();
  return shared;
}

export class Figure {
  readonly object = new THREE.Group();
  private readonly bones: THREE.InstancedMesh;
  private readonly joints: THREE.InstancedMesh;
  private readonly links: readonly (readonly [number, number])[];
  private readonly material: THREE.MeshLambertMaterial;
  private readonly radius: number;
  /** Of each joint: as thick as the thickest bone at it. */
  private readonly radii: Float64Array;
  private readonly matrix = new THREE.Matrix4();
  private readonly turn = new THREE.Quaternion();
  private readonly from = new THREE.Vector3();
  private readonly along = new THREE.Vector3();
  private readonly scale = new THREE.Vector3();

  constructor(
    private readonly clip: Clip,
    height: number,
    look: Look,
    thickness = 1,
  ) {
    this.links = linksOf(clip);
    this.radius = 0.021 * height * thickness;
    this.radii = new Float64Array(clip.n_nodes);
    for (const [parent, node] of this.links) {
      const length = Math.hypot(
        ...[0, 1, 2].map((i) => at(clip.positions, 3 * node + i) - at(clip.positions, 3 * parent + i)),
      );
      for (const end of [parent, node]) {
        this.radii[end] = Math.max(at(this.radii, end), Math.min(this.radius, 0.35 * length));
      }
    }
    this.material = new THREE.MeshLambertMaterial({
      color: 0xffffff,
      transparent: look.opacity < 1,
      opacity: look.opacity,
    });
    if (look.opacity < 1) this.material.depthWrite = false;
    this.bones = new THREE.InstancedMesh(boneGeometry(), this.material, Math.max(this.links.length, 1));
    this.joints = new THREE.InstancedMesh(jointGeometry(), this.material, Math.max(clip.n_nodes, 1));
    this.bones.frustumCulled = false;
    this.joints.frustumCulled = false;
    this.object.add(this.bones, this.joints);
    this.paint(look.color);
  }

  /** Colour it; the left side lighter and the right side darker, so that the two can be told apart. */
  paint(color: string): void {
    const plain = new THREE.Color(color);
    // Dark colours get little white: with more of it they would be another's.
    const luminance = 0.2126 * plain.r + 0.7152 * plain.g + 0.0722 * plain.b;
    const white = 0.13 * Math.min(1, 0.15 + luminance / 0.2);
    const shades = {
      "": plain,
      left: plain.clone().lerp(new THREE.Color(0xffffff), white),
      right: plain.clone().lerp(new THREE.Color(0x000000), 0.26),
    };
    const sides = sidesOf(this.clip.names);
    this.links.forEach(([, node], i) => this.bones.setColorAt(i, shades[sides[node] ?? ""]));
    sides.forEach((side, i) => this.joints.setColorAt(i, shades[side]));
    if (this.bones.instanceColor) this.bones.instanceColor.needsUpdate = true;
    if (this.joints.instanceColor) this.joints.instanceColor.needsUpdate = true;
  }

  /** Draw it over what hides it, too: what lies in a mesh is seen through it. */
  seenThrough(on: boolean): void {
    this.material.depthTest = !on;
  }

  pose(positions: Float32Array): void {
    this.links.forEach(([parent, node], i) => {
      this.from.set(at(positions, 3 * parent), at(positions, 3 * parent + 1), at(positions, 3 * parent + 2));
      this.along.set(at(positions, 3 * node), at(positions, 3 * node + 1), at(positions, 3 * node + 2)).sub(this.from);
      const length = this.along.length();
      const radius = Math.min(this.radius, 0.35 * length);
      if (length > 0) this.turn.setFromUnitVectors(UP, this.along.divideScalar(length));
      this.matrix.compose(this.from, this.turn, this.scale.set(radius, length, radius));
      this.bones.setMatrixAt(i, this.matrix);
    });
    this.turn.identity();
    for (let node = 0; node < this.clip.n_nodes; node++) {
      this.from.set(at(positions, 3 * node), at(positions, 3 * node + 1), at(positions, 3 * node + 2));
      this.scale.setScalar(1.06 * at(this.radii, node));
      this.joints.setMatrixAt(node, this.matrix.compose(this.from, this.turn, this.scale));
    }
    this.bones.instanceMatrix.needsUpdate = true;
    this.joints.instanceMatrix.needsUpdate = true;
  }

  dispose(): void {
    this.bones.geometry.dispose();
    this.joints.geometry.dispose();
    this.bones.dispose();
    this.joints.dispose();
    this.material.dispose();
    this.object.removeFromParent();
  }
}
