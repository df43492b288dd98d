/** The stage of a clip without a skeleton: its channels as curves, a row each. */

import type { Clip } from "../messages";
import { clamp } from "../scale";
import type { Store } from "../store";
import type { Theme } from "../theme";
import { at, inputAt, type Knots, outputEnd, outputStart } from "../warp";

/** Channels shown at first; any others can be chosen. */
export const FIRST_CHANNELS = 8;
const LEAST_ROW = 34;
const LEFT = 90;

/** The channels of a clip that are shown. */
export function shownChannels(store: Store, clip: Clip): readonly number[] {
  const chosen = store.channels.get(clip.name);
  return chosen
    ? chosen.filter((channel) => channel < clip.names.length)
    : clip.names.map((_, i) => i).slice(0, FIRST_CHANNELS);
}

export class SignalView {
  private readonly canvas = document.createElement("canvas");
  /** As high as all rows; the canvas stays in view and shows those that it passes. */
  private readonly rows = document.createElement("div");
  private readonly view = document.createElement("div");

  constructor(
    root: HTMLElement,
    private readonly store: Store,
    private readonly theme: Theme,
  ) {
    this.canvas.setAttribute("role", "img");
    this.view.className = "signals";
    this.view.tabIndex = 0;
    this.view.setAttribute("role", "group");
    this.view.setAttribute("aria-label", "Channels");
    this.view.hidden = true;
    this.rows.append(this.canvas);
    this.view.append(this.rows);
    this.view.addEventListener("scroll", () => store.viewMoved());
    root.prepend(this.view);
  }

  show(clip: Clip | null): void {
    this.view.hidden = clip === null;
    if (!clip) return;
    const { knots, playback, view, companionKnots } = this.store;
    this.canvas.setAttribute("aria-label", `Stage: the channels of ${clip.name} as curves`);
    const channels = shownChannels(this.store, clip);
    const height = this.view.clientHeight;
    const rowHeight = Math.max(LEAST_ROW, height / Math.max(channels.length, 1));
    this.rows.style.height = `${Math.floor(rowHeight * channels.length)}px`;
    const width = this.view.clientWidth;
    this.canvas.style.width = `${width}px`;
    this.canvas.style.height = `${height}px`;
    const scale = devicePixelRatio;
    const [w, h] = [Math.round(width * scale), Math.round(height * scale)];
    if (this.canvas.width !== w) this.canvas.width = w;
    if (this.canvas.height !== h) this.canvas.height = h;
    const pen = this.canvas.getContext("2d");
    if (!pen || !knots) return;
    pen.setTransform(scale, 0, 0, scale, 0, 0);
    pen.clearRect(0, 0, width, height);
    pen.font = '11px system-ui, "DejaVu Sans", sans-serif';
    const side = view.layout === "side";
    const columns = side ? 2 : 1;
    // The left column ends where the stage's halves meet.
    const columnWidth = side ? width / 2 - LEFT - 12 : width - LEFT - 12;
    const leftOf = (column: number): number => (column === 0 ? LEFT : width / 2 + 12);
    const lastTime = (clip.n_frames - 1) / clip.rate;
    const identity: Knots = { outputTimes: Float64Array.of(0, lastTime), inputTimes: Float64Array.of(0, lastTime) };
    const companion = companionKnots ?? identity;
    const longest = Math.max(outputEnd(knots), outputEnd(companion));
    const { palette } = this.theme;
    const first = Math.floor(this.view.scrollTop / rowHeight);
    const last = Math.min(channels.length, Math.ceil((this.view.scrollTop + height) / rowHeight));
    for (let row = first; row < last; row++) {
      const channel = channels[row] as number;
      const [low, high] = range(clip, channel);
      const turn = fullTurn(clip.kinds[channel] ?? "");
      const y = row * rowHeight - this.view.scrollTop;
      pen.fillStyle = palette.muted;
      pen.textBaseline = "middle";
      pen.fillText(fitted(pen, clip.names[channel] ?? "", LEFT - 14), 10, y + rowHeight / 2);
      const draw = (warp: Knots, left: number, color: string, wide: number): void => {
        pen.strokeStyle = color;
        pen.lineWidth = wide;
        pen.beginPath();
        const start = outputStart(warp);
        const end = outputEnd(warp);
        const pixels = Math.max(2, Math.round(((end - start) / longest) * columnWidth));
        let drawing = false;
        let last = 0;
        for (let i = 0; i <= pixels; i++) {
          const value = valueAt(clip, channel, inputAt(warp, start + ((end - start) * i) / pixels));
          const px = left + ((start + ((end - start) * i) / pixels) / longest) * columnWidth;
          const py = y + 5 + (rowHeight - 10) * (1 - (value - low) / (high - low));
          // A hole is drawn as one: the line ends before it, and begins again.
          const there = !Number.isNaN(value);
          // So does that of an angle where it passes from one end of its range to the other: nothing turns there.
          const passes = turn > 0 && Math.abs(value - last) > turn / 2;
          if (there && drawing && !passes) pen.lineTo(px, py);
          else if (there) pen.moveTo(px, py);
          drawing = there;
          last = value;
        }
        pen.stroke();
      };
      pen.fillStyle = palette.line;
      for (let column = 0; column < columns; column++) {
        pen.fillRect(leftOf(column), Math.round(y + rowHeight) - 1, columnWidth, 1);
      }
      draw(companion, LEFT, palette[companionKnots ? "spline" : "input"], 1.2);
      draw(knots, leftOf(side ? 1 : 0), palette.output, 1.7);
    }
    const rule = (time: number, left: number): void => {
      pen.fillStyle = palette.playhead;
      pen.fillRect(Math.round(left + clamp(time / longest, 0, 1) * columnWidth), 0, 1, height);
    };
    rule(companionKnots ? playback.outputTime : playback.inputTime, LEFT);
    rule(this.store.lookedAt, leftOf(side ? 1 : 0));
  }
}

/** What a full turn is in a channel of a kind; 0 where it is no angle. */
export function fullTurn(kind: string): number {
  return kind.startsWith("angle") ? (kind === "angle:rad" ? 2 * Math.PI : 360) : 0;
}

/** What a channel shows at an input time: angles turn the short way, labels and events are those of the nearest frame. */
export function valueAt(clip: Clip, channel: number, time: number): number {
  const n = clip.names.length;
  const place = clamp(time * clip.rate, 0, clip.n_frames - 1);
  const before = Math.floor(place);
  const a = at(clip.values, before * n + channel);
  const b = at(clip.values, Math.min(before + 1, clip.n_frames - 1) * n + channel);
  const kind = clip.kinds[channel] ?? "";
  if (/^(label|event)/.test(kind)) return place - before < 0.5 ? a : b;
  const turn = fullTurn(kind);
  if (turn === 0) return a + (place - before) * (b - a);
  const step = b - a - turn * Math.round((b - a) / turn);
  const value = a + (place - before) * step;
  // In the range of the nearer one: beyond the end of it the other end goes on.
  return place - before < 0.5 ? value : value + turn * Math.round((b - value) / turn);
}

function range(clip: Clip, channel: number): [number, number] {
  let low = Infinity;
  let high = -Infinity;
  for (let i = channel; i < clip.values.length; i += clip.names.length) {
    const value = at(clip.values, i);
    // A hole is not a number, and would make one of neither.
    if (Number.isNaN(value)) continue;
    low = Math.min(low, value);
    high = Math.max(high, value);
  }
  return high > low ? [low, high] : [low - 1, low + 1];
}

function fitted(pen: CanvasRenderingContext2D, text: string, width: number): string {
  let shown = text;
  while (shown.length > 1 && pen.measureText(shown).width > width) shown = `${shown.slice(0, -2)}…`;
  return shown;
}
