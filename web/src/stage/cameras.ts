/** Cameras of the group: shown as what they see, along their path, and looked through. */

import * as THREE from "three";
import type { Clip } from "../messages";
import { clamp } from "../scale";
import { at } from "../warp";
import { COMPANION, OUTPUT } from "./cast";

/** Numbers of a frame: place, rotation (wxyz), view. */
const NUMBERS = 8;
/** How wide a picture is for its height. */
const ASPECT = 16 / 9;
const DEGREES = Math.PI / 180;

export function isCamera(clip: Clip): boolean {
  return clip.camera.length > 0;
}

/** The camera that is looked through: the clip that is chosen, if it is one, or the first. */
export function cameraOf(clips: readonly Clip[], chosen: number): Clip | null {
  const one = clips[chosen];
  return one && isCamera(one) ? one : (clips.find(isCamera) ?? null);
}

interface Place {
  readonly position: THREE.Vector3;
  readonly rotation: THREE.Quaternion;
  /** From the lower edge to the upper, degrees. */
  readonly view: number;
}

/** Where a camera is at a time of its clip, between two frames too. */
export function placeAt({ camera, rate }: Clip, time: number): Place {
  const last = camera.length / NUMBERS - 1;
  const frame = clamp(time * rate, 0, last);
  const first = Math.min(Math.floor(frame), Math.max(last - 1, 0));
  const read = (i: number): Place => {
    const [x, y, z, qw, qx, qy, qz, view] = Array.from({ length: NUMBERS }, (_, j) => at(camera, NUMBERS * i + j));
    return {
      position: new THREE.Vector3(x, y, z),
      rotation: new THREE.Quaternion(qx, qy, qz, qw),
      view: view as number,
    };
  };
  const a = read(first);
  const b = read(Math.min(first + 1, last));
  const share = frame - first;
  return {
    position: a.position.lerp(b.position, share),
    rotation: a.rotation.slerp(b.rotation, share),
    view: a.view + share * (b.view - a.view),
  };
}

/** A camera on the stage, once as the companion has it and once as the output has it. */
export class CameraRig {
  private readonly shown: readonly [THREE.LineSegments, THREE.LineSegments];
  private readonly path: THREE.Line;
  private readonly materials: THREE.LineBasicMaterial[] = [];

  constructor(
    readonly clip: Clip,
    scene: THREE.Scene,
    colors: { readonly companion: string; readonly output: string },
    /** How far away the picture is drawn, metres. */
    private readonly size: number,
  ) {
    const frustum = new THREE.BufferGeometry();
    frustum.setAttribute("position", new THREE.Float32BufferAttribute(frustumLines(), 3));
    const line = (color: string, opacity = 1): THREE.LineBasicMaterial => {
      const made = new THREE.LineBasicMaterial({ color, transparent: opacity < 1, opacity });
      this.materials.push(made);
      return made;
    };
    this.shown = [
      new THREE.LineSegments(frustum, line(colors.companion)),
      new THREE.LineSegments(frustum, line(colors.output)),
    ];
    const points: number[] = [];
    for (let i = 0; i < clip.camera.length; i += NUMBERS) {
      points.push(at(clip.camera, i), at(clip.camera, i + 1), at(clip.camera, i + 2));
    }
    const path = new THREE.BufferGeometry();
    path.setAttribute("position", new THREE.Float32BufferAttribute(points, 3));
    this.path = new THREE.Line(path, line(colors.output, 0.45));
    this.shown[0].layers.set(COMPANION);
    this.shown[1].layers.set(OUTPUT);
    for (const one of [...this.shown, this.path]) {
      one.frustumCulled = false;
      scene.add(one);
    }
  }

  /** Where it goes. */
  get box(): THREE.Box3 {
    return new THREE.Box3().setFromBufferAttribute(
      this.path.geometry.getAttribute("position") as THREE.BufferAttribute,
    );
  }

  /** Stand where the companion and the output have it; what is looked through is not seen. */
  pose(outputInput: number, companionInput: number, visible: boolean): void {
    [companionInput, outputInput].forEach((time, i) => {
      const { position, rotation, view } = placeAt(this.clip, time);
      const high = this.size * Math.tan((view / 2) * DEGREES);
      const shown = this.shown[i] as THREE.LineSegments;
      shown.position.copy(position);
      shown.quaternion.copy(rotation);
      shown.scale.set(high * ASPECT, high, this.size);
      shown.visible = visible;
    });
    this.path.visible = visible;
  }

  dispose(): void {
    for (const one of [...this.shown, this.path]) {
      one.geometry.dispose();
      one.removeFromParent();
    }
    for (const material of this.materials) material.dispose();
  }
}

/** What a camera sees at a time of its clip: all of its picture, whatever the shape of the stage. */
export function eyeOf(clip: Clip, time: number, aspect: number, layers: readonly number[]): THREE.PerspectiveCamera {
  const { position, rotation, view } = placeAt(clip, time);
  // Where the stage is narrower than the picture, the picture's sides decide.
  const high = Math.tan((view / 2) * DEGREES) * Math.max(1, ASPECT / aspect);
  const eye = new THREE.PerspectiveCamera((2 * Math.atan(high)) / DEGREES, aspect, 0.02, 2000);
  eye.position.copy(position);
  eye.quaternion.copy(rotation);
  eye.layers.set(0);
  for (const layer of layers) eye.layers.enable(layer);
  eye.updateProjectionMatrix();
  eye.updateMatrixWorld();
  return eye;
}

/** Lines from the eye to the corners of the picture, around it, and a roof that says where up is. */
function frustumLines(): number[] {
  const corners = [
    [-1, -1, -1],
    [1, -1, -1],
    [1, 1, -1],
    [-1, 1, -1],
  ] as const;
  const lines: number[] = [];
  corners.forEach((corner, i) => {
    lines.push(0, 0, 0, ...corner, ...corner, ...(corners[(i + 1) % 4] as (typeof corners)[number]));
  });
  for (const side of [-0.4, 0.4]) lines.push(side, 1.05, -1, 0, 1.5, -1);
  lines.push(-0.4, 1.05, -1, 0.4, 1.05, -1);
  return lines;
}
