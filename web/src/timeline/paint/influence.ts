/** Influence over time: above it is guided, below the spline through the keytimes. */

import { influenceAt } from "../../influence";
import { clamp } from "../../scale";
import { type Knots, outputEnd } from "../../warp";
import { outputTimeAt, outputX } from "../layout";
import { type Canvas, clipped, label } from "./canvas";

export function influenceLabel(canvas: Canvas): void {
  const { layout, palette } = canvas;
  const box = layout.influence;
  if (box.height > 0) label(canvas, "Influence", 8, box.y + box.height / 2, "left", palette.muted);
}

export function influence(canvas: Canvas, knots: Knots): void {
  const { pen, layout, scales, palette, store } = canvas;
  const box = layout.influence;
  const { document } = store;
  if (box.height === 0 || !document) return;
  clipped(canvas, box, () => {
    pen.fillStyle = palette.line;
    pen.globalAlpha = 0.5;
    pen.fillRect(box.x, box.y, box.width, box.height);
    pen.globalAlpha = 1;
    const left = clamp(outputX(layout, scales, 0), box.x, box.x + box.width);
    const right = clamp(outputX(layout, scales, outputEnd(knots)), box.x, box.x + box.width);
    const yAt = (x: number): number =>
      box.y + 2 + (1 - influenceAt(document, outputTimeAt(layout, scales, x))) * (box.height - 4);
    pen.beginPath();
    pen.moveTo(left, yAt(left));
    for (let x = Math.ceil(left); x < right; x++) pen.lineTo(x, yAt(x));
    pen.lineTo(right, yAt(right));
    pen.strokeStyle = palette.output;
    pen.lineWidth = 1.6;
    pen.stroke();
    pen.lineTo(right, box.y + box.height);
    pen.lineTo(left, box.y + box.height);
    pen.closePath();
    pen.fillStyle = palette["output-soft"];
    pen.fill();
    if (document.influence.length > 0) return;
    label(
      canvas,
      "Paint here: above the search leads, below the spline through the keytimes",
      left + 8,
      box.y + box.height / 2,
    );
  });
}
