import * as THREE from "three";
import { describe, expect, it } from "vitest";
import { jointGeometry } from "../src/stage/figure";
import { fewPieces, type Place } from "../src/stage/ground";

type Corner = readonly [number, number, number];

/** The corners of each face, in a form that can be compared. */
function faces(geometry: THREE.BufferGeometry): string[] {
  const places = geometry.getAttribute("position");
  const index = geometry.getIndex();
  const corner = (i: number): Corner => {
    const at = index ? index.getX(i) : i;
    return [places.getX(at), places.getY(at), places.getZ(at)];
  };
  const n = index ? index.count : places.count;
  return Array.from({ length: n / 3 }, (_, face) =>
    [0, 1, 2].map((k) => corner(3 * face + k).map((value) => value.toFixed(4))).join(" "),
  );
}

describe("a joint's ball", () => {
  it("has the faces of the ball that it was made of, each corner once", () => {
    const ball = jointGeometry();
    expect(faces(ball).sort()).toEqual(faces(new THREE.IcosahedronGeometry(1, 1)).sort());
    // Twelve corners, and the middles of thirty edges.
    expect(ball.getAttribute("position").count).toBe(42);
  });

  it("is round: its normals point outward", () => {
    const ball = jointGeometry();
    const [places, normals] = [ball.getAttribute("position"), ball.getAttribute("normal")];
    for (let i = 0; i < places.count; i++) {
      expect(normals.getX(i)).toBeCloseTo(places.getX(i), 5);
      expect(normals.getY(i)).toBeCloseTo(places.getY(i), 5);
      expect(normals.getZ(i)).toBeCloseTo(places.getZ(i), 5);
    }
  });
});

describe("a line of the ground", () => {
  const line = (n: number): Place[] => Array.from({ length: n }, (_, i) => [i, 0]);
  const drawn = (strengths: readonly number[]): [number, number][] =>
    fewPieces(line(strengths.length), ([x]) => strengths[x] as number).map(([from, to]) => [from[0], to[0]]);

  it("is one piece where it is equally strong", () => {
    expect(drawn([1, 1, 1, 1])).toEqual([[0, 3]]);
  });

  it("is drawn from place to place where it fades, and not where nothing is seen", () => {
    const faded = [
      [1, 2],
      [2, 3],
      [3, 5],
      [5, 6],
    ];
    expect(drawn([0, 0, 0.5, 1, 1, 1, 0, 0])).toEqual(faded);
  });

  it("shows at every place what it would, cell by cell", () => {
    for (let round = 0; round < 200; round++) {
      const strengths = Array.from({ length: 12 }, () => Math.floor(Math.random() * 3) / 2);
      const pieces = drawn(strengths);
      for (let cell = 0; cell + 1 < strengths.length; cell++) {
        const [from, to] = [strengths[cell] as number, strengths[cell + 1] as number];
        const over = pieces.filter(([first, last]) => first <= cell && cell + 1 <= last);
        expect(over.length, `${strengths}`).toBe(from > 0 || to > 0 ? 1 : 0);
        // A piece goes evenly from the strength of its first place to that of its last.
        for (const [first, last] of over) {
          const [a, b] = [strengths[first] as number, strengths[last] as number];
          for (const place of [cell, cell + 1])
            expect(a + ((place - first) / (last - first)) * (b - a), `${strengths}`).toBe(strengths[place]);
        }
      }
    }
  });

  it("is drawn once, not cell by cell, in the middle of a long take", () => {
    expect(drawn(Array(121).fill(0.9))).toEqual([[0, 120]]);
  });
});
