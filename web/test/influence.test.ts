import { expect, test } from "vitest";
import { influenceAt, influenceText, painted, parseInfluence, simplified } from "../src/influence";
import { spikeOf } from "../src/spikes";
import { EMPTY } from "./empty";

test("influence is the option's everywhere, or the curve's, held at its ends", () => {
  expect(influenceAt(EMPTY, 3)).toBe(1);
  expect(influenceAt({ ...EMPTY, options: { influence: 0.4 } }, 3)).toBe(0.4);
  const curve = { ...EMPTY, influence: parseInfluence("1s=0, 2s=1", 60) };
  expect([0, 1, 1.25, 2, 9].map((time) => influenceAt(curve, time))).toEqual([0, 0, 0.25, 1, 1]);
});

test("a stroke changes what it passes and nothing else", () => {
  const once = painted(EMPTY, { time: 1, share: 0.2 }, { time: 2, share: 0.6 }, 4, 0.1);
  for (const [time, share] of [
    [0, 1],
    [0.9, 1],
    [1, 0.2],
    [1.5, 0.4],
    [2, 0.6],
    [2.1, 1],
    [4, 1],
  ] as const)
    expect(influenceAt(once, time)).toBeCloseTo(share, 9);
  // Backward, over the end, and beyond what is possible.
  const again = painted(once, { time: 5, share: 2 }, { time: 3, share: -1 }, 4, 0.1);
  expect(influenceAt(again, 3)).toBe(0);
  expect(influenceAt(again, 1.5)).toBeCloseTo(0.4, 9);
  expect(again.influence.at(-1)).toEqual({ time: 4, share: 1 });
});

test("many small strokes, as a hand makes them, stay in order and few, whatever the hand does", () => {
  let seed = 11;
  const random = (): number => {
    seed = (seed * 16_807) % 2_147_483_647;
    return seed / 2_147_483_647;
  };
  let document = EMPTY;
  let from = { time: 2, share: 0.5 };
  for (let i = 0; i < 600; i++) {
    const to = { time: Math.min(4, Math.max(0, from.time + 0.1 * (random() - 0.5))), share: random() };
    document = painted(document, from, to, 4, 0.02);
    // Where the hand is now, the curve is as it said.
    expect(influenceAt(document, to.time)).toBeCloseTo(to.share, 1);
    from = to;
  }
  const times = document.influence.map((point) => point.time);
  expect(times.every((time, i) => i === 0 || time > (times[i - 1] as number))).toBe(true);
  expect(document.influence.every(({ share }) => share >= 0 && share <= 1)).toBe(true);
  let straight = EMPTY;
  for (let i = 0; i < 200; i++) {
    const [a, b] = [i / 50, (i + 1) / 50];
    straight = painted(straight, { time: a, share: a / 4 }, { time: b, share: b / 4 }, 4, 0.02);
  }
  expect(straight.influence.length).toBeLessThan(6);
});

test("what the line through the others meets is left out, and no more", () => {
  const points = [0, 1, 2, 3, 4].map((time) => ({ time, share: time === 3 ? 0.9 : time / 8 }));
  expect(simplified(points).map((point) => point.time)).toEqual([0, 2, 3, 4]);
});

test("influence is typed as on the command line, and what is none is refused in words", () => {
  expect(parseInfluence("0s=0, 120f=50%, 1:00=1", 60)).toEqual([
    { time: 0, share: 0 },
    { time: 2, share: 0.5 },
    { time: 60, share: 1 },
  ]);
  expect(influenceText(parseInfluence("0=0.25,2.5s=1", 30))).toBe("0s=0.25, 2.5s=1");
  expect(parseInfluence(" ", 30)).toEqual([]);
  for (const text of ["0s", "0s=2", "0s=-1", "a=1", "0s=0=1", "2s=0, 1s=1", "0s=1,"])
    expect(() => parseInfluence(text, 30)).toThrow();
});

test("a limit is suggested where a curve spikes, unless there is one", () => {
  const spiked = { outputTimes: Float64Array.of(0, 0.1, 2), inputTimes: Float64Array.of(0, 0.8, 3) };
  const found = spikeOf(EMPTY, spiked);
  expect(found?.speed).toBeCloseTo(8, 9);
  expect([found?.time, found?.limit]).toEqual([0, 2.5]);
  expect(spikeOf({ ...EMPTY, options: { speed: "..4" } }, spiked)).toBeNull();
  expect(spikeOf({ ...EMPTY, method: "spline" }, spiked)).toBeNull();
  expect(spikeOf(EMPTY, { outputTimes: Float64Array.of(0, 2), inputTimes: Float64Array.of(0, 3) })).toBeNull();
});
