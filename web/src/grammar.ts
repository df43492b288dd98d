/**
 * What people type, and how it is shown to them: times, lengths, rates, speeds and numbers.
 *
 * The same grammar as `src/retime/motion/grammar.py`; the tests of both run `tests/grammar/table.json`. Like there a bare
 * number is seconds. What can't be read is refused with a message that says what can.
 */

/** A text says nothing; the message is for the person who typed it. */
export class GrammarError extends Error {}

const NUMBER = "(?:\\d{1,15}(?:\\.\\d{0,30})?|\\.\\d{1,30})";
const SPACE = "[ \\t\\n\\r\\f\\v]*";
/** Without the flag u, with which a letter beyond ASCII could pass for an s. */
const all = (pattern: string): RegExp => new RegExp(`^${pattern}$`, "i");
const SECONDS = all(`([+-]?${NUMBER})${SPACE}s?`);
const FRAMES = all(`([+-]?${NUMBER})${SPACE}f`);
const CLOCK = all("(?:(\\d{1,9}):)?(\\d{1,9}):(\\d{1,2}(?:\\.\\d{0,30})?)");
const TIMECODE = all("(\\d{1,9})([:;])(\\d{1,2})\\2(\\d{1,2})([:;])(\\d{1,3})");
const PERCENT = all(`([+-]?${NUMBER})${SPACE}%`);
const SPEED = all(`(${NUMBER})(?:${SPACE}/${SPACE}(${NUMBER}))?${SPACE}[x×]?`);
const FROM_TO = all("(.+?)(?:-|–|to)(.+)");
const PLAIN = all(NUMBER);
const RATE = all(`(\\+?(?:\\d+(?:\\.\\d*)?|\\.\\d+)(?:e[+-]?\\d{1,3})?|\\d{1,30}/\\d{1,30})${SPACE}(?:hz|fps)?`);
/** A bare length below this many seconds may have been meant as a factor. */
const MOST_FACTOR = 5;

const shown = (text: string): string => `'${text.slice(0, 60)}'`;
const hertz = (rate: number): string => `${Number(rate.toPrecision(6))} Hz`;

/**
 * A time, in seconds: `3.5`, `3.5s`, `105f`, `1:03.5`, `1:01:03.5`, timecode `00:00:03:15` or, drop-frame,
 * `00:00:03;15`; `rate` is the clip's.
 */
export function parseTime(text: string, rate: number): number {
  return readTime(text, rate, "a time such as 2.5 (seconds), 120f, 1:02.500 or 00:01:02:12").seconds;
}

/** The seconds that a time says, and, where it counts in frames, those: a length must be whole. */
function readTime(text: string, rate: number, expected: string): { seconds: number; frames: number | null } {
  const written = text.trim();
  const seconds = SECONDS.exec(written);
  if (seconds) return { seconds: Number(seconds[1]), frames: null };
  const frames = FRAMES.exec(written);
  if (frames) return { seconds: Number(frames[1]) / rate, frames: Number(frames[1]) };
  const clock = CLOCK.exec(written);
  if (clock) {
    const minutes = Number(clock[2]);
    checkClock(clock[1] === undefined ? 0 : minutes, Number(clock[3]), written);
    return { seconds: Number(clock[1] ?? 0) * 3600 + minutes * 60 + Number(clock[3]), frames: null };
  }
  const timecode = TIMECODE.exec(written);
  if (timecode && !(timecode[2] === ";" && timecode[5] === ":")) {
    const [hours, minutes, whole, rest] = [1, 3, 4, 6].map((group) => Number(timecode[group])) as Parts;
    checkClock(minutes, whole, written);
    const frame = frameOfTimecode([hours, minutes, whole, rest], timecode[5] === ";", rate, written);
    return { seconds: frame / rate, frames: frame };
  }
  throw new GrammarError(`expected ${expected}, found ${shown(text)}`);
}

type Parts = [hours: number, minutes: number, seconds: number, frames: number];

function checkClock(minutes: number, seconds: number, written: string): void {
  if (minutes < 60 && seconds < 60) return;
  throw new GrammarError(`minutes and seconds after a colon stay below 60, found ${shown(written)}`);
}

/** The frame that a timecode names, counted from 0; see `retime/motion/timecode.py`. */
function frameOfTimecode([hours, minutes, seconds, frames]: Parts, drop: boolean, rate: number, text: string): number {
  const isWhole = Math.abs(rate - Math.round(rate)) < 1e-9;
  const counted = isWhole ? Math.round(rate) : Math.round(rate * 1.001);
  const found = `found ${shown(text)}`;
  if (!isWhole && Math.abs(rate * 1.001 - counted) > 1e-6) {
    throw new GrammarError(
      `a timecode needs a whole rate, or one such as 23.976 or 29.97, and the clip has ${hertz(rate)}: write seconds or frames, ${found}`,
    );
  }
  if (frames >= counted) {
    throw new GrammarError(`frames of a timecode go from 0 to ${counted - 1} at ${hertz(rate)}, ${found}`);
  }
  const allMinutes = 60 * hours + minutes;
  const number = (60 * allMinutes + seconds) * counted + frames;
  if (!drop) return number;
  if (isWhole || counted % 30 !== 0) {
    throw new GrammarError(
      `drop-frame timecode (with ;) is for 29.97 and 59.94 Hz, and the clip has ${hertz(rate)}: write : before the frames, ${found}`,
    );
  }
  const skipped = counted / 15;
  if (seconds === 0 && frames < skipped && minutes % 10 !== 0) {
    throw new GrammarError(
      `drop-frame timecode has no frames 0 to ${skipped - 1} at the start of a minute that ten does not divide, ${found}`,
    );
  }
  return number - skipped * (allMinutes - Math.floor(allMinutes / 10));
}

/** A length, in frames: `65%` of `nFrames`, or a time of a clip at `rate`. */
export function parseLength(text: string, nFrames: number, rate: number): number {
  const percent = PERCENT.exec(text.trim());
  let length: number;
  if (percent) {
    length = rounded((Number(percent[1]) * nFrames) / 100);
  } else {
    const time = readTime(text, rate, "a length such as 65%, 9.3 (seconds), 280f or 0:09.300");
    if (time.frames !== null && !Number.isInteger(time.frames)) {
      throw new GrammarError(`a length is a whole number of frames, found ${shown(text)}`);
    }
    length = time.frames ?? rounded(time.seconds * rate);
  }
  if (length >= 2) return length;
  const frames = `${length} frame${length === 1 ? "" : "s"}`;
  throw new GrammarError(`a length of ${text.trim()} is ${frames}; the output needs at least 2${factorHint(text)}`);
}

/** Round halves to even, as Python does; there 9.3 s at 25 Hz are a half exactly, here only nearly. */
function rounded(value: number): number {
  const isHalf = Math.abs(Math.abs(value % 1) - 0.5) < 1e-9 * Math.max(1, Math.abs(value));
  return isHalf ? 2 * Math.round(Math.round(2 * value) / 4) : Math.round(value);
}

function factorHint(length: string): string {
  const number = PLAIN.test(length.trim()) ? Number(length) : 0;
  return number > 0 && number < MOST_FACTOR ? ` (did you mean ${Number((number * 100).toPrecision(6))}%?)` : "";
}

/** A rate, as the document writes it: `30`, `29.97` or `30000/1001`; `Hz` or `fps` may stand after it. */
export function parseRate(text: string): string {
  const rate = RATE.exec(text.trim())?.[1];
  if (rate === undefined || Number.isNaN(rateValue(rate)) || rateValue(rate) === Number.POSITIVE_INFINITY) {
    throw new GrammarError(`expected a frame rate such as 30, 29.97 or 30000/1001, found ${shown(text)}`);
  }
  if (!(rateValue(rate) >= 1e-6 && rateValue(rate) <= 1e6)) {
    throw new GrammarError(`expected a frame rate from 1e-06 to 1000000, found ${shown(text)}`);
  }
  return rate;
}

/** The number that a rate says, as `parseRate` returns it. */
export function rateValue(rate: string): number {
  const [above, below] = rate.split("/");
  return Number(above) / Number(below ?? 1);
}

/** A playback speed: `2`, `0.5`, `1/4`, `1.5x`, `150%`. */
export function parseSpeed(text: string): number {
  const written = text.trim();
  const found = SPEED.exec(written);
  const percent = PERCENT.exec(written);
  const speed = found ? Number(found[1]) / Number(found[2] ?? 1) : percent ? Number(percent[1]) / 100 : 0;
  if (speed > 0 && Number.isFinite(speed)) return speed;
  throw new GrammarError(`expected a playback speed such as 2, 0.5, 1/4 or 150%, found ${shown(text)}`);
}

/** What a keytime says, its tangent included. */
export interface WrittenKey {
  readonly input_time: number;
  readonly output_time: number;
  readonly speed: number | null;
}

/** A keytime, `IN=OUT` or `IN=OUT@SPEED`: `5=3.5`, `300f=0:03.5@1/2`. */
export function parseKey(text: string, rate: number): WrittenKey {
  const [input = "", sign, rest = ""] = parted(text, "=");
  const [output = "", at, speed = ""] = parted(rest, "@");
  if (!sign) {
    throw new GrammarError(`expected input time = output time, such as 2.5=1.8 or 300f=0:01.800, found ${shown(text)}`);
  }
  const times = [parseTime(input, rate), parseTime(output, rate)] as const;
  if (times.some((time) => time < 0)) throw new GrammarError(`input and output begin at time 0, found ${shown(text)}`);
  return { input_time: times[0], output_time: times[1], speed: at ? parseSpeed(speed) : null };
}

/** A keytime as it can be typed, digit for digit. */
export function writtenKey({ input_time, output_time, speed }: WrittenKey): string {
  return `${plain(input_time)}=${plain(output_time)}${speed === null ? "" : `@${plain(speed)}`}`;
}

/** A number without an exponent, which the grammar does not know. */
function plain(value: number): string {
  const text = String(value);
  return text.includes("e") ? value.toFixed(20).replace(/\.?0+$/u, "") : text;
}

function parted(text: string, sign: string): [before: string, sign: string, after: string] {
  const place = text.indexOf(sign);
  return place < 0 ? [text, "", ""] : [text.slice(0, place), sign, text.slice(place + sign.length)];
}

/** A range of speeds: `1/4..8`, `0.5-2`, `..2`, one speed, or `uncut` (slowed down at most); open ends are 0 and infinity. */
export function parseSpeeds(text: string): [slowest: number, fastest: number] {
  const written = text.trim();
  if (written.toLowerCase() === "uncut") return [0, 1];
  const ends = endsOf(written);
  if (ends === null) {
    const speed = parseSpeed(text);
    return [speed, speed];
  }
  const [low, high] = ends;
  const slowest = low === "" || low === "0" ? 0 : parseSpeed(low);
  const fastest = high === "" ? Number.POSITIVE_INFINITY : parseSpeed(high);
  if (slowest <= fastest) return [slowest, fastest];
  throw new GrammarError(`a range of speeds has the slowest first, found ${shown(text)}`);
}

/** The ends of a range; either may be left out where its sign is two dots. */
function endsOf(text: string): [string, string] | null {
  const dots = text.indexOf("..");
  if (dots >= 0) return [text.slice(0, dots).trim(), text.slice(dots + 2).trim()];
  const found = FROM_TO.exec(text);
  return found ? [(found[1] ?? "").trim(), (found[2] ?? "").trim()] : null;
}

/** The speeds of a lock: a range of them whose fastest is said. */
export function parseLockSpeeds(text: string): [slowest: number, fastest: number] {
  const [slowest, fastest] = parseSpeeds(text);
  if (fastest < Number.POSITIVE_INFINITY) return [slowest, fastest];
  throw new GrammarError(`a lock needs a fastest speed, as in 1/2..2, found ${shown(text)}`);
}

/** A lock's speeds as people write them: `1`, `0.5..2`, `uncut`. */
export function speedsText(slowest: number, fastest: number): string {
  if (slowest === 0 && fastest === 1) return "uncut";
  return slowest === fastest ? String(slowest) : `${slowest}..${fastest}`;
}

export interface Bounds {
  /** The lower bound; 0 where nothing is said. */
  readonly least?: number;
  /** Whether the bound itself is refused. */
  readonly above?: boolean;
  /** Whether only whole numbers are taken. */
  readonly whole?: boolean;
  /** May stand after the number. */
  readonly unit?: string;
}

/** A plain number with a lower bound. */
export function parseNumber(text: string, { least = 0, above = false, whole = false, unit = "" }: Bounds = {}): number {
  // People's sign for "times".
  let written = text.trim().replace("×", "x");
  if (unit !== "" && written.toLowerCase().endsWith(unit.toLowerCase())) {
    written = written.slice(0, -unit.length).trimEnd();
  }
  const number = PLAIN.test(written) ? Number(written) : Number.NaN;
  if ((above ? number > least : number >= least) && (!whole || Number.isInteger(number))) return number;
  const kind = whole ? "a whole number" : "a plain number";
  throw new GrammarError(`expected ${kind} ${above ? "above" : "of at least"} ${least}, found ${shown(text)}`);
}
