/** The stage of a clip without a skeleton: its channels as curves, a row each. */

import type { Clip } from "../messages";
import { clamp } from "../scale";
import type { Store } from "../store";
import type { Theme } from "../theme";
import { at, inputAt, outputEnd, outputStart, type Knots } from "../warp";

const MOST_ROWS = 8;
const TOP = 44;
const BOTTOM = 30;
const LEFT = 90;

export class SignalView {
  private readonly canvas = document.createElement("canvas");

  constructor(
    private readonly root: HTMLElement,
    private readonly store: Store,
    private readonly theme: Theme,
  ) {
    this.canvas.setAttribute("role", "img");
    this.canvas.hidden = true;
    root.prepend(this.canvas);
  }

  show(clip: Clip | null): void {
    this.canvas.hidden = clip === null;
    if (!clip) return;
    const { knots, playback, view, companionKnots } = this.store;
    this.canvas.setAttribute("aria-label", `Stage: the channels of ${clip.name} as curves`);
    const width = this.root.clientWidth;
    const height = this.root.clientHeight;
    const scale = devicePixelRatio;
    this.canvas.width = Math.round(width * scale);
    this.canvas.height = Math.round(height * scale);
    const pen = this.canvas.getContext("2d");
    if (!pen || !knots) return;
    pen.setTransform(scale, 0, 0, scale, 0, 0);
    pen.clearRect(0, 0, width, height);
    pen.font = '11px system-ui, "DejaVu Sans", sans-serif';
    const rows = Math.min(clip.names.length, MOST_ROWS);
    const rowHeight = (height - TOP - BOTTOM) / Math.max(rows, 1);
    const side = view.layout === "side";
    const columns = side ? 2 : 1;
    // The left column ends where the stage's halves meet.
    const columnWidth = side ? width / 2 - LEFT - 12 : width - LEFT - 12;
    const leftOf = (column: number): number => (column === 0 ? LEFT : width / 2 + 12);
    const duration = (clip.n_frames - 1) / clip.rate;
    const identity: Knots = { outputTimes: Float64Array.of(0, duration), inputTimes: Float64Array.of(0, duration) };
    const companion = companionKnots ?? identity;
    const longest = Math.max(outputEnd(knots), outputEnd(companion));
    const { palette } = this.theme;
    for (let row = 0; row < rows; row++) {
      const [low, high] = range(clip, row);
      const y = TOP + row * rowHeight;
      pen.fillStyle = palette.muted;
      pen.textBaseline = "middle";
      pen.fillText(fitted(pen, clip.names[row] ?? "", LEFT - 14), 10, y + rowHeight / 2);
      const draw = (warp: Knots, left: number, color: string, wide: number): void => {
        pen.strokeStyle = color;
        pen.lineWidth = wide;
        pen.beginPath();
        const start = outputStart(warp);
        const end = outputEnd(warp);
        const pixels = Math.max(2, Math.round(((end - start) / longest) * columnWidth));
        for (let i = 0; i <= pixels; i++) {
          const value = valueAt(clip, row, inputAt(warp, start + ((end - start) * i) / pixels));
          const px = left + ((start + ((end - start) * i) / pixels) / longest) * columnWidth;
          const py = y + 5 + (rowHeight - 10) * (1 - (value - low) / (high - low));
          if (i === 0) pen.moveTo(px, py);
          else pen.lineTo(px, py);
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
      pen.fillRect(Math.round(left + clamp(time / longest, 0, 1) * columnWidth), TOP, 1, height - TOP - BOTTOM);
    };
    rule(companionKnots ? playback.outputTime : playback.inputTime, LEFT);
    rule(this.store.lookedAt, leftOf(side ? 1 : 0));
    if (clip.names.length > rows) {
      pen.fillStyle = palette.muted;
      pen.fillText(`${rows} of ${clip.names.length} channels`, LEFT, TOP - 8);
    }
  }
}

function valueAt(clip: Clip, channel: number, time: number): number {
  const n = clip.names.length;
  const place = clamp(time * clip.rate, 0, clip.n_frames - 1);
  const before = Math.floor(place);
  const a = at(clip.values, before * n + channel);
  const b = at(clip.values, Math.min(before + 1, clip.n_frames - 1) * n + channel);
  return a + (place - before) * (b - a);
}

function range(clip: Clip, channel: number): [number, number] {
  let low = Infinity;
  let high = -Infinity;
  for (let i = channel; i < clip.values.length; i += clip.names.length) {
    low = Math.min(low, at(clip.values, i));
    high = Math.max(high, at(clip.values, i));
  }
  return high > low ? [low, high] : [low - 1, low + 1];
}

function fitted(pen: CanvasRenderingContext2D, text: string, width: number): string {
  let shown = text;
  while (shown.length > 1 && pen.measureText(shown).width > width) shown = `${shown.slice(0, -2)}…`;
  return shown;
}
