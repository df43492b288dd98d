/** When the feet stand, one line a foot, along the output. */

import { at, inputAt, type Knots, outputEnd, pieceAt } from "../../warp";
import { outputTimeAt, outputX } from "../layout";
import { type Canvas, clipped } from "./canvas";

export function feet(canvas: Canvas, knots: Knots): void {
  const { pen, layout, scales, palette, store } = canvas;
  const box = layout.feet;
  const { clip } = store;
  if (box.height === 0 || !clip) return;
  const { contacts } = clip;
  const end = outputX(layout, scales, outputEnd(knots));
  const step = box.height / Math.max(1, clip.feet.length);
  clipped(canvas, box, () => {
    pen.fillStyle = palette.line;
    pen.fillRect(box.x, box.y, box.width, box.height);
    pen.fillStyle = palette.input;
    clip.feet.forEach((_, foot) => {
      const [starts, ends] = spansOf(contacts, foot);
      if (starts.length === 0) return;
      const stands = (x: number): boolean => {
        const time = inputAt(knots, outputTimeAt(layout, scales, x));
        const i = pieceAt(starts, time);
        return time >= at(starts, i) && time <= at(ends, i);
      };
      // Pixel by pixel, neighbours together: a take may have more contacts than the row has pixels.
      let since: number | null = null;
      const first = Math.floor(Math.max(box.x, outputX(layout, scales, 0)));
      const last = Math.ceil(Math.min(box.x + box.width, end));
      for (let x = first; x <= last; x++) {
        const on = x < last && stands(x + 0.5);
        if (on && since === null) since = x;
        if (!on && since !== null) {
          pen.fillRect(since, box.y + foot * step + 0.5, x - since, Math.max(1, step - 1));
          since = null;
        }
      }
    });
  });
}

const known = new WeakMap<Float64Array, Map<number, [Float64Array, Float64Array]>>();

/** From when to when one foot stands; sorted once. `pieceAt` wants one start more than there are pieces. */
function spansOf(contacts: Float64Array, foot: number): [Float64Array, Float64Array] {
  let feet = known.get(contacts);
  if (!feet) {
    feet = new Map();
    known.set(contacts, feet);
  }
  let spans = feet.get(foot);
  if (!spans) {
    const starts: number[] = [];
    const ends: number[] = [];
    for (let i = 0; i + 2 < contacts.length; i += 3) {
      if (at(contacts, i) !== foot) continue;
      starts.push(at(contacts, i + 1));
      ends.push(at(contacts, i + 2));
    }
    if (starts.length > 0) {
      starts.push(Infinity);
      ends.push(Infinity);
    }
    spans = [Float64Array.from(starts), Float64Array.from(ends)];
    feet.set(foot, spans);
  }
  return spans;
}
