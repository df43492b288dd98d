/** Poses: between frames, and one laid over another. */

import type { Clip } from "../messages";
import { clamp } from "../scale";
import { at } from "../warp";

/** Positions of all nodes at a time, between frames interpolated; three numbers a node. */
export function poseAt(clip: Clip, time: number, out: Float32Array): Float32Array {
  const size = clip.n_nodes * 3;
  const place = clamp(time * clip.rate, 0, clip.n_frames - 1);
  const before = Math.floor(place);
  const share = place - before;
  const from = before * size;
  const to = Math.min(before + 1, clip.n_frames - 1) * size;
  for (let i = 0; i < size; i++) {
    const a = at(clip.positions, from + i);
    out[i] = a + share * (at(clip.positions, to + i) - a);
  }
  return out;
}

/** A turn about the vertical and a shift on the ground. */
export interface GroundMove {
  readonly cos: number;
  readonly sin: number;
  readonly x: number;
  readonly z: number;
}

/**
 * The turn about the vertical and the shift on the ground that bring `pose` nearest to `target`, node by node.
 *
 * `pairs` holds indices into the two, one after the other. Of the turns the one is taken that makes the sum of squared
 * distances least: about both centres, tan(angle) = Σ cross / Σ dot.
 */
export function groundMove(
  pose: Float32Array,
  target: Float32Array,
  pairs: readonly (readonly [number, number])[],
): GroundMove {
  const n = Math.max(pairs.length, 1);
  let px = 0;
  let pz = 0;
  let tx = 0;
  let tz = 0;
  for (const [p, t] of pairs) {
    px += at(pose, 3 * p) / n;
    pz += at(pose, 3 * p + 2) / n;
    tx += at(target, 3 * t) / n;
    tz += at(target, 3 * t + 2) / n;
  }
  let dot = 0;
  let cross = 0;
  for (const [p, t] of pairs) {
    const ax = at(pose, 3 * p) - px;
    const az = at(pose, 3 * p + 2) - pz;
    const bx = at(target, 3 * t) - tx;
    const bz = at(target, 3 * t + 2) - tz;
    dot += ax * bx + az * bz;
    cross += ax * bz - az * bx;
  }
  const length = Math.hypot(dot, cross);
  const cos = length > 0 ? dot / length : 1;
  const sin = length > 0 ? cross / length : 0;
  return { cos, sin, x: tx - (cos * px - sin * pz), z: tz - (sin * px + cos * pz) };
}

/** Apply a move to a pose, in place. */
export function moved(pose: Float32Array, { cos, sin, x, z }: GroundMove): Float32Array {
  for (let i = 0; i + 2 < pose.length; i += 3) {
    const px = at(pose, i);
    const pz = at(pose, i + 2);
    pose[i] = cos * px - sin * pz + x;
    pose[i + 2] = sin * px + cos * pz + z;
  }
  return pose;
}

/** Mirror a pose in the plane x = 0, in place; a mirrored reference is drawn so. */
export function mirrored(pose: Float32Array): Float32Array {
  for (let i = 0; i < pose.length; i += 3) pose[i] = -at(pose, i);
  return pose;
}

/** Nodes of two skeletons that have the same name; where none has, those at the same place, if there are as many. */
export function pairsByName(a: readonly string[], b: readonly string[], swapSides = false): [number, number][] {
  const place = new Map(b.map((name, i) => [name.toLowerCase(), i] as const));
  const pairs: [number, number][] = [];
  a.forEach((name, i) => {
    const lower = name.toLowerCase();
    const j = place.get(swapSides ? otherSide(lower) : lower);
    if (j !== undefined) pairs.push([i, j]);
  });
  if (pairs.length === 0 && a.length === b.length) return a.map((_, i) => [i, i]);
  return pairs;
}

/** Nodes of a reference and of the clip that stand for each other: as the search matched them, else by their names. */
export function pairsOf(reference: Clip, clip: Clip, mirror = false): [number, number][] {
  const place = new Map(clip.names.map((name, i) => [name.toLowerCase(), i] as const));
  const pairs = reference.counterparts.flatMap((name, i): [number, number][] => {
    const node = name === "" ? -1 : reference.names.indexOf(name);
    const own = mirror ? place.get(otherSide(clip.names[i]?.toLowerCase() ?? "")) : i;
    return node >= 0 && own !== undefined ? [[node, own]] : [];
  });
  return pairs.length > 0 ? pairs : pairsByName(reference.names, clip.names, mirror);
}

/** Which sides of the body the nodes are on, as far as their names say. */
export function sidesOf(names: readonly string[]): ("left" | "right" | "")[] {
  // What hangs on a joint is on its side.
  const plain = names.map((name) => name.replace(/^end of /u, ""));
  const all = new Set(plain.map((name) => name.toLowerCase()));
  return plain.map((name) => {
    const lower = name.toLowerCase();
    const said = sideOf(name);
    if (said) return said;
    // lfemur and rfemur are two sides; lowerback alone is none.
    if (lower.startsWith("l") && all.has(`r${lower.slice(1)}`)) return "left";
    return lower.startsWith("r") && all.has(`l${lower.slice(1)}`) ? "right" : "";
  });
}

/** Which side of the body a node is on, as far as its name alone says. */
export function sideOf(name: string): "left" | "right" | "" {
  const lower = name.toLowerCase();
  if (lower.includes("left") || /(^|[^a-z])l([^a-z]|$)/u.test(lower) || /^l[A-Z]/u.test(name)) return "left";
  if (lower.includes("right") || /(^|[^a-z])r([^a-z]|$)/u.test(lower) || /^r[A-Z]/u.test(name)) return "right";
  return "";
}

function otherSide(lower: string): string {
  if (lower.includes("left")) return lower.replace("left", "right");
  if (lower.includes("right")) return lower.replace("right", "left");
  if (/^l/u.test(lower)) return lower.replace(/^l/u, "r");
  if (/^r/u.test(lower)) return lower.replace(/^r/u, "l");
  return lower;
}

/** How tall the figure is: the height of its nodes in the tallest of some poses, in the clip's units. */
export function heightOf(clip: Clip): number {
  let tallest = 0;
  const every = Math.max(1, Math.floor(clip.n_frames / 40));
  for (let frame = 0; frame < clip.n_frames; frame += every) {
    let low = Infinity;
    let high = -Infinity;
    for (let node = 0; node < clip.n_nodes; node++) {
      const y = at(clip.positions, (frame * clip.n_nodes + node) * 3 + 1);
      low = Math.min(low, y);
      high = Math.max(high, y);
    }
    tallest = Math.max(tallest, high - low);
  }
  return tallest > 0 ? tallest : 1;
}

/** The ground that the figure stands on: low enough for nearly all of its frames. */
export function groundOf(clip: Clip): number {
  const lows: number[] = [];
  for (let frame = 0; frame < clip.n_frames; frame++) {
    let low = Infinity;
    for (let node = 0; node < clip.n_nodes; node++) {
      low = Math.min(low, at(clip.positions, (frame * clip.n_nodes + node) * 3 + 1));
    }
    lows.push(low);
  }
  lows.sort((a, b) => a - b);
  return lows[Math.floor(lows.length * 0.02)] ?? 0;
}

/** The root, and the ends of the limbs: nodes whose trails tell most. */
export function trailNodes(clip: Clip, most = 5): number[] {
  const isParent = new Set(clip.parents);
  const leaves = clip.names.map((_, i) => i).filter((i) => !isParent.has(i));
  const every = Math.max(1, Math.floor(clip.n_frames / 20));
  // Fingers of one hand stay close together: of each bunch one is enough.
  const distance = (a: number, b: number): number => {
    let sum = 0;
    let n = 0;
    for (let frame = 0; frame < clip.n_frames; frame += every) {
      const p = (frame * clip.n_nodes + a) * 3;
      const q = (frame * clip.n_nodes + b) * 3;
      sum += Math.hypot(
        at(clip.positions, p) - at(clip.positions, q),
        at(clip.positions, p + 1) - at(clip.positions, q + 1),
        at(clip.positions, p + 2) - at(clip.positions, q + 2),
      );
      n++;
    }
    return sum / n;
  };
  const apart = 0.2 * heightOf(clip);
  const chosen = [0];
  for (const leaf of leaves.sort((a, b) => distance(b, 0) - distance(a, 0))) {
    if (chosen.length > most) break;
    if (chosen.every((other) => distance(leaf, other) > apart)) chosen.push(leaf);
  }
  return chosen;
}
