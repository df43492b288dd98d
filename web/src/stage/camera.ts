/** The one camera that both halves of the stage are seen by: turned by hand, and set up to look at all figures. */

import * as THREE from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { at } from "../warp";
import type { Cast } from "./cast";
import { type Navigation, navigated } from "./navigation";

const DEGREES = Math.PI / 180;

export class StageCamera {
  private readonly camera = new THREE.PerspectiveCamera(32, 1, 0.01, 1000);
  private readonly controls: OrbitControls;

  /** `turned` is called when a hand has turned or moved it. */
  constructor(canvas: HTMLElement, turned: () => void, navigation: () => Navigation) {
    navigated(canvas, () => this.controls, navigation);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enableDamping = false;
    this.controls.addEventListener("change", turned);
  }

  /**
   * Look at all of the figures, and what else is told; where the camera goes along with a figure, at that one's height.
   */
  frame(casts: readonly Cast[], follow: boolean, beside: THREE.Box3): void {
    const [first] = casts;
    if (!first) return;
    const travel = travelOf(casts).union(beside);
    const centre = travel.getCenter(new THREE.Vector3());
    const across = travel.getSize(new THREE.Vector3()).length();
    const way = rootAt(first, first.clip.n_frames - 1).sub(rootAt(first, 0));
    // Who walks away is seen from the side, and a little from ahead.
    const angle = way.length() > first.height ? Math.atan2(way.x, way.z) + 62 * DEGREES : 35 * DEGREES;
    const size = follow ? first.reach : Math.max(first.reach, 0.42 * across);
    const target = follow ? new THREE.Vector3(0, 0, 0) : new THREE.Vector3(centre.x, 0, centre.z);
    target.y = first.level + 0.5 * first.tall;
    this.controls.target.copy(target);
    const distance = 2.5 * size;
    this.camera.position.set(
      target.x + distance * Math.sin(angle) * 0.97,
      target.y + 0.3 * distance,
      target.z + distance * Math.cos(angle) * 0.97,
    );
    this.camera.near = 0.02 * size;
    this.camera.far = 60 * size + across;
    this.controls.minDistance = 0.4 * size;
    this.controls.maxDistance = 24 * size;
    this.controls.update();
  }

  /** The camera for one half of the stage: of that shape, showing these layers, gone along with a figure. */
  eye(aspect: number, layers: readonly number[], follow: THREE.Vector3 | undefined): THREE.PerspectiveCamera {
    const eye = this.camera.clone();
    eye.aspect = aspect;
    if (follow) eye.position.add(follow);
    eye.layers.set(0);
    for (const layer of layers) eye.layers.enable(layer);
    eye.updateProjectionMatrix();
    eye.updateMatrixWorld();
    return eye;
  }
}

/** Where the figures go on the ground. */
export function travelOf(casts: readonly Cast[]): THREE.Box3 {
  const box = new THREE.Box3();
  for (const cast of casts) {
    const every = Math.max(1, Math.floor(cast.clip.n_frames / 200));
    for (let frame = 0; frame < cast.clip.n_frames; frame += every) box.expandByPoint(rootAt(cast, frame));
  }
  return box;
}

function rootAt(cast: Cast, frame: number): THREE.Vector3 {
  const i = frame * cast.clip.n_nodes * 3;
  return new THREE.Vector3(at(cast.clip.positions, i), cast.level, at(cast.clip.positions, i + 2));
}
