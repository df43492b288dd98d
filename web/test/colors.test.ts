import { readFileSync } from "node:fs";
import { describe, expect, it } from "vitest";
import type { Clip } from "../src/messages";
import { FIGURES, figureColor } from "../src/theme";

type Triple = readonly [number, number, number];

const style = readFileSync(new URL("../src/style/colors.css", import.meta.url), "utf8");
const [light = "", dark = ""] = style.split('.retime[data-theme="dark"] {');

function color(sheet: string, name: string): Triple {
  const found = new RegExp(`--${name}: #([0-9a-f]{6});`, "u").exec(sheet)?.[1];
  if (!found) throw new Error(`no colour ${name}`);
  const part = (i: number): number => {
    const value = Number.parseInt(found.slice(2 * i, 2 * i + 2), 16) / 255;
    return value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4;
  };
  return [part(0), part(1), part(2)];
}

function times(rows: readonly Triple[], [a, b, c]: Triple): Triple {
  const one = ([x, y, z]: Triple): number => x * a + y * b + z * c;
  return [one(rows[0] as Triple), one(rows[1] as Triple), one(rows[2] as Triple)];
}

function luminance([r, g, b]: Triple): number {
  return 0.2126 * r + 0.7152 * g + 0.0722 * b;
}

function contrast(a: Triple, b: Triple): number {
  const [low, high] = [luminance(a), luminance(b)].sort((x, y) => x - y) as [number, number];
  return (high + 0.05) / (low + 0.05);
}

/** Oklab (Ottosson 2020) of linear light. */
function oklab(light: Triple): Triple {
  const cones = times(
    [
      [0.4122214708, 0.5363325363, 0.0514459929],
      [0.2119034982, 0.6806995451, 0.1073969566],
      [0.0883024619, 0.2817188376, 0.6299787005],
    ],
    light,
  );
  const [l, m, s] = cones.map((value) => Math.cbrt(Math.max(0, value))) as unknown as Triple;
  return times(
    [
      [0.2104542553, 0.793617785, -0.0040720468],
      [1.9779984951, -2.428592205, 0.4505937099],
      [0.0259040371, 0.7827717662, -0.808675766],
    ],
    [l, m, s],
  );
}

/** What people see who lack a kind of cones, in linear light (Machado, Oliveira and Fernandes 2009, severity 1). */
const EYES: Record<string, readonly Triple[]> = {
  "all cones": [
    [1, 0, 0],
    [0, 1, 0],
    [0, 0, 1],
  ],
  protanopia: [
    [0.152286, 1.052583, -0.204868],
    [0.114503, 0.786281, 0.099216],
    [-0.003882, -0.048116, 1.051998],
  ],
  deuteranopia: [
    [0.367322, 0.860646, -0.227968],
    [0.280085, 0.672501, 0.047413],
    [-0.01182, 0.04294, 0.968881],
  ],
  tritanopia: [
    [1.255528, -0.076749, -0.178779],
    [-0.078411, 0.930809, 0.147602],
    [0.004733, 0.691367, 0.3039],
  ],
};

function difference(eye: readonly Triple[], a: Triple, b: Triple): number {
  const seen = (one: Triple): Triple =>
    oklab(times(eye, one).map((value) => Math.min(1, Math.max(0, value))) as unknown as Triple);
  const [p, q] = [seen(a), seen(b)];
  return Math.hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]);
}

describe.each([
  ["light", light],
  ["dark", dark],
])("the figures of a group on a %s stage", (_, sheet) => {
  const figures = FIGURES.map((name) => color(sheet, name));

  it("stand out from it", () => {
    for (const ground of ["stage-top", "stage-bottom"]) {
      for (const figure of figures) expect(contrast(figure, color(sheet, ground))).toBeGreaterThan(3);
    }
  });

  it.each(Object.entries(EYES))("are told apart with %s", (_name, eye) => {
    figures.forEach((a, i) => {
      // A difference that one just sees is about 0.02.
      for (const b of figures.slice(i + 1)) expect(difference(eye, a, b)).toBeGreaterThan(0.12);
    });
  });
});

it("only clips with a figure take a colour, one after the other", () => {
  const clips = ["motion", "signal", "motion"].map((holds) => ({ holds }) as Clip);
  expect(clips.map((_, i) => figureColor(clips, i))).toEqual(["figure-output", null, "figure-2"]);
  const many = Array.from({ length: 6 }, () => ({ holds: "motion" }) as Clip);
  expect(figureColor(many, 5)).toBe("figure-output");
});
