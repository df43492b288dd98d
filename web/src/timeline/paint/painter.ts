/** What is drawn on the timeline's canvases, everything that is not a handle, from the back to the front. */

import type { Store } from "../../store";
import { rowAt } from "../../why";
import { type Layout, outputX, type Scales } from "../layout";
import { frames, inputAxis, outputAxis, speedAxis } from "./axes";
import { type Canvas, FONT } from "./canvas";
import { mapCurves, speedCurves } from "./curves";
import { example, exampleCurve, unspoken } from "./example";
import { feet } from "./feet";
import { heat } from "./heat";
import { influence, influenceLabel } from "./influence";
import { pastEnd, playhead, tangent } from "./markers";
import { markers, workArea } from "./marks";
import { matches, reference } from "./reference_strip";
import { beats, sound, soundLabel } from "./sound";
import { flights, locks } from "./spans";

/** What stays while a curve changes: axes, scores, the reference. */
export function paintBackdrop(canvas: Canvas): void {
  const { pen, layout, palette } = canvas;
  pen.font = FONT;
  pen.textBaseline = "middle";
  pen.fillStyle = palette.surface;
  pen.fillRect(0, 0, layout.width, layout.height);
  pen.fillStyle = palette.panel;
  pen.fillRect(0, 0, layout.width, layout.ruler.height);
  pen.fillRect(0, 0, layout.map.x, layout.height);
  outputAxis(canvas);
  inputAxis(canvas);
  speedAxis(canvas);
  soundLabel(canvas);
  influenceLabel(canvas);
  if (canvas.store.knots) heat(canvas, canvas.store.knots);
  reference(canvas);
  frames(canvas);
}

/** What changes with the curve, over it. */
export function paintForeground(canvas: Canvas): void {
  const { knots } = canvas.store;
  canvas.pen.font = FONT;
  canvas.pen.textBaseline = "middle";
  if (knots) {
    flights(canvas, knots);
    feet(canvas, knots);
    influence(canvas, knots);
    sound(canvas, knots);
    beats(canvas, knots);
    example(canvas);
    unspoken(canvas, knots);
    locks(canvas, knots);
    exampleCurve(canvas);
    mapCurves(canvas, knots);
    speedCurves(canvas);
    pastEnd(canvas, knots);
    workArea(canvas, knots);
  }
  markers(canvas);
}

/** Which pixels the playhead and the pointer stand on, and which matches are shown: the same, and so are the markers. */
export function markersAt(store: Store, layout: Layout, scales: Scales): string {
  const { hover, why, playback } = store;
  const pixel = (time: number): number => Math.round(outputX(layout, scales, time));
  const row = why ? rowAt(why, store.lookedAt) : null;
  return `${pixel(playback.outputTime)} ${hover === null ? null : pixel(hover)} ${row}`;
}

/** What moves while nothing else does: the playhead, the pointer, and what belongs to the frame that is looked at. */
export function paintMarkers(canvas: Canvas): void {
  canvas.pen.clearRect(0, 0, canvas.layout.width, canvas.layout.height);
  matches(canvas);
  playhead(canvas);
  tangent(canvas);
}
