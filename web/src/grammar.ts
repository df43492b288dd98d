/** What people type, and how it is shown to them: lengths, rates, speeds and times. */

/** A length as a person types it, in the document's words: `65%`, `9.3s`, `280f`; null where it says none. */
export function parseLength(text: string): string | null {
  const found = /^(\d+(?:\.\d+)?|\.\d+)\s*(%|s|f)?$/u.exec(text.trim().toLowerCase());
  if (!found || Number(found[1]) <= 0) return null;
  return `${found[1]}${found[2] ?? "s"}`;
}

/** A rate as a person types it: `30`, `29.97`, `30000/1001`, also with `Hz` or `fps`; null where it says none. */
export function parseRate(text: string): string | null {
  const found = /^(\d+(?:\.\d+)?(?:\/[1-9]\d*)?)\s*(?:hz|fps)?$/u.exec(text.trim().toLowerCase());
  return found?.[1] && Number.parseFloat(found[1]) > 0 ? found[1] : null;
}

/** The number that a rate says, as `parseRate` returns it. */
export function rateValue(rate: string): number {
  const [above, below] = rate.split("/");
  return Number(above) / Number(below ?? 1);
}

/** A speed as a person types it: `1.5`, `1/2`, `150%`; null where it says nothing. */
export function parseSpeed(text: string): number | null {
  const trimmed = text.trim().replace(/[×x]$/u, "");
  const found = /^(\d+(?:\.\d+)?|\.\d+)(?:\s*\/\s*(\d+(?:\.\d+)?))?(%)?$/u.exec(trimmed);
  if (!found) return null;
  const value = (Number(found[1]) / (found[2] ? Number(found[2]) : 1)) * (found[3] ? 0.01 : 1);
  return Number.isFinite(value) && value > 0 ? value : null;
}

/** A time as a person types it: `3.5`, `3.5s`, `105f`, `1:03.5`; null where it says none. */
export function parseTime(text: string, rate: number): number | null {
  const trimmed = text.trim().toLowerCase();
  const frames = /^(-?\d+(?:\.\d+)?)\s*f$/u.exec(trimmed);
  if (frames) return Number(frames[1]) / rate;
  const clock = /^(\d+):(\d{1,2}(?:\.\d+)?)$/u.exec(trimmed);
  if (clock) return Number(clock[1]) * 60 + Number(clock[2]);
  const seconds = /^(-?\d+(?:\.\d+)?|-?\.\d+)\s*s?$/u.exec(trimmed);
  return seconds ? Number(seconds[1]) : null;
}

/** A lock's speeds as people write them: `1`, `0.5-2`, `uncut`. */
export function parseSpeeds(text: string): [number, number] | null {
  if (text.trim().toLowerCase() === "uncut") return [0, 1];
  const parts = text.split(/\s*(?:-|–|to)\s*/u);
  const speeds = parts.map((part) => (part.trim() === "0" ? 0 : parseSpeed(part)));
  const [low, high = low] = speeds;
  if (parts.length > 2 || low === null || low === undefined || high === null || high === undefined) return null;
  return low <= high && high > 0 ? [low, high] : null;
}

export function speedsText(slowest: number, fastest: number): string {
  if (slowest === 0 && fastest === 1) return "uncut";
  return slowest === fastest ? String(slowest) : `${slowest}-${fastest}`;
}
