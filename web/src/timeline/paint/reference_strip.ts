/** The reference's own time: what of it is imitated, and which frames of it were matched. */

import { clamp, toPixels, type View } from "../../scale";
import { unitsOf } from "../../units";
import { matchesAt, rowAt } from "../../why";
import { type Box, type Layout, referenceView } from "../layout";
import { type ReferenceSpan, referenceNames, referenceSpan } from "../reference_span";
import { timeTicks } from "../time_ticks";
import { type Canvas, clipped, label } from "./canvas";

/** The reference's own time: what of it is imitated, and which frames of it were matched. */
export function reference(canvas: Canvas): void {
  const { pen, layout, palette, store } = canvas;
  const whole = referenceSpan(store);
  if (!whole) return;
  const box = referenceBox(layout);
  const view = referenceView(canvas.scales, whole.lastTime);
  const x = (time: number): number => box.x + toPixels(view, box.width, time);
  const held = (time: number): number => clamp(x(time), box.x, box.x + box.width);
  pen.fillStyle = palette.line;
  pen.fillRect(held(0), box.y, held(whole.lastTime) - held(0), box.height);
  pen.fillStyle = palette.reference;
  pen.globalAlpha = 0.16;
  pen.fillRect(held(whole.start), box.y, held(whole.end) - held(whole.start), box.height);
  pen.globalAlpha = 1;
  scale(canvas, whole, view, box);
  const { why } = store;
  if (!why) return;
  pen.fillStyle = palette.reference;
  pen.globalAlpha = 0.5;
  clipped(canvas, box, () => {
    for (let row = 1; row + 1 < why.n_output; row++) {
      const [match] = matchesAt(why, row);
      if (match?.source === whole.source) pen.fillRect(x(match.time + whole.offset), box.y + box.height - 5, 1, 5);
    }
  });
  pen.globalAlpha = 1;
}

/** Times of the reference, by its own clock, and its name where there are several. */
function scale(canvas: Canvas, whole: ReferenceSpan, view: View, box: Box): void {
  const { pen, palette, store } = canvas;
  const { rate } = whole.clip;
  const units = unitsOf(store);
  const name = whole.source >= 0 ? (referenceNames(store)[whole.source] ?? "") : "";
  const taken = name === "" ? 0 : pen.measureText(name).width + 20;
  const widest = pen.measureText(timeTicks(view, 2, rate, units).label(view.to)).width;
  const { values, label: text } = timeTicks(
    view,
    Math.max(1, Math.floor(box.width / Math.max(78, widest + 24))),
    rate,
    units,
  );
  clipped(canvas, box, () => {
    if (name !== "") label(canvas, name, box.x + 8, box.y + 7, "left", palette.reference);
    for (const value of values) {
      if (value < -1e-9 || value > whole.lastTime + 1e-9) continue;
      const at = Math.round(box.x + toPixels(view, box.width, value));
      pen.fillStyle = palette["line-strong"];
      pen.fillRect(at, box.y, 1, 4);
      const said = text(value);
      const isFree = at + 4 > box.x + taken && at + 4 + pen.measureText(said).width <= box.x + box.width;
      if (isFree) label(canvas, said, at + 4, box.y + 7);
    }
  });
}

/** The reference frames that the frame looked at was matched with. */
export function matches(canvas: Canvas): void {
  const { pen, layout, palette, store } = canvas;
  const whole = referenceSpan(store);
  const { why } = store;
  if (!whole || !why) return;
  const box = referenceBox(layout);
  const time = store.lookedAt;
  pen.fillStyle = palette.reference;
  for (const match of matchesAt(why, rowAt(why, time))) {
    if (match.source !== whole.source) continue;
    const x = box.x + toPixels(referenceView(canvas.scales, whole.lastTime), box.width, match.time + whole.offset);
    clipped(canvas, box, () => pen.fillRect(Math.round(x) - 1, box.y, 2, box.height));
  }
}

function referenceBox({ reference }: Layout): Box {
  return { ...reference, y: reference.y + 4, height: reference.height - 8 };
}
