/** The ground: a grid that fades away from where the motion goes. */

import * as THREE from "three";

export interface Travel {
  readonly low: THREE.Vector3;
  readonly high: THREE.Vector3;
}

/** X and Z. */
export type Place = readonly [number, number];

/**
 * A line from place to place, in as few straight pieces as show how strong it is at each; what is not seen is left out.
 *
 * Where the motion goes all of a line is equally strong. Drawn cell by cell, the ground of a long take is tens of
 * thousands of lines a picture, which costs a processor more than the figures do.
 */
export function fewPieces(line: readonly Place[], strength: (place: Place) => number): [Place, Place][] {
  const pieces: [Place, Place][] = [];
  let even = false;
  for (const [i, to] of line.entries()) {
    const from = line[i - 1];
    if (!from) continue;
    const [before, after] = [strength(from), strength(to)];
    const last = pieces.at(-1);
    if (before === after && even && last) last[1] = to;
    else if (before > 0 || after > 0) pieces.push([from, to]);
    even = before === after && after > 0;
  }
  return pieces;
}

export class Ground {
  readonly object: THREE.LineSegments;
  private readonly geometry = new THREE.BufferGeometry();
  private readonly material = new THREE.LineBasicMaterial({ vertexColors: true, transparent: true, depthWrite: false });

  constructor(travel: Travel, height: number, level: number, color: THREE.Color) {
    // A cell is a metre for a person, and as much larger or smaller as the figure is.
    const cell = 10 ** Math.round(Math.log10(height / 1.7));
    const margin = 6 * height;
    const begin = (value: number): number => Math.floor((value - margin) / cell);
    const end = (value: number): number => Math.ceil((value + margin) / cell);
    let [x0, x1, z0, z1] = [begin(travel.low.x), end(travel.high.x), begin(travel.low.z), end(travel.high.z)];
    const most = 120;
    if (x1 - x0 > most || z1 - z0 > most) {
      const middle = [Math.round((x0 + x1) / 2), Math.round((z0 + z1) / 2)] as const;
      [x0, x1, z0, z1] = [middle[0] - most / 2, middle[0] + most / 2, middle[1] - most / 2, middle[1] + most / 2];
    }
    const positions: number[] = [];
    const colors: number[] = [];
    const strength = ([x, z]: Place): number => {
      const outside = Math.hypot(
        Math.max(travel.low.x - x, 0, x - travel.high.x),
        Math.max(travel.low.z - z, 0, z - travel.high.z),
      );
      return 0.9 * Math.max(0, 1 - outside / margin) ** 1.5;
    };
    const put = ([x, z]: Place): void => {
      positions.push(x, level, z);
      colors.push(color.r, color.g, color.b, strength([x, z]));
    };
    const draw = (line: readonly Place[]): void => {
      for (const [from, to] of fewPieces(line, strength)) {
        put(from);
        put(to);
      }
    };
    const whole = (first: number, last: number): number[] =>
      Array.from({ length: last - first + 1 }, (_, n) => (first + n) * cell);
    const [xs, zs] = [whole(x0, x1), whole(z0, z1)];
    for (const z of zs) draw(xs.map((x) => [x, z]));
    for (const x of xs) draw(zs.map((z) => [x, z]));
    this.geometry.setAttribute("position", new THREE.Float32BufferAttribute(positions, 3));
    this.geometry.setAttribute("color", new THREE.Float32BufferAttribute(colors, 4));
    this.object = new THREE.LineSegments(this.geometry, this.material);
    this.object.frustumCulled = false;
  }

  dispose(): void {
    this.geometry.dispose();
    this.material.dispose();
    this.object.removeFromParent();
  }
}

/** A soft dark spot under a figure, so that it stands on the ground. */
export class Shadow {
  readonly object: THREE.Mesh;

  constructor(
    height: number,
    private readonly level: number,
  ) {
    const rings = 6;
    const sides = 24;
    const positions: number[] = [];
    const colors: number[] = [];
    const put = (ring: number, side: number): void => {
      const angle = (2 * Math.PI * side) / sides;
      const share = ring / rings;
      positions.push(0.26 * height * share * Math.cos(angle), 0, -0.26 * height * share * Math.sin(angle));
      colors.push(0, 0, 0, 0.3 * (1 - share) ** 2);
    };
    for (let ring = 0; ring < rings; ring++) {
      for (let side = 0; side < sides; side++) {
        put(ring, side);
        put(ring + 1, side);
        put(ring + 1, side + 1);
        put(ring, side);
        put(ring + 1, side + 1);
        put(ring, side + 1);
      }
    }
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.Float32BufferAttribute(positions, 3));
    geometry.setAttribute("color", new THREE.Float32BufferAttribute(colors, 4));
    const material = new THREE.MeshBasicMaterial({ vertexColors: true, transparent: true, depthWrite: false });
    this.object = new THREE.Mesh(geometry, material);
    this.object.renderOrder = -1;
  }

  under(x: number, z: number): void {
    this.object.position.set(x, this.level + 0.002, z);
  }

  dispose(): void {
    this.object.geometry.dispose();
    (this.object.material as THREE.Material).dispose();
    this.object.removeFromParent();
  }
}
