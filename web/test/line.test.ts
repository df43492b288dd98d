import { describe, expect, it } from "vitest";
import { ThinLine } from "../src/timeline/paint/line";

type Point = readonly [number, number];

function drawn(points: readonly Point[]): Point[] {
  const found: Point[] = [];
  const line = new ThinLine({ lineTo: (x, y) => found.push([x, y]) });
  for (const [x, y] of points) line.to(x, y);
  line.end();
  return found;
}

/** How far the drawn line passes a point, straight up or down. */
function miss(line: readonly Point[], [x, y]: Point): number {
  let best = Infinity;
  for (let i = 0; i + 1 < line.length; i++) {
    const [a, b] = [line[i], line[i + 1]] as [Point, Point];
    if (x < a[0] - 1e-9 || x > b[0] + 1e-9) continue;
    if (b[0] - a[0] < 1e-9) best = Math.min(best, Math.max(Math.min(a[1], b[1]) - y, y - Math.max(a[1], b[1]), 0));
    else best = Math.min(best, Math.abs(a[1] + ((x - a[0]) / (b[0] - a[0])) * (b[1] - a[1]) - y));
  }
  return best;
}

describe("lines of many points", () => {
  it("keep their shape to a fraction of a pixel", () => {
    const wave = Array.from({ length: 2000 }, (_, i): Point => [0.4 * i, 100 * Math.sin(i / 50) + 7 * Math.sin(i / 9)]);
    const line = drawn(wave);
    expect(line.length).toBeLessThan(wave.length / 4);
    for (const point of wave) expect(miss(line, point)).toBeLessThan(0.16);
    expect(line[0]).toEqual(wave[0]);
    expect(line.at(-1)).toEqual(wave.at(-1));
  });

  it("are drawn by their ends where they are straight", () => {
    expect(drawn(Array.from({ length: 500 }, (_, i): Point => [i, 3 * i + 1]))).toEqual([
      [0, 1],
      [499, 1498],
    ]);
  });

  it("keep steps upright, and every corner", () => {
    const stairs: Point[] = [
      [0, 0],
      [5, 0],
      [5, 8],
      [9, 8],
      [9, 3],
      [9, 3.05],
      [14, 3],
    ];
    const line = drawn(stairs);
    for (const point of stairs) expect(miss(line, point)).toBeLessThan(0.16);
    for (const corner of [
      [5, 0],
      [5, 8],
      [9, 8],
      [9, 3],
    ])
      expect(line).toContainEqual(corner);
  });

  it("of one point or none draw what there is", () => {
    expect(drawn([])).toEqual([]);
    expect(drawn([[2, 3]])).toEqual([[2, 3]]);
  });
});
