/** What points at a time: the output's end, the playhead, the pointer, and the tangent of the chosen keytime. */

import { findKey } from "../../document";
import { type Knots, outputEnd, speedAt } from "../../warp";
import { inputY, outputX, tangentArm } from "../layout";
import { type Canvas, clipped } from "./canvas";

/** What lies after the output's end is not part of it: it is paler. */
export function pastEnd({ pen, layout, scales, palette }: Canvas, knots: Knots): void {
  const x = outputX(layout, scales, outputEnd(knots));
  const width = layout.map.x + layout.map.width - x;
  if (width <= 0) return;
  pen.fillStyle = palette.panel;
  pen.globalAlpha = 0.65;
  for (const box of [layout.map, layout.speed]) pen.fillRect(x, box.y + 1, width - 1, box.height - 2);
  pen.globalAlpha = 1;
}

export function playhead(canvas: Canvas): void {
  const { pen, layout, scales, palette, store } = canvas;
  const { ruler, heat } = layout;
  const bottom = heat.y + heat.height;
  clipped(canvas, { x: layout.map.x - 6, y: 0, width: layout.map.width + 12, height: layout.height }, () => {
    if (store.hover !== null) {
      pen.fillStyle = palette.muted;
      pen.globalAlpha = 0.6;
      pen.fillRect(Math.round(outputX(layout, scales, store.hover)), layout.map.y, 1, bottom - layout.map.y);
      pen.globalAlpha = 1;
    }
    const x = Math.round(outputX(layout, scales, store.playback.outputTime));
    pen.fillStyle = palette.playhead;
    pen.fillRect(x, ruler.height - 7, 1, bottom - ruler.height + 7);
    pen.beginPath();
    pen.moveTo(x - 5.5, ruler.height - 12);
    pen.lineTo(x + 6.5, ruler.height - 12);
    pen.lineTo(x + 6.5, ruler.height - 6);
    pen.lineTo(x + 0.5, ruler.height);
    pen.lineTo(x - 5.5, ruler.height - 6);
    pen.closePath();
    pen.fill();
  });
}

/** The line through the chosen keytime, whose slope is the speed there: dashed, where the speed is free. */
export function tangent(canvas: Canvas): void {
  const { pen, layout, scales, palette, store } = canvas;
  const { selection, chosenKeys, document, knots } = store;
  if (chosenKeys.size > 1) return;
  const key = selection?.kind === "key" && document ? findKey(document, selection.id) : null;
  if (!key || !store.curve) return;
  const [dx, dy] = tangentArm(layout, scales, key.speed ?? (knots ? speedAt(knots, key.output_time) : 1));
  const x = outputX(layout, scales, key.output_time);
  const y = inputY(layout, scales, key.input_time);
  clipped(canvas, layout.map, () => {
    pen.strokeStyle = palette.output;
    pen.globalAlpha = key.speed === null ? 0.45 : 1;
    pen.lineWidth = 1.3;
    if (key.speed === null) pen.setLineDash([3, 3]);
    pen.beginPath();
    pen.moveTo(x - dx, y - dy);
    pen.lineTo(x + dx, y + dy);
    pen.stroke();
  });
}
