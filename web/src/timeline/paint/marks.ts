/** Markers, with their names, and the work area. */

import { playedStretch } from "../../markers";
import type { Knots } from "../../warp";
import { inputY, outputX } from "../layout";
import { type Canvas, clipped, label } from "./canvas";

/** The work area along the ruler; what lies outside of it is dimmed on the map and the speed. */
export function workArea(canvas: Canvas, knots: Knots): void {
  const { pen, layout, scales, palette, store } = canvas;
  const area = playedStretch(store.document, knots);
  if (!area) return;
  const { ruler, map, speed } = layout;
  const from = outputX(layout, scales, area.start);
  const to = outputX(layout, scales, area.end);
  clipped(canvas, { ...ruler, height: ruler.y + ruler.height }, () => {
    pen.fillStyle = palette.playhead;
    pen.globalAlpha = 0.5;
    pen.fillRect(from, ruler.y + ruler.height - 5, to - from, 4);
    pen.globalAlpha = 1;
  });
  pen.fillStyle = palette.panel;
  pen.globalAlpha = 0.6;
  for (const box of [map, speed]) {
    clipped(canvas, box, () => {
      pen.fillRect(box.x, box.y, from - box.x, box.height);
      pen.fillRect(to, box.y, box.x + box.width - to, box.height);
    });
  }
  pen.globalAlpha = 1;
}

export function markers(canvas: Canvas): void {
  const { pen, layout, scales, palette, store } = canvas;
  const { map, ruler, heat } = layout;
  const across = { x: map.x, y: 0, width: map.width, height: layout.height };
  for (const marker of store.document?.markers ?? []) {
    pen.fillStyle = palette.lock;
    clipped(canvas, across, () => {
      if (marker.on === "output") {
        const x = Math.round(outputX(layout, scales, marker.time));
        dotted(canvas, x, map.y, 1, heat.y + heat.height - map.y);
        if (marker.name) named(canvas, marker.name, x + 7, ruler.y + ruler.height - 8);
      } else {
        const y = Math.round(inputY(layout, scales, marker.time));
        if (y < map.y || y > map.y + map.height) return;
        dotted(canvas, map.x, y, map.width, 1);
        if (marker.name) named(canvas, marker.name, map.x + 12, y - 9);
      }
    });
  }
}

/** Write a name on a ground of its own: what lies under it stays legible beside it, not through it. */
function named(canvas: Canvas, name: string, x: number, y: number): void {
  const { pen, palette } = canvas;
  const text = name.length > MOST_LETTERS ? `${name.slice(0, MOST_LETTERS - 1)}…` : name;
  pen.fillStyle = palette.panel;
  pen.fillRect(x - 2, y - 7, pen.measureText(text).width + 4, 14);
  label(canvas, text, x, y, "left", palette.lock);
}

/** Letters of a name that are painted; all of it stands in the list. */
const MOST_LETTERS = 24;

function dotted({ pen }: Canvas, x: number, y: number, width: number, height: number): void {
  const long = Math.max(width, height);
  for (let i = 0; i < long; i += 6)
    pen.fillRect(
      width > height ? x + i : x,
      width > height ? y : y + i,
      width > height ? 3 : 1,
      width > height ? 1 : 3,
    );
}
