/** The reference's own time: what of it is imitated, and which frames of it were matched. */

import { toPixels } from "../../scale";
import { matchesAt, rowAt } from "../../why";
import type { Box, Layout } from "../layout";
import { referenceNames, referenceSpan } from "../reference_span";
import { type Canvas, clipped, label } from "./canvas";

/** The reference's own time: what of it is imitated, and which frames of it were matched. */
export function reference(canvas: Canvas): void {
  const { pen, layout, palette, store } = canvas;
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
    clipped(canvas, box, () => label(canvas, name, x(whole.start) + 8, box.y + 8, "left", palette.reference));
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
export function matches(canvas: Canvas): void {
  const { pen, layout, palette, store } = canvas;
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

function referenceBox({ reference }: Layout): Box {
  return { ...reference, y: reference.y + 4, height: reference.height - 8 };
}
