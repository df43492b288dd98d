/** What is drawn on the timeline's canvas: everything that is not a handle. */

import { clamp, ticks, timeLabel, toPixels } from "../scale";
import type { Store } from "../store";
import type { Palette } from "../theme";
import { at, inputAt, type Knots, outputAt, outputEnd, outputStart, pieceAt, slopes } from "../warp";
import { matchesAt, rowAt } from "../why";
import { type Box, inputY, type Layout, outputX, type Scales, speedY } from "./layout";
import { ThinLine } from "./line";
import { referenceNames, referenceSpan } from "./reference_span";

export const FONT = '11px system-ui, "Segoe UI", "Noto Sans", "DejaVu Sans", sans-serif';
const SPEED_TICKS = [1 / 8, 1 / 4, 1 / 2, 1, 2, 4, 8];
/** Pixels. */
const NARROW = 2;
const SPEED_NAMES = new Map([
  [1 / 8, "⅛×"],
  [1 / 4, "¼×"],
  [1 / 2, "½×"],
]);

export class Painter {
  constructor(
    private readonly pen: CanvasRenderingContext2D,
    private readonly layout: Layout,
    private readonly scales: Scales,
    private readonly store: Store,
    private readonly palette: Palette,
  ) {}

  /** What stays while a curve changes: axes, scores, the reference. */
  backdrop(): void {
    const { pen, layout, palette } = this;
    pen.font = FONT;
    pen.textBaseline = "middle";
    pen.fillStyle = palette.surface;
    pen.fillRect(0, 0, layout.width, layout.height);
    pen.fillStyle = palette.panel;
    pen.fillRect(0, 0, layout.width, layout.ruler.height);
    pen.fillRect(0, 0, layout.map.x, layout.height);
    this.ruler();
    this.gutter();
    this.speedAxis();
    if (this.store.knots) this.heat();
    this.reference();
    this.frames();
  }

  /** All the rest, over it. */
  foreground(): void {
    const knots = this.store.knots;
    if (knots) {
      this.flights(knots);
      this.locks(knots);
      this.mapCurves(knots);
      this.speedCurve();
    }
    this.matches();
    this.markers();
  }

  private label(text: string, x: number, y: number, align: CanvasTextAlign, color = this.palette.muted): void {
    this.pen.textAlign = align;
    this.pen.fillStyle = color;
    this.pen.fillText(text, x, y);
  }

  private ruler(): void {
    const { pen, layout, scales, palette } = this;
    const { values, step } = ticks(scales.output, Math.floor(layout.map.width / 78));
    for (const value of values) {
      if (value < -1e-9) continue;
      const x = Math.round(outputX(layout, scales, value));
      pen.fillStyle = palette.line;
      pen.fillRect(x, layout.map.y, 1, layout.map.height);
      pen.fillRect(x, layout.speed.y, 1, layout.speed.height);
      pen.fillStyle = palette["line-strong"];
      pen.fillRect(x, layout.ruler.height - 5, 1, 5);
      this.label(`${timeLabel(value, step)} s`, x + 4, layout.ruler.height / 2, "left");
    }
    this.label("Output", 8, layout.ruler.height / 2, "left", palette.output);
  }

  private gutter(): void {
    const { pen, layout, scales, palette } = this;
    const { values, step } = ticks(scales.input, Math.max(2, Math.floor(layout.map.height / 34)));
    for (const value of values) {
      if (value < -1e-9 || value > this.store.inputEnd + 1e-9) continue;
      const y = Math.round(inputY(layout, scales, value));
      if (y < layout.map.y || y > layout.map.y + layout.map.height) continue;
      pen.fillStyle = palette.line;
      pen.fillRect(layout.map.x, y, layout.map.width, 1);
      if (y > layout.map.y + 16) this.label(`${timeLabel(value, step)} s`, layout.map.x - 18, y, "right");
    }
    this.label("Input", 8, layout.map.y + 9, "left", palette.input);
  }

  private speedAxis(): void {
    const { pen, layout, scales, palette } = this;
    for (const value of SPEED_TICKS) {
      const level = Math.log2(value);
      if (level < scales.speed.from || level > scales.speed.to) continue;
      const y = Math.round(speedY(layout, scales, value));
      pen.fillStyle = value === 1 ? palette["line-strong"] : palette.line;
      pen.fillRect(layout.speed.x, y, layout.speed.width, 1);
      const crowded = layout.speed.height / (scales.speed.to - scales.speed.from) < 13 && Math.abs(level) % 2 === 1;
      if (!crowded) this.label(SPEED_NAMES.get(value) ?? `${value}×`, layout.map.x - 8, y, "right");
    }
    this.label("Speed", 8, layout.speed.y + 9, "left", palette.muted);
    this.label("Score", 8, layout.heat.y + layout.heat.height / 2, "left", palette.muted);
    // Of several one is shown; which, is chosen there.
    if ((this.store.document?.references.length ?? 0) > 1) return;
    this.label("Reference", 8, layout.reference.y + layout.reference.height / 2, "left", palette.reference);
  }

  private clip(box: Box, draw: () => void): void {
    const { pen } = this;
    pen.save();
    pen.beginPath();
    pen.rect(box.x, box.y, box.width, box.height);
    pen.clip();
    draw();
    pen.restore();
  }

  /** Where the figure is in the air: what timing must not touch. */
  private flights(knots: Knots): void {
    const flights = this.store.clip?.flights;
    if (!flights) return;
    const { pen, layout, scales, palette } = this;
    for (const box of [layout.map, layout.speed]) {
      this.clip(box, () => {
        pen.fillStyle = palette.flight;
        for (let i = 0; i + 1 < flights.length; i += 2) {
          const from = outputX(layout, scales, outputAt(knots, at(flights, i)));
          const to = outputX(layout, scales, outputAt(knots, at(flights, i + 1)));
          pen.fillRect(Math.min(from, to), box.y, Math.abs(to - from), box.height);
        }
      });
    }
  }

  private locks(knots: Knots): void {
    const { pen, layout, scales, palette, store } = this;
    for (const lock of store.document?.locks ?? []) {
      const chosen = store.selection?.kind === "lock" && store.selection.id === lock.id;
      const from = outputX(layout, scales, outputAt(knots, lock.start));
      const to = outputX(layout, scales, outputAt(knots, lock.end));
      const top = inputY(layout, scales, lock.end);
      const bottom = inputY(layout, scales, lock.start);
      this.clip(layout.map, () => {
        pen.fillStyle = palette["lock-soft"];
        pen.fillRect(layout.map.x, top, layout.map.width, bottom - top);
        pen.fillRect(from, layout.map.y, to - from, layout.map.height);
        pen.strokeStyle = palette.lock;
        pen.lineWidth = chosen ? 1.5 : 1;
        pen.globalAlpha = chosen ? 1 : 0.6;
        pen.strokeRect(from, top, to - from, bottom - top);
        pen.globalAlpha = 1;
      });
      this.clip(layout.speed, () => {
        pen.fillStyle = palette["lock-soft"];
        pen.fillRect(from, layout.speed.y, to - from, layout.speed.height);
        pen.fillStyle = palette.lock;
        const high = speedY(layout, scales, lock.fastest);
        const low = speedY(layout, scales, lock.slowest);
        if (Math.abs(low - high) < 3) pen.fillRect(from, (low + high) / 2 - 1.5, to - from, 3);
        else {
          pen.fillRect(from, high - 1, to - from, 2);
          pen.fillRect(from, low - 1, to - from, 2);
        }
      });
    }
  }

  private line(knots: Knots, color: string, width: number, dashes: readonly number[]): void {
    const { pen, layout, scales } = this;
    pen.strokeStyle = color;
    pen.lineWidth = width;
    pen.lineJoin = "round";
    pen.setLineDash([...dashes]);
    pen.beginPath();
    const from = Math.max(scales.output.from, outputStart(knots));
    const to = Math.min(scales.output.to, outputEnd(knots));
    const first = pieceAt(knots.outputTimes, from);
    const last = pieceAt(knots.outputTimes, to) + 1;
    const line = new ThinLine(pen);
    const put = (time: number, value: number): void =>
      line.to(outputX(layout, scales, time), inputY(layout, scales, value));
    if (last - first <= 2 * layout.map.width) {
      for (let i = first; i <= last; i++) put(at(knots.outputTimes, i), at(knots.inputTimes, i));
    } else {
      const n = Math.ceil(layout.map.width);
      for (let i = 0; i <= n; i++) put(from + ((to - from) * i) / n, inputAt(knots, from + ((to - from) * i) / n));
    }
    line.end();
    pen.stroke();
    pen.setLineDash([]);
  }

  private mapCurves(knots: Knots): void {
    const { layout, palette, store } = this;
    const curve = store.curve;
    if (!curve) return;
    this.clip(layout.map, () => {
      const linear = { outputTimes: curve.linear_output_times, inputTimes: curve.linear_input_times };
      const spline = { outputTimes: curve.spline_output_times, inputTimes: curve.spline_input_times };
      this.line(linear, palette.muted, 1.1, [5, 3]);
      this.line(spline, palette.spline, 1.1, [7, 3, 1.5, 3]);
      const kept = typeof store.view.companion === "object" ? store.companionKnots : null;
      if (kept) this.line(kept, palette.spline, 2, []);
      this.line(knots, palette.output, 2.2, []);
    });
  }

  private speedCurve(): void {
    const { pen, layout, scales, palette, store } = this;
    const curve = store.curve;
    if (!curve) return;
    const draw = (warp: Knots): void => {
      const times = warp.outputTimes;
      const speeds = slopes(warp);
      pen.beginPath();
      const from = Math.max(0, pieceAt(times, scales.output.from));
      const to = Math.min(speeds.length, pieceAt(times, scales.output.to) + 2);
      const every = Math.max(1, Math.floor((to - from) / (2 * layout.map.width)));
      const line = new ThinLine(pen);
      for (let i = from; i < to; i += every) {
        const y = speedY(layout, scales, at(speeds, i));
        const left = outputX(layout, scales, at(times, i));
        const right = outputX(layout, scales, at(times, Math.min(i + every, speeds.length)));
        if (right - left > NARROW || i === from) line.to(left, y);
        // Steps too narrow to be seen are drawn from middle to middle.
        line.to(right - left > NARROW || i + every >= to ? right : (left + right) / 2, y);
      }
      line.end();
      pen.stroke();
    };
    this.clip(layout.speed, () => {
      pen.lineJoin = "round";
      pen.lineWidth = 1;
      pen.setLineDash([5, 3]);
      pen.strokeStyle = palette.muted;
      draw({ outputTimes: curve.linear_output_times, inputTimes: curve.linear_input_times });
      pen.setLineDash([7, 3, 1.5, 3]);
      pen.strokeStyle = palette.spline;
      draw({ outputTimes: curve.spline_output_times, inputTimes: curve.spline_input_times });
      pen.setLineDash([]);
      const kept = typeof store.view.companion === "object" ? store.companionKnots : null;
      if (kept) {
        pen.lineWidth = 1.6;
        draw(kept);
      }
      pen.lineWidth = 1.9;
      pen.strokeStyle = palette.output;
      draw({ outputTimes: curve.output_times, inputTimes: curve.input_times });
    });
  }

  private heat(): void {
    const { pen, layout, scales, palette, store } = this;
    const { why, curve } = store;
    const { heat } = layout;
    pen.fillStyle = palette["heat-low"];
    const start = clamp(outputX(layout, scales, 0), heat.x, heat.x + heat.width);
    const end = clamp(
      outputX(layout, scales, curve ? outputEnd(store.knots as Knots) : 0),
      heat.x,
      heat.x + heat.width,
    );
    pen.fillRect(start, heat.y, end - start, heat.height);
    if (!why || why.n_output < 3) {
      this.label("no search, no scores", heat.x + 8, heat.y + heat.height / 2, "left");
      return;
    }
    const { low, high } = rangeOf(why.scores);
    const colors = heatColors(palette["heat-low"], palette["heat-high"]);
    // Rows are as wide as they come out; neighbours of one colour are one rectangle.
    let runStart = start;
    let runColor = "";
    for (let x = Math.floor(start); x <= Math.ceil(end); x++) {
      const time =
        scales.output.from + ((x + 0.5 - layout.map.x) / layout.map.width) * (scales.output.to - scales.output.from);
      const score = at(why.scores, rowAt(why, time));
      const color = Number.isFinite(score)
        ? (colors[Math.round(clamp((score - low) / (high - low), 0, 1) * (colors.length - 1))] ?? "")
        : palette["heat-low"];
      if (color !== runColor) {
        if (runColor) {
          pen.fillStyle = runColor;
          pen.fillRect(runStart, heat.y, x - runStart, heat.height);
        }
        runStart = x;
        runColor = color;
      }
    }
    if (runColor) {
      pen.fillStyle = runColor;
      pen.fillRect(runStart, heat.y, end - runStart, heat.height);
    }
  }

  /** The reference's own time: what of it is imitated, and which frames of it were matched. */
  private reference(): void {
    const { pen, layout, palette, store } = this;
    const whole = referenceSpan(store);
    if (!whole) return;
    const box = referenceBox(layout);
    const x = (time: number): number => box.x + toPixels({ from: 0, to: whole.lastTime }, box.width, time);
    pen.fillStyle = palette.line;
    pen.fillRect(box.x, box.y, box.width, box.height);
    pen.fillStyle = palette.reference;
    pen.globalAlpha = 0.16;
    pen.fillRect(x(whole.start), box.y, x(whole.end) - x(whole.start), box.height);
    pen.globalAlpha = 1;
    if (whole.source >= 0) {
      const name = referenceNames(store)[whole.source] ?? "";
      this.clip(box, () => this.label(name, x(whole.start) + 8, box.y + 8, "left", palette.reference));
    }
    const { why } = store;
    if (!why) return;
    pen.globalAlpha = 0.5;
    for (let row = 1; row + 1 < why.n_output; row++) {
      const [match] = matchesAt(why, row);
      if (match?.source === whole.source) pen.fillRect(x(match.time + whole.offset), box.y + box.height - 5, 1, 5);
    }
    pen.globalAlpha = 1;
  }

  /** The reference frames that the frame looked at was matched with. */
  private matches(): void {
    const { pen, layout, palette, store } = this;
    const whole = referenceSpan(store);
    const { why } = store;
    if (!whole || !why) return;
    const box = referenceBox(layout);
    const time = store.hover ?? store.playback.outputTime;
    pen.fillStyle = palette.reference;
    for (const match of matchesAt(why, rowAt(why, time))) {
      if (match.source !== whole.source) continue;
      const x = box.x + toPixels({ from: 0, to: whole.lastTime }, box.width, match.time + whole.offset);
      pen.fillRect(Math.round(x) - 1, box.y, 2, box.height);
    }
  }

  private frames(): void {
    const { pen, layout, palette } = this;
    pen.strokeStyle = palette.line;
    pen.lineWidth = 1;
    for (const box of [layout.map, layout.speed])
      pen.strokeRect(box.x + 0.5, box.y + 0.5, box.width - 1, box.height - 1);
    pen.fillStyle = palette["line-strong"];
    pen.fillRect(0, layout.ruler.height - 1, layout.width, 1);
  }

  private markers(): void {
    const { pen, layout, scales, palette, store } = this;
    const end = store.knots ? outputEnd(store.knots) : null;
    if (end !== null) {
      const x = outputX(layout, scales, end);
      if (x < layout.map.x + layout.map.width) {
        // What lies after the output's end is not part of it.
        pen.fillStyle = palette.panel;
        pen.globalAlpha = 0.65;
        pen.fillRect(x, layout.map.y + 1, layout.map.x + layout.map.width - x - 1, layout.map.height - 2);
        pen.fillRect(x, layout.speed.y + 1, layout.map.x + layout.map.width - x - 1, layout.speed.height - 2);
        pen.globalAlpha = 1;
      }
    }
    const bottom = layout.heat.y + layout.heat.height;
    this.clip({ x: layout.map.x - 6, y: 0, width: layout.map.width + 12, height: layout.height }, () => {
      if (store.hover !== null) {
        const x = Math.round(outputX(layout, scales, store.hover));
        pen.fillStyle = palette.muted;
        pen.globalAlpha = 0.6;
        pen.fillRect(x, layout.map.y, 1, bottom - layout.map.y);
        pen.globalAlpha = 1;
      }
      const x = Math.round(outputX(layout, scales, store.playback.outputTime));
      pen.fillStyle = palette.playhead;
      pen.fillRect(x, layout.ruler.height - 7, 1, bottom - layout.ruler.height + 7);
      pen.beginPath();
      pen.moveTo(x - 5.5, layout.ruler.height - 12);
      pen.lineTo(x + 6.5, layout.ruler.height - 12);
      pen.lineTo(x + 6.5, layout.ruler.height - 6);
      pen.lineTo(x + 0.5, layout.ruler.height);
      pen.lineTo(x - 5.5, layout.ruler.height - 6);
      pen.closePath();
      pen.fill();
    });
  }
}

function referenceBox({ reference }: Layout): Box {
  return { ...reference, y: reference.y + 4, height: reference.height - 8 };
}

const ranges = new WeakMap<Float64Array, { low: number; high: number }>();

/** The same, found once for each explanation. */
function rangeOf(scores: Float64Array): { low: number; high: number } {
  const known = ranges.get(scores);
  if (known) return known;
  const found = scoreRange(scores);
  ranges.set(scores, found);
  return found;
}

/** From the 5th to the 95th of a hundred scores: one outlier does not make the rest pale. */
export function scoreRange(scores: Float64Array): { low: number; high: number } {
  const ordered = scores.filter((score) => Number.isFinite(score)).sort();
  const pick = (share: number): number => ordered[Math.round(share * (ordered.length - 1))] ?? 0;
  const low = pick(0.05);
  const high = pick(0.95);
  return { low, high: high > low ? high : low + 1 };
}

const mixed = new Map<string, string[]>();

/** Colours from one to another, mixed once. Both are written as #rrggbb. */
export function heatColors(low: string, high: string): string[] {
  const name = `${low} ${high}`;
  let colors = mixed.get(name);
  if (!colors) {
    const part = (color: string, i: number): number => Number.parseInt(color.slice(1 + 2 * i, 3 + 2 * i), 16);
    colors = Array.from({ length: 32 }, (_, n) => {
      const channels = [0, 1, 2].map((i) => Math.round(part(low, i) + (n / 31) * (part(high, i) - part(low, i))));
      return `rgb(${channels.join(" ")})`;
    });
    mixed.set(name, colors);
  }
  return colors;
}
