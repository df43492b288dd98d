/** Onion skins: the body at even output times around the playhead, what was in one tint and what comes in another. */

import * as THREE from "three";
import type { Clip } from "../messages";
import { at } from "../warp";
import { poseAt } from "./align";
import { boneGeometry, linksOf } from "./figure";

/** Bodies at most on each side of the playhead. */
const MOST_BODIES = 7;
const UP = new THREE.Vector3(0, 1, 0);

/** What an onion skin shows. */
export interface Skin {
  /** Input time. */
  readonly time: number;
  /** From 0 to 1: how near it is to the playhead. */
  readonly near: number;
  readonly isLater: boolean;
}

export class OnionSkins {
  readonly object: THREE.InstancedMesh;
  private readonly material: THREE.MeshLambertMaterial;
  private readonly links: readonly (readonly [number, number])[];
  private readonly pose: Float32Array;
  private readonly radius: number;
  private readonly most: number;
  private readonly matrix = new THREE.Matrix4();
  private readonly turn = new THREE.Quaternion();
  private readonly from = new THREE.Vector3();
  private readonly along = new THREE.Vector3();
  private readonly scale = new THREE.Vector3();
  private readonly color = new THREE.Color();

  constructor(
    private readonly clip: Clip,
    height: number,
    private readonly before: THREE.Color,
    private readonly after: THREE.Color,
    /** What far ones fade to: the stage behind them. */
    private readonly far: THREE.Color,
  ) {
    this.pose = new Float32Array(3 * clip.n_nodes);
    this.links = linksOf(clip);
    this.radius = 0.019 * height;
    this.most = Math.max(1, 2 * MOST_BODIES * this.links.length);
    this.material = new THREE.MeshLambertMaterial({ color: 0xffffff, transparent: true, opacity: 0.5 });
    this.object = new THREE.InstancedMesh(boneGeometry(), this.material, this.most);
    this.object.frustumCulled = false;
    // Behind the figure that is looked at, whatever the camera's order is.
    this.object.renderOrder = -1;
  }

  show(skins: readonly Skin[]): void {
    let n = 0;
    const nearest = [...skins].sort((a, b) => b.near - a.near);
    for (const { time, near, isLater } of nearest) {
      if (n + this.links.length > this.most) break;
      poseAt(this.clip, time, this.pose);
      this.color.copy(this.far).lerp(isLater ? this.after : this.before, 0.35 + 0.65 * near);
      for (const [parent, node] of this.links) {
        const { pose } = this;
        this.from.set(at(pose, 3 * parent), at(pose, 3 * parent + 1), at(pose, 3 * parent + 2));
        this.along.set(at(pose, 3 * node), at(pose, 3 * node + 1), at(pose, 3 * node + 2)).sub(this.from);
        const length = this.along.length();
        const radius = Math.min(this.radius, 0.35 * length);
        if (length > 0) this.turn.setFromUnitVectors(UP, this.along.divideScalar(length));
        this.matrix.compose(this.from, this.turn, this.scale.set(radius, length, radius));
        this.object.setMatrixAt(n, this.matrix);
        this.object.setColorAt(n, this.color);
        n++;
      }
    }
    this.object.count = n;
    this.object.instanceMatrix.needsUpdate = true;
    if (this.object.instanceColor) this.object.instanceColor.needsUpdate = true;
  }

  dispose(): void {
    this.object.geometry.dispose();
    this.object.dispose();
    this.material.dispose();
    this.object.removeFromParent();
  }
}
