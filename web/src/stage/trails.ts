/** Trails: where the limbs' ends go. */

import * as THREE from "three";
import type { Clip } from "../messages";
import { at } from "../warp";
import { poseAt } from "./align";

/** Most points of a set of trails: what a buffer holds. */
const MOST_POINTS = 4096;

/** Lines through places at even times, with a dot at each: close dots are slow, far ones fast. */
export class Trails {
  readonly object = new THREE.Group();
  private readonly positions = new Float32Array(3 * MOST_POINTS);
  private readonly colors = new Float32Array(4 * MOST_POINTS);
  private readonly lines = new THREE.BufferGeometry();
  private readonly lineMaterial = new THREE.LineBasicMaterial({ vertexColors: true, transparent: true });
  private readonly dotMaterial: THREE.PointsMaterial;
  private readonly pose: Float32Array;

  constructor(
    private readonly clip: Clip,
    private readonly nodes: readonly number[],
    height: number,
    private readonly color: THREE.Color,
  ) {
    this.pose = new Float32Array(3 * clip.n_nodes);
    this.lines.setAttribute("position", new THREE.BufferAttribute(this.positions, 3));
    this.lines.setAttribute("color", new THREE.BufferAttribute(this.colors, 4));
    this.dotMaterial = new THREE.PointsMaterial({
      vertexColors: true,
      transparent: true,
      size: 0.02 * height,
      depthWrite: false,
    });
    const segments = new THREE.LineSegments(this.lines, this.lineMaterial);
    const dots = new THREE.Points(this.lines, this.dotMaterial);
    segments.frustumCulled = false;
    dots.frustumCulled = false;
    this.object.add(segments, dots);
  }

  /** Draw the way at even times: `times` are input times shown at them, `nearness` (0 to 1) how strong each is. */
  show(times: readonly number[], nearness: readonly number[]): void {
    const most = Math.floor(MOST_POINTS / (2 * this.nodes.length)) + 1;
    const steps = Math.min(times.length, most);
    let point = 0;
    const put = (positions: Float32Array, node: number, alpha: number): void => {
      for (let axis = 0; axis < 3; axis++) this.positions[3 * point + axis] = at(positions, 3 * node + axis);
      this.colors.set([this.color.r, this.color.g, this.color.b, alpha], 4 * point);
      point++;
    };
    let before = new Float32Array(0);
    for (let i = 0; i < steps; i++) {
      const pose = poseAt(this.clip, at(times, i), this.pose).slice();
      if (i > 0) {
        for (const node of this.nodes) {
          put(before, node, at(nearness, i - 1));
          put(pose, node, at(nearness, i));
        }
      }
      before = pose;
    }
    this.lines.setDrawRange(0, point);
    for (const name of ["position", "color"])
      (this.lines.getAttribute(name) as THREE.BufferAttribute).needsUpdate = true;
  }

  dispose(): void {
    this.lines.dispose();
    this.lineMaterial.dispose();
    this.dotMaterial.dispose();
    this.object.removeFromParent();
  }
}
