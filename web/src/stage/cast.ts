/** Who is on the stage for one clip: the companion's figure, the output's, and the ghost of a matched pose. */

import * as THREE from "three";
import type { Clip } from "../messages";
import type { Palette } from "../theme";
import { at } from "../warp";
import { groundMove, groundOf, heightOf, mirrored, moved, pairsOf, poseAt, trailNodes } from "./align";
import { Figure } from "./figure";
import { Shadow } from "./ground";
import { mostBodies, OnionMeshes, OnionSkins, type Skin, type Tints } from "./onion";
import { hasSkin, SkinnedBody, SkinShape, topOf } from "./skinned";
import { Trails } from "./trails";

/** Layers: 0 is seen everywhere, these only in their half of a stage side by side. */
export const COMPANION = 1;
export const OUTPUT = 2;

/** How dense the ghost of a matched pose is, and how far the mesh of one is outside of the output's. */
const GHOST_DENSITY = 0.45;
const GHOST_SLEEVE = 0.008;

/** A figure seen at a slant is as long as this share of what it is along the ground. */
const LONG = 0.75;

/** How long a pose is along the ground. */
function lengthOf(pose: Float32Array): number {
  const along = (axis: number): number => {
    const values = pose.filter((_, i) => i % 3 === axis);
    return values.length > 0 ? values.reduce((a, b) => Math.max(a, b)) - values.reduce((a, b) => Math.min(a, b)) : 0;
  };
  return Math.max(along(0), along(2));
}

export class Cast {
  readonly height: number;
  readonly level: number;
  /** As tall as the figure, or as its mesh. */
  readonly tall: number;
  /** What a camera has to have in view. */
  readonly reach: number;
  readonly output: Figure;
  readonly companion: Figure;
  readonly trails: Trails;
  private readonly onion: OnionSkins;
  private readonly onionMeshes: OnionMeshes | null = null;
  private isMesh = false;
  private readonly shadows: readonly [Shadow, Shadow];
  private readonly outputPose: Float32Array;
  private readonly companionPose: Float32Array;
  /** The character's own mesh on both sides; null where its file has none. */
  private readonly skin: { shape: SkinShape; output: SkinnedBody; companion: SkinnedBody } | null = null;
  private ghost: { figure: Figure; clip: Clip; pose: Float32Array } | null = null;
  private ghostMesh: { shape: SkinShape; body: SkinnedBody; clip: Clip } | null = null;

  constructor(
    readonly clip: Clip,
    private readonly scene: THREE.Scene,
    private readonly palette: Palette,
    /** Of a group: the colour that its figures have; both sides of one alone have the theme's. */
    private readonly own: string | null = null,
  ) {
    this.height = heightOf(clip);
    this.level = groundOf(clip);
    const first = poseAt(clip, 0, new Float32Array(3 * clip.n_nodes));
    this.tall = Math.max(this.height, hasSkin(clip) ? topOf(clip, first, 0) - this.level : 0);
    // Who stands on four legs is longer than tall.
    this.reach = Math.max(this.tall, LONG * lengthOf(first));
    this.output = new Figure(clip, this.height, { color: own ?? palette["figure-output"], opacity: 1 });
    this.companion = new Figure(clip, this.height, { color: palette["figure-input"], opacity: 1 });
    if (hasSkin(clip)) {
      const shape = new SkinShape(clip);
      const output = new SkinnedBody(shape, own ?? palette["figure-output"]);
      this.skin = { shape, output, companion: new SkinnedBody(shape, palette["figure-input"]) };
    }
    this.paintCompanion(palette["figure-input"]);
    const color = new THREE.Color(own ?? palette.output);
    this.trails = new Trails(clip, trailNodes(clip), this.height, color);
    const tint = (name: "lock" | "playhead" | "surface"): THREE.Color => new THREE.Color(palette[name]);
    const tints: Tints = { before: tint("lock"), after: tint("playhead"), far: tint("surface") };
    this.onion = new OnionSkins(clip, this.height, tints);
    const most = mostBodies(clip.skin_points.length / 3);
    if (this.skin && most > 1) this.onionMeshes = new OnionMeshes(clip, this.skin.shape, tints, most, OUTPUT);
    this.shadows = [new Shadow(this.height, this.level), new Shadow(this.height, this.level)];
    this.outputPose = new Float32Array(3 * clip.n_nodes);
    this.companionPose = new Float32Array(3 * clip.n_nodes);
    const layers: [THREE.Object3D, number][] = [
      [this.output.object, OUTPUT],
      [this.companion.object, COMPANION],
      [this.trails.object, OUTPUT],
      [this.onion.object, OUTPUT],
      [this.shadows[0].object, COMPANION],
      [this.shadows[1].object, OUTPUT],
    ];
    if (this.onionMeshes) scene.add(this.onionMeshes.object);
    if (this.skin) layers.push([this.skin.output.object, OUTPUT], [this.skin.companion.object, COMPANION]);
    for (const [object, layer] of layers) {
      object.traverse((part) => part.layers.set(layer));
      scene.add(object);
    }
  }

  /** Colour the companion: the input's grey, or another warp's colour; in a group with half of its own in it. */
  paintCompanion(color: string): void {
    const mixed = new THREE.Color(color);
    if (this.own) mixed.lerp(new THREE.Color(this.own), 0.5);
    this.companion.paint(`#${mixed.getHexString()}`);
    this.skin?.companion.paint(`#${mixed.getHexString()}`);
  }

  pose(outputInput: number, companionInput: number): void {
    this.output.pose(poseAt(this.clip, outputInput, this.outputPose));
    this.companion.pose(poseAt(this.clip, companionInput, this.companionPose));
    this.skin?.output.pose(this.outputPose, outputInput);
    this.skin?.companion.pose(this.companionPose, companionInput);
    this.shadows[0].under(at(this.companionPose, 0), at(this.companionPose, 2));
    this.shadows[1].under(at(this.outputPose, 0), at(this.outputPose, 2));
  }

  /** Show the character's own mesh, or its bare joints. */
  showSkin(shown: boolean): void {
    const { skin } = this;
    const isSkin = shown && skin !== null;
    this.isMesh = isSkin;
    this.output.object.visible = !isSkin;
    this.companion.object.visible = !isSkin;
    if (!skin) return;
    skin.output.object.visible = isSkin;
    skin.companion.object.visible = isSkin;
  }

  /** Show the body at some moments around the playhead, or at none: as its mesh where that is shown, else its joints. */
  showOnion(skins: readonly Skin[] | null): void {
    const meshes = this.isMesh ? this.onionMeshes : null;
    this.onion.object.visible = skins !== null && !meshes;
    if (this.onionMeshes) this.onionMeshes.object.visible = skins !== null && meshes !== null;
    if (skins) (meshes ?? this.onion).show(skins);
  }

  showShadows(shown: boolean): void {
    for (const shadow of this.shadows) shadow.object.visible = shown;
  }

  /** Where the output's root is, and the companion's: what a camera follows. */
  places(): { output: THREE.Vector3; companion: THREE.Vector3 } {
    const point = (pose: Float32Array): THREE.Vector3 => new THREE.Vector3(at(pose, 0), 0, at(pose, 2));
    return { output: point(this.outputPose), companion: point(this.companionPose) };
  }

  /** Lay a pose of a reference over the output's, turned and shifted on the ground to fit; or take it away. */
  showGhost(reference: Clip | null, time: number, mirror: boolean): void {
    const asMesh = this.isMesh && reference !== null && hasSkin(reference);
    if (this.ghost) this.ghost.figure.object.visible = false;
    if (this.ghostMesh) this.ghostMesh.body.object.visible = false;
    if (!reference || reference.n_nodes === 0) return;
    if (this.ghost?.clip !== reference) {
      this.ghost?.figure.dispose();
      const look = { color: this.palette.reference, opacity: GHOST_DENSITY };
      // Thicker than the figure: a match is often the very same pose, and is seen as a sleeve around it.
      const figure = new Figure(reference, heightOf(reference), look, 1.45);
      figure.object.traverse((part) => part.layers.set(OUTPUT));
      this.scene.add(figure.object);
      this.ghost = { figure, clip: reference, pose: new Float32Array(3 * reference.n_nodes) };
    }
    const pose = poseAt(reference, time, this.ghost.pose);
    if (mirror) mirrored(pose);
    const pairs = pairsOf(reference, this.clip, mirror);
    const move = groundMove(pose, this.outputPose, pairs.length > 0 ? pairs : [[0, 0]]);
    if (asMesh) {
      const { cos, sin, x, z } = move;
      const side = mirror ? -1 : 1;
      const { body } = this.meshOfGhost(reference);
      body.pose(poseAt(reference, time, this.ghost.pose), time);
      body.place(new THREE.Matrix4().set(side * cos, 0, -sin, x, 0, 1, 0, 0, side * sin, 0, cos, z, 0, 0, 0, 1));
      body.object.visible = true;
      return;
    }
    this.ghost.figure.pose(moved(pose, move));
    // Joints would be hidden in the mesh that they are laid over.
    this.ghost.figure.seenThrough(this.isMesh);
    this.ghost.figure.object.visible = true;
  }

  private meshOfGhost(reference: Clip): { body: SkinnedBody } {
    if (this.ghostMesh?.clip === reference) return this.ghostMesh;
    this.disposeGhostMesh();
    const shape = new SkinShape(reference, GHOST_SLEEVE);
    const body = new SkinnedBody(shape, this.palette.reference, GHOST_DENSITY);
    body.object.layers.set(OUTPUT);
    // After the output's own, around which it lies.
    body.object.renderOrder = 1;
    this.scene.add(body.object);
    this.ghostMesh = { shape, body, clip: reference };
    return this.ghostMesh;
  }

  private disposeGhostMesh(): void {
    this.ghostMesh?.body.dispose();
    this.ghostMesh?.shape.dispose();
    this.ghostMesh = null;
  }

  dispose(): void {
    for (const part of [this.output, this.companion, this.trails, ...this.shadows]) part.dispose();
    this.onion.dispose();
    this.onionMeshes?.dispose();
    this.disposeGhostMesh();
    if (this.skin) for (const part of [this.skin.output, this.skin.companion, this.skin.shape]) part.dispose();
    this.ghost?.figure.dispose();
  }
}
