/** The sound beside the stage, as it is heard along the output; and beats. */

import { beatsInOutput, offsetOf } from "../../media/beside";
import { peakBetween } from "../../media/peaks";
import { clamp } from "../../scale";
import { inputAt, type Knots, outputEnd } from "../../warp";
import { outputTimeAt, outputX } from "../layout";
import { type Canvas, clipped, label } from "./canvas";

export function soundLabel(canvas: Canvas): void {
  const { layout, palette } = canvas;
  if (layout.sound.height > 0)
    label(canvas, "Sound", 8, layout.sound.y + layout.sound.height / 2, "left", palette.muted);
}

export function sound(canvas: Canvas, knots: Knots): void {
  const { pen, layout, scales, palette, store } = canvas;
  const box = layout.sound;
  const media = store.document?.media;
  const { peaks } = store.beside;
  if (box.height === 0 || !media || !peaks) return;
  clipped(canvas, box, () => {
    pen.fillStyle = palette.line;
    pen.globalAlpha = 0.5;
    pen.fillRect(box.x, box.y, box.width, box.height);
    pen.globalAlpha = 1;
    pen.fillStyle = palette.input;
    const first = Math.floor(clamp(outputX(layout, scales, 0), box.x, box.x + box.width));
    const last = Math.ceil(clamp(outputX(layout, scales, outputEnd(knots)), box.x, box.x + box.width));
    const middle = box.y + box.height / 2;
    const offset = offsetOf(media, store.rate);
    const timeAt = (x: number): number => {
      const time = outputTimeAt(layout, scales, x);
      return (media.clock === "input" ? inputAt(knots, time) : time) - offset;
    };
    let before = timeAt(first);
    for (let x = first; x < last; x++) {
      const after = timeAt(x + 1);
      // What stands is not heard.
      const half = before === after ? 0 : (peakBetween(peaks, before, after) * (box.height - 2)) / 2;
      pen.fillRect(x, middle - Math.max(half, 0.5), 1, Math.max(2 * half, 1));
      before = after;
    }
  });
}

/** A line for each beat, over the map and the sound; strong ones are darker. */
export function beats(canvas: Canvas, knots: Knots): void {
  const { pen, layout, scales, palette, store } = canvas;
  const { document } = store;
  const found = store.beside.beats;
  if (!found || !document) return;
  const { ruler, map, sound: strip } = layout;
  clipped(canvas, { x: map.x, y: 0, width: map.width, height: layout.height }, () => {
    pen.fillStyle = palette.reference;
    let before = -Infinity;
    beatsInOutput(document, found, knots, store.rate).forEach((time, i) => {
      const x = Math.round(outputX(layout, scales, time));
      // Closer than two pixels they would be a grey surface.
      if (x < map.x || x > map.x + map.width || Math.abs(x - before) < 2) return;
      before = x;
      const strength = found.strengths[i] ?? 1;
      pen.globalAlpha = 0.18 + 0.3 * strength;
      pen.fillRect(x, map.y, 1, map.height);
      pen.globalAlpha = 0.95;
      pen.fillRect(x - 0.5, ruler.height - 6, 2, 6);
      if (strip.height > 0) pen.fillRect(x, strip.y, 1, strip.height);
    });
    pen.globalAlpha = 1;
  });
}
