/** Onion skins: the body at even output times around the playhead, what was in one tint and what comes in another. */

import * as THREE from "three";
import type { Clip } from "../messages";
import { at } from "../warp";
import { poseAt } from "./align";
import { boneGeometry, linksOf } from "./figure";
import { SkinnedBody, type SkinShape } from "./skinned";

/** Bodies at most on each side of the playhead. */
const MOST_BODIES = 7;
const UP = new THREE.Vector3(0, 1, 0);
/** Points that all bodies together have at most: without a graphics card the processor moves each of them. */
export const MOST_POINTS = 150_000;
/** How dense a layer of a mesh is; of most bodies two are seen, its front and its back. */
const DENSITY = 0.3;

/** What an onion skin shows. */
export interface Skin {
  /** Input time. */
  readonly time: number;
  /** From 0 to 1: how near it is to the playhead. */
  readonly near: number;
  readonly isLater: boolean;
}

/** What they are tinted with. */
export interface Tints {
  readonly before: THREE.Color;
  readonly after: THREE.Color;
  /** What far ones fade to: the stage behind them. */
  readonly far: THREE.Color;
}

function tintOf({ near, isLater }: Skin, { before, after, far }: Tints, out: THREE.Color): THREE.Color {
  return out.copy(far).lerp(isLater ? after : before, 0.35 + 0.65 * near);
}

function nearestFirst(skins: readonly Skin[]): Skin[] {
  return [...skins].sort((a, b) => b.near - a.near);
}

/** How many bodies of a mesh are shown at most: as many as of bones, or fewer where each has many points; 0: none. */
export function mostBodies(points: number): number {
  return Math.min(2 * MOST_BODIES, Math.floor(MOST_POINTS / Math.max(points, 1)));
}

/** Onion skins of a clip that has a mesh: the mesh itself. */
export class OnionMeshes {
  readonly object = new THREE.Group();
  private readonly bodies: SkinnedBody[] = [];
  private readonly pose: Float32Array;
  private readonly color = new THREE.Color();

  constructor(
    private readonly clip: Clip,
    private readonly shape: SkinShape,
    private readonly tints: Tints,
    private readonly most: number,
    private readonly layer: number,
  ) {
    this.pose = new Float32Array(3 * clip.n_nodes);
  }

  show(skins: readonly Skin[]): void {
    const shown = nearestFirst(skins).slice(0, this.most);
    while (this.bodies.length < shown.length) {
      const body = new SkinnedBody(this.shape, "#ffffff", DENSITY);
      body.object.renderOrder = -1;
      body.object.layers.set(this.layer);
      this.object.add(body.object);
      this.bodies.push(body);
    }
    this.bodies.forEach((body, i) => {
      const skin = shown[i];
      body.object.visible = skin !== undefined;
      if (!skin) return;
      body.paint(tintOf(skin, this.tints, this.color));
      body.pose(poseAt(this.clip, skin.time, this.pose), skin.time);
    });
  }

  dispose(): void {
    for (const body of this.bodies) body.dispose();
    this.object.removeFromParent();
  }
}

/** Onion skins of bare joints. */
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
    private readonly tints: Tints,
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
    for (const skin of nearestFirst(skins)) {
      if (n + this.links.length > this.most) break;
      poseAt(this.clip, skin.time, this.pose);
      tintOf(skin, this.tints, this.color);
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
