/** An example that is carried over: the curve that was made by hand, and where in the rest it has nothing to say. */

import { at, type Knots, outputAt } from "../../warp";
import { inputY, outputX } from "../layout";
import { type Canvas, clipped } from "./canvas";
import { mapCurve } from "./curves";

/** The example's stretch of the input. */
export function example(canvas: Canvas): void {
  const { pen, layout, scales, palette, store } = canvas;
  const span = store.document?.example;
  if (!span) return;
  clipped(canvas, layout.map, () => {
    const top = inputY(layout, scales, span.end);
    const bottom = inputY(layout, scales, span.start);
    pen.fillStyle = palette["output-soft"];
    pen.fillRect(layout.map.x, top, layout.map.width, bottom - top);
  });
}

/** The example as it was made by hand, at its own times: its keytimes lie on it. */
export function exampleCurve(canvas: Canvas): void {
  const { curve } = canvas.store;
  if (!curve || curve.hand_output_times.length < 2) return;
  const hand = { outputTimes: curve.hand_output_times, inputTimes: curve.hand_input_times };
  clipped(canvas, canvas.layout.map, () => mapCurve(canvas, hand, canvas.palette.key, 1.6, [2, 3]));
}

/** Hatched: what the example says nothing of. */
export function unspoken(canvas: Canvas, knots: Knots): void {
  const { pen, layout, scales, palette, store } = canvas;
  const stretches = store.curve?.unspoken ?? [];
  for (let i = 0; i + 1 < stretches.length; i += 2) {
    const from = outputX(layout, scales, outputAt(knots, at(stretches, i)));
    const to = outputX(layout, scales, outputAt(knots, at(stretches, i + 1)));
    const { y, height } = layout.map;
    const left = Math.max(from, layout.map.x);
    const right = Math.min(to, layout.map.x + layout.map.width);
    if (right <= left) continue;
    clipped(canvas, { x: left, y, width: right - left, height }, () => {
      pen.strokeStyle = palette.muted;
      pen.globalAlpha = 0.45;
      pen.lineWidth = 1;
      pen.setLineDash([]);
      pen.beginPath();
      // The lines of all stretches are one pattern, which stays where it is while a stretch moves.
      const first = Math.floor((left - height) / 9) * 9;
      for (let x = first; x < right; x += 9) {
        pen.moveTo(x, y + height);
        pen.lineTo(x + height, y);
      }
      pen.stroke();
      pen.globalAlpha = 1;
    });
  }
}
