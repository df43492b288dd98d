/** Scales of the timeline: what of a range is in view, zoom, pan, ticks, and snapping to frames. */

/** A window onto a range of numbers (seconds), laid over pixels. */
export interface View {
  readonly from: number;
  readonly to: number;
}

export function clamp(value: number, low: number, high: number): number {
  return Math.min(Math.max(value, low), high);
}

export function toPixels(view: View, size: number, value: number): number {
  return ((value - view.from) / (view.to - view.from)) * size;
}

export function toValue(view: View, size: number, pixels: number): number {
  return view.from + (pixels / size) * (view.to - view.from);
}

/** Push a view back inside `whole`, without changing its width where it fits. */
export function within(view: View, whole: View): View {
  const width = Math.min(view.to - view.from, whole.to - whole.from);
  const from = clamp(view.from, whole.from, whole.to - width);
  return { from, to: from + width };
}

/** Zoom by `factor` (below 1: closer) about a value that stays where it is. */
export function zoomed(view: View, whole: View, factor: number, about: number, least: number): View {
  const width = view.to - view.from;
  const wanted = clamp(width * factor, Math.min(least, whole.to - whole.from), whole.to - whole.from);
  const share = (about - view.from) / width;
  return within({ from: about - share * wanted, to: about + (1 - share) * wanted }, whole);
}

export function panned(view: View, whole: View, by: number): View {
  return within({ from: view.from + by, to: view.to + by }, whole);
}

/** Whole multiples of 1, 2 or 5 times a power of ten, at most `most` of them in view. */
export function ticks(view: View, most: number): { values: number[]; step: number } {
  const raw = (view.to - view.from) / Math.max(most, 1);
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = ([1, 2, 5, 10].find((n) => n * power >= raw * (1 - 1e-9)) ?? 10) * power;
  const first = Math.ceil(view.from / step - 1e-9);
  const last = Math.floor(view.to / step + 1e-9);
  const values: number[] = [];
  for (let i = first; i <= last; i++) values.push(i * step);
  return { values, step };
}

/** The nearest time of a frame. */
export function snapped(time: number, rate: number): number {
  return Math.round(time * rate) / rate;
}

/** Seconds with as many decimals as a step needs. */
export function timeLabel(time: number, step: number): string {
  return time.toFixed(clamp(-Math.floor(Math.log10(step) + 1e-9), 0, 3));
}
