/** The curves: which pose is shown when, and how fast that plays. */

import { splineOf } from "../../spline";
import { at, inputAt, type Knots, outputEnd, outputStart, pieceAt, slopes } from "../../warp";
import { inputY, outputX, speedY } from "../layout";
import { type Canvas, clipped } from "./canvas";
import { ThinLine } from "./line";

/** Pixels. */
const NARROW = 2;

export function mapCurves(canvas: Canvas, knots: Knots): void {
  const { layout, palette, store } = canvas;
  const curve = store.curve;
  if (!curve) return;
  clipped(canvas, layout.map, () => {
    const linear = { outputTimes: curve.linear_output_times, inputTimes: curve.linear_input_times };
    mapCurve(canvas, linear, palette.muted, 1.1, [5, 3]);
    mapCurve(canvas, splineOf(curve), palette.spline, 1.1, [7, 3, 1.5, 3]);
    const kept = typeof store.view.companion === "object" ? store.companionKnots : null;
    if (kept) mapCurve(canvas, kept, palette.spline, 2, []);
    mapCurve(canvas, knots, palette.output, 2.2, []);
  });
}

export function speedCurves(canvas: Canvas): void {
  const { pen, layout, palette, store } = canvas;
  const curve = store.curve;
  if (!curve) return;
  clipped(canvas, layout.speed, () => {
    pen.lineJoin = "round";
    pen.lineWidth = 1;
    pen.setLineDash([5, 3]);
    pen.strokeStyle = palette.muted;
    speedCurve(canvas, { outputTimes: curve.linear_output_times, inputTimes: curve.linear_input_times });
    pen.setLineDash([7, 3, 1.5, 3]);
    pen.strokeStyle = palette.spline;
    speedCurve(canvas, splineOf(curve));
    pen.setLineDash([]);
    const kept = typeof store.view.companion === "object" ? store.companionKnots : null;
    if (kept) {
      pen.lineWidth = 1.6;
      speedCurve(canvas, kept);
    }
    pen.lineWidth = 1.9;
    pen.strokeStyle = palette.output;
    speedCurve(canvas, { outputTimes: curve.output_times, inputTimes: curve.input_times });
  });
}

/** Draw a warp on the map; the caller keeps it inside. */
export function mapCurve(canvas: Canvas, knots: Knots, color: string, width: number, dashes: readonly number[]): void {
  const { pen, layout, scales } = canvas;
  pen.strokeStyle = color;
  pen.lineWidth = width;
  pen.lineJoin = "round";
  pen.setLineDash([...dashes]);
  pen.beginPath();
  const from = Math.max(scales.output.from, outputStart(knots));
  const to = Math.min(scales.output.to, outputEnd(knots));
  const first = pieceAt(knots.outputTimes, from);
  const last = pieceAt(knots.outputTimes, to) + 1;
  if (to < from) return;
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

function speedCurve(canvas: Canvas, warp: Knots): void {
  const { pen, layout, scales } = canvas;
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
}
