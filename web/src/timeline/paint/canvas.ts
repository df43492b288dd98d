/** What everything on the timeline's canvas is painted with. */

import type { Store } from "../../store";
import type { Palette } from "../../theme";
import type { Box, Layout, Scales } from "../layout";

export const FONT = '11px system-ui, "Segoe UI", "Noto Sans", "DejaVu Sans", sans-serif';

export interface Canvas {
  readonly pen: CanvasRenderingContext2D;
  readonly layout: Layout;
  readonly scales: Scales;
  readonly store: Store;
  readonly palette: Palette;
}

export function label(
  { pen, palette }: Canvas,
  text: string,
  x: number,
  y: number,
  align: CanvasTextAlign = "left",
  color = palette.muted,
): void {
  pen.textAlign = align;
  pen.fillStyle = color;
  pen.fillText(text, x, y);
}

/** Draw inside a box; what would lie outside is cut off. */
export function clipped({ pen }: Canvas, box: Box, draw: () => void): void {
  pen.save();
  pen.beginPath();
  pen.rect(box.x, box.y, box.width, box.height);
  pen.clip();
  draw();
  pen.restore();
}
