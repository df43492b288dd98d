/** Spans that timing must not touch, or may only so far: flights and locks. */

import { type Knots, outputAt } from "../../warp";
import { inputY, outputX, speedY } from "../layout";
import { type Canvas, clipped } from "./canvas";

/** Where the figure is in the air: what timing must not touch. */
export function flights(canvas: Canvas, knots: Knots): void {
  const flights = canvas.store.flights.filter((flight) => flight.flies);
  const { pen, layout, scales, palette } = canvas;
  for (const box of [layout.map, layout.speed]) {
    clipped(canvas, box, () => {
      pen.fillStyle = palette.flight;
      for (const { start, end } of flights) {
        const from = outputX(layout, scales, outputAt(knots, start));
        const to = outputX(layout, scales, outputAt(knots, end));
        pen.fillRect(Math.min(from, to), box.y, Math.abs(to - from), box.height);
      }
    });
  }
}

export function locks(canvas: Canvas, knots: Knots): void {
  const { pen, layout, scales, palette, store } = canvas;
  for (const lock of store.document?.locks ?? []) {
    const chosen = store.selection?.kind === "lock" && store.selection.id === lock.id;
    const from = outputX(layout, scales, outputAt(knots, lock.start));
    const to = outputX(layout, scales, outputAt(knots, lock.end));
    const top = inputY(layout, scales, lock.end);
    const bottom = inputY(layout, scales, lock.start);
    clipped(canvas, layout.map, () => {
      pen.fillStyle = palette["lock-soft"];
      pen.fillRect(layout.map.x, top, layout.map.width, bottom - top);
      pen.fillRect(from, layout.map.y, to - from, layout.map.height);
      pen.strokeStyle = palette.lock;
      pen.lineWidth = chosen ? 1.5 : 1;
      pen.globalAlpha = chosen ? 1 : 0.6;
      pen.strokeRect(from, top, to - from, bottom - top);
      pen.globalAlpha = 1;
    });
    clipped(canvas, layout.speed, () => {
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
