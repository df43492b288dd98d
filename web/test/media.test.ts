import { expect, test } from "vitest";
import { beatsInOutput, mediaTimeAt } from "../src/media/beside";
import { setBeats, setMedia } from "../src/media/edits";
import { isAnimation, isMedia } from "../src/media/endings";
import { heardIn } from "../src/media/film_sound";
import { followed, ROUNDING, stand, within } from "../src/media/follow";
import { peakBetween, peaksOf } from "../src/media/peaks";
import { STILL } from "../src/playback";
import { EMPTY } from "./empty";

const KNOTS = { outputTimes: Float64Array.of(0, 1, 3), inputTimes: Float64Array.of(0, 3, 4) };
const MEDIA = { path: "take.webm", offset: "-12f", clock: "input" } as const;

test("media go with the input through the warp, or with the output", () => {
  expect(mediaTimeAt(MEDIA, KNOTS, 60, 0.5)).toBeCloseTo(1.5 + 0.2, 12);
  expect(mediaTimeAt({ ...MEDIA, clock: "output" }, KNOTS, 60, 0.5)).toBeCloseTo(0.7, 12);
  expect(mediaTimeAt({ ...MEDIA, offset: null }, KNOTS, 60, 2)).toBe(3.5);
  // A file by another program may say what is no time: the field says so, and the media begin with the clip.
  expect(mediaTimeAt({ ...MEDIA, offset: "soon" }, KNOTS, 60, 2)).toBe(3.5);
});

test("beats of the take fall where the warp shows them, those of a file where it says", () => {
  const beats = { times: [1.7, 3.7], strengths: [1, 1], names: ["", ""] };
  const document = setMedia(EMPTY, MEDIA);
  const taken = beatsInOutput(setBeats(document, { path: null, on: "beats" }), beats, KNOTS, 60);
  expect(taken[0]).toBeCloseTo(0.5, 12);
  expect(taken[1]).toBeCloseTo(2, 12);
  expect(beatsInOutput(setBeats(document, { path: "beats.csv", on: "beats" }), beats, KNOTS, 60)).toEqual([1.7, 3.7]);
});

test("what is taken away takes its own beats along, and leaves those of a file", () => {
  const document = setMedia(EMPTY, { path: "take.webm" });
  expect(document.media).toEqual({ path: "take.webm", offset: null, clock: "input" });
  const own = setMedia(setBeats(document, { path: null, on: "onsets" }), null);
  expect([own.media, own.beats]).toEqual([null, null]);
  const table = { path: "beats.csv", on: "beats" } as const;
  expect(setMedia(setBeats(document, table), null).beats).toEqual(table);
});

test("a player hurries or waits by little, jumps over much, and scrubs what it can't play", () => {
  expect(followed(1, 1, 1.5, 10)).toEqual({ speed: 1.5, seek: null });
  const late = followed(0.9, 1, 1.5, 10);
  expect(late.seek).toBeNull();
  // In half a second it is right again.
  expect(0.9 + 0.5 * (late.speed ?? 0)).toBeCloseTo(1 + 0.5 * 1.5, 12);
  expect(followed(0, 1, 1.5, 10)).toEqual({ speed: 1.5, seek: 1 });
  for (const speed of [0, -1, 20]) expect(followed(0, 1, speed, 10)).toEqual({ speed: null, seek: 1 + ROUNDING });
  // At the very end there is no picture: the last one is shown a little before.
  expect(followed(0, 12, 1, 10).speed).toBeNull();
  expect(followed(0, 12, 1, 10).seek).toBeCloseTo(9.997, 9);
  expect([-2, 0, 4, 10].map((time) => within(time, 10))).toEqual([0, 0, 4, 9.996]);
  expect(stand(1 + ROUNDING, 1)).toEqual({ speed: null, seek: null });
});

test("peaks are the greatest amplitude, at every scale", () => {
  const rate = 1000;
  let seed = 7;
  const noise = Float32Array.from({ length: 4321 }, () => {
    seed = (seed * 16_807) % 2_147_483_647;
    return seed / 1_073_741_824 - 1;
  });
  const quiet = new Float32Array(noise.length);
  const peaks = peaksOf([quiet, noise], rate);
  for (const [from, to] of [
    [0, 4.321],
    [0.105, 0.11],
    [1, 1.6],
    [2.5, 1.25],
  ] as const) {
    const [low, high] = [Math.min(from, to), Math.max(from, to)];
    const inside = noise.slice(Math.ceil(low * rate), Math.floor(high * rate) + 1).map(Math.abs);
    // Parts are whole: a little more than the stretch may be counted, nothing of it may be missed.
    const wide = (high - low) / 1 + 0.01;
    const around = noise
      .slice(Math.max(0, Math.floor((low - wide) * rate)), Math.ceil((high + wide) * rate) + 1)
      .map(Math.abs);
    const found = peakBetween(peaks, from, to);
    expect(found).toBeGreaterThanOrEqual(Math.max(...inside) - 1e-9);
    expect(found).toBeLessThanOrEqual(Math.max(...around) + 1e-9);
  }
  expect(peakBetween(peaks, -3, -1)).toBe(0);
  expect(peakBetween(peaks, 9, 11)).toBe(0);
});

test("media are told by their ending", () => {
  expect(["Take.MP4", "a/b.wav", "walk.bvh", "wav"].map(isMedia)).toEqual([true, true, false, false]);
});

test("a film's sound is what is heard while it plays once, whichever clock leads", () => {
  const keys = [1, 0, 3];
  // The output leads: through the warp, half a second of nothing aside, exact at the keytime.
  const media = { ...MEDIA, offset: "0.5" };
  expect(heardIn(STILL, KNOTS, 4, media, 60, keys)).toEqual({ times: [0, 1, 3], values: [-0.5, 2.5, 3.5], keys: [1] });
  // An output that begins later: the film begins with it.
  const later = { outputTimes: Float64Array.of(2, 3, 5), inputTimes: KNOTS.inputTimes };
  expect(heardIn(STILL, later, 4, media, 60, [3])).toEqual({ times: [0, 1, 3], values: [-0.5, 2.5, 3.5], keys: [1] });
  // A song keeps the output's time.
  const song = { ...media, clock: "output" } as const;
  expect(heardIn(STILL, KNOTS, 4, song, 60, keys).values).toEqual([-0.5, 0.5, 2.5]);
  // The input leads, and the output shows the same pose: the take as it was filmed, the song through the warp.
  const linked = { ...STILL, clock: "input", linked: true } as const;
  expect(heardIn(linked, KNOTS, 4, media, 60, keys)).toEqual({ times: [0, 3, 4], values: [-0.5, 2.5, 3.5], keys: [] });
  expect(heardIn(linked, KNOTS, 4, song, 60, keys).values).toEqual([-0.5, 0.5, 2.5]);
  // Not linked, the output plays by itself, and rests at its end until the input has come to its own.
  const apart = { ...STILL, clock: "input" } as const;
  expect(heardIn(apart, KNOTS, 4, media, 60, keys)).toEqual({
    times: [0, 1, 3, 4],
    values: [-0.5, 2.5, 3.5, 3.5],
    keys: [],
  });
  // Where it stands, loops and how fast it plays change nothing of it.
  const playing = { ...STILL, outputTime: 2, inputTime: 1, rate: -2 };
  expect(heardIn(playing, KNOTS, 4, media, 60, keys)).toEqual(heardIn(STILL, KNOTS, 4, media, 60, keys));
});

test("animations are told by their endings", () => {
  expect(["a.gif", "b.WebP", "c.apng"].map(isAnimation)).toEqual([true, true, true]);
  expect(["a.webm", "gif", "c.mp4"].map(isAnimation)).toEqual([false, false, false]);
});
