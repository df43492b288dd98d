/** The timeline's canvases: as many pixels as the screen has, and what stays painted once. */

import { make } from "../dom";
import type { Store, Topic } from "../store";
import type { Theme } from "../theme";
import { unitsOf } from "../units";
import { outputEnd } from "../warp";
import type { Layout, Scales } from "./layout";
import type { Canvas } from "./paint/canvas";
import { markersAt, paintBackdrop, paintForeground, paintMarkers } from "./paint/painter";

export class Surface {
  readonly canvas = make("canvas", {
    role: "img",
    "aria-label":
      "Time map, speed, scores and reference. Click to move the playhead, double-click the map to add a keytime.",
  });
  /** Over it, for the playhead and the pointer: while it plays, nothing else is painted. */
  readonly markers = make("div", { class: "markers", "aria-hidden": true });
  private readonly marked = document.createElement("canvas");
  /** What stays while a curve changes, and what it was painted of: text and many small marks take milliseconds. */
  private readonly backdrop = document.createElement("canvas");
  private backdropOf: readonly unknown[] = [];
  /** Where the playhead and the pointer are painted, and of what. */
  private where = "";

  constructor(
    private readonly store: Store,
    private readonly theme: Theme,
  ) {
    this.markers.append(this.marked);
  }

  /** Paint what changed; where that is the playhead or the pointer alone, only what shows where they are. */
  paint(layout: Layout, scales: Scales, changed: Set<Topic>): void {
    const { store, theme, canvas, marked } = this;
    const ratio = devicePixelRatio;
    for (const one of [canvas, marked]) {
      resize(one, Math.round(layout.width * ratio), Math.round(layout.height * ratio));
    }
    const canvasOf = (pen: CanvasRenderingContext2D): Canvas => ({
      pen,
      layout,
      scales,
      store,
      palette: theme.palette,
    });
    const marker = marked.getContext("2d");
    const { where } = this;
    this.where = `${marked.width} ${marked.height} ${markersAt(store, layout, scales)}`;
    // Of a long take the playhead goes on by a pixel in many pictures.
    if (marker && !(onlyMarkers(changed) && this.where === where)) {
      marker.setTransform(ratio, 0, 0, ratio, 0, 0);
      paintMarkers(canvasOf(marker));
    }
    const pen = onlyMarkers(changed) ? null : penOf(canvas);
    if (!pen) return;
    this.paintBackdrop(ratio, layout, scales, changed, canvasOf);
    pen.setTransform(1, 0, 0, 1, 0, 0);
    pen.globalCompositeOperation = "copy";
    pen.drawImage(this.backdrop, 0, 0);
    pen.globalCompositeOperation = "source-over";
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    paintForeground(canvasOf(pen));
  }

  /** Paint the backdrop again, where something that it shows has changed. */
  private paintBackdrop(
    ratio: number,
    layout: Layout,
    scales: Scales,
    changed: Set<Topic>,
    canvasOf: (pen: CanvasRenderingContext2D) => Canvas,
  ): void {
    const { store, theme, backdrop } = this;
    const { width, height } = this.canvas;
    const end = store.knots ? outputEnd(store.knots) : null;
    const references = store.document?.references;
    const of = [
      width,
      height,
      ratio,
      scales,
      theme.palette,
      store.why,
      end,
      references,
      store.reference,
      // Rows come and go.
      layout.speed.y,
      layout.influence.height,
      layout.sound.height,
      unitsOf(store),
    ];
    if (!changed.has("clips") && of.every((part, i) => part === this.backdropOf[i])) return;
    this.backdropOf = of;
    resize(backdrop, width, height);
    const pen = penOf(backdrop);
    if (!pen) return;
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    paintBackdrop(canvasOf(pen));
  }
}

/** Whether nothing changed but where the playhead and the pointer are. */
export function onlyMarkers(changed: ReadonlySet<Topic>): boolean {
  return [...changed].every((topic) => topic === "playhead" || topic === "hover");
}

/** Give a canvas its size in pixels; to say the same size again would clear it. */
function resize(canvas: HTMLCanvasElement, width: number, height: number): void {
  if (canvas.width !== width) canvas.width = width;
  if (canvas.height !== height) canvas.height = height;
}

/** Without transparency: what lies behind the canvas need not be drawn. */
function penOf(canvas: HTMLCanvasElement): CanvasRenderingContext2D | null {
  return canvas.getContext("2d", { alpha: false });
}
