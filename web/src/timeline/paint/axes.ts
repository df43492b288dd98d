/** Axes: output time above, input time at the left, speed on a log scale, and the names of the rows. */

import { unitsOf } from "../../units";
import { inputY, outputX, speedLevel, speedY } from "../layout";
import { timeTicks } from "../time_ticks";
import { type Canvas, label } from "./canvas";

const SPEED_TICKS = [16, 8, 4, 2, 1, 1 / 2, 1 / 4, 1 / 8, 0, -1 / 4, -1, -2, -4, -8];
const SPEED_NAMES = new Map([
  [1 / 8, "⅛×"],
  [1 / 4, "¼×"],
  [1 / 2, "½×"],
  [0, "hold"],
  [-1 / 4, "−¼×"],
]);
/** Above the head of the playhead, which else would lie on them. */
const LABEL_Y = 8;
/** Pixels from one label to the next at least. */
const SPEED_ROOM = 12;

export function outputAxis(canvas: Canvas): void {
  const { pen, layout, scales, palette, store } = canvas;
  // As many as stand beside each other whole.
  const widest = pen.measureText(timeTicks(scales.output, 2, store.rate, unitsOf(store)).label(scales.output.to)).width;
  const most = Math.max(1, Math.floor(layout.map.width / Math.max(78, widest + 24)));
  const { values, label: text } = timeTicks(scales.output, most, store.rate, unitsOf(store));
  const right = layout.map.x + layout.map.width;
  for (const value of values) {
    if (value < -1e-9) continue;
    const x = Math.round(outputX(layout, scales, value));
    pen.fillStyle = palette.line;
    pen.fillRect(x, layout.map.y, 1, layout.map.height);
    pen.fillRect(x, layout.speed.y, 1, layout.speed.height);
    pen.fillStyle = palette["line-strong"];
    pen.fillRect(x, layout.ruler.height - 5, 1, 5);
    const said = text(value);
    if (x + 4 + pen.measureText(said).width <= right) label(canvas, said, x + 4, LABEL_Y, "left");
  }
  label(canvas, "Output", 8, layout.ruler.height / 2, "left", palette.output);
}

export function inputAxis(canvas: Canvas): void {
  const { pen, layout, scales, palette, store } = canvas;
  const most = Math.max(2, Math.floor(layout.map.height / 34));
  const { values, label: text } = timeTicks(scales.input, most, store.rate, unitsOf(store));
  for (const value of values) {
    if (value < -1e-9 || value > store.inputEnd + 1e-9) continue;
    const y = Math.round(inputY(layout, scales, value));
    if (y < layout.map.y || y > layout.map.y + layout.map.height) continue;
    pen.fillStyle = palette.line;
    pen.fillRect(layout.map.x, y, layout.map.width, 1);
    if (y > layout.map.y + 16) label(canvas, text(value), layout.map.x - 18, y, "right");
  }
  label(canvas, "Input", 8, layout.map.y + 9, "left", palette.input);
}

export function speedAxis(canvas: Canvas): void {
  const { pen, layout, scales, palette } = canvas;
  const { speed } = layout;
  const zero = speedLevel(0);
  if (scales.speed.from < zero - 0.5) {
    // Below a hold the clip plays backward.
    const top = speedY(layout, scales, 0);
    pen.fillStyle = palette["lock-soft"];
    pen.fillRect(speed.x, top, speed.width, speed.y + speed.height - top);
  }
  // Those that matter most have their label first, where not all have room.
  const written: number[] = [];
  for (const value of [...SPEED_TICKS].sort((a, b) => rank(a) - rank(b))) {
    const level = speedLevel(value);
    if (level < scales.speed.from || level > scales.speed.to) continue;
    const y = Math.round(speedY(layout, scales, value));
    pen.fillStyle = value === 1 || value === 0 ? palette["line-strong"] : palette.line;
    pen.fillRect(speed.x, y, speed.width, 1);
    if (written.some((other) => Math.abs(other - y) < SPEED_ROOM)) continue;
    written.push(y);
    label(canvas, SPEED_NAMES.get(value) ?? `${value}×`.replace("-", "−"), speed.x - 8, y, "right");
  }
  label(canvas, "Speed", 8, layout.speed.y + 9, "left", palette.muted);
  label(canvas, "Score", 8, layout.heat.y + layout.heat.height / 2, "left", palette.muted);
  if (layout.feet.height > 0) label(canvas, "Feet", 8, layout.feet.y + layout.feet.height / 2, "left", palette.muted);
  // Of several one is shown; which, is chosen there.
  if ((canvas.store.document?.references.length ?? 0) > 1) return;
  label(canvas, "Reference", 8, layout.reference.y + layout.reference.height / 2, "left", palette.reference);
}

function rank(speed: number): number {
  const isWhole = Math.log2(Math.abs(speed || 1)) % 2 === 0;
  return speed === 1 ? 0 : speed === 0 ? 1 : isWhole ? 2 : 3;
}

/** Lines around the map and the speed, and under the ruler. */
export function frames(canvas: Canvas): void {
  const { pen, layout, palette } = canvas;
  pen.strokeStyle = palette.line;
  pen.lineWidth = 1;
  for (const box of [layout.map, layout.speed]) pen.strokeRect(box.x + 0.5, box.y + 0.5, box.width - 1, box.height - 1);
  pen.fillStyle = palette["line-strong"];
  pen.fillRect(0, layout.ruler.height - 1, layout.width, 1);
}
