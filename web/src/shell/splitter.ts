/** The bar above the timeline that makes it higher or lower. The browser remembers how high. */

import { make } from "../dom";
import { recall, remember } from "../memory";
import { clamp } from "../scale";

const STORED = "retime.timeline";
/** Heights of the timeline, and what is left to the stage and the bars; pixels. */
const LEAST = 180;
const MOST = 700;
const ABOVE = 220;
const STEP = 16;

/** Make the bar; `set` is called after the height was changed. */
export function makeSplitter(root: HTMLElement, timeline: HTMLElement, set: () => void): HTMLElement {
  const splitter = make("div", {
    class: "splitter",
    role: "separator",
    tabindex: 0,
    "aria-label": "Height of the timeline",
    "aria-orientation": "horizontal",
    "aria-valuemin": LEAST,
    "aria-valuemax": MOST,
    "aria-valuenow": 330,
  });
  const setHeight = (height: number): void => {
    const held = Math.round(clamp(height, LEAST, Math.max(LEAST, root.clientHeight - ABOVE)));
    root.style.setProperty("--timeline-height", `${held}px`);
    splitter.setAttribute("aria-valuenow", String(held));
    remember(STORED, String(held));
    set();
  };
  const stored = Number(recall(STORED));
  // Once it is on the page: before, it has no height to be held in.
  if (stored >= LEAST) queueMicrotask(() => setHeight(stored));
  splitter.addEventListener("pointerdown", (down) => {
    splitter.setPointerCapture(down.pointerId);
    const start = timeline.clientHeight;
    const over = new AbortController();
    const { signal } = over;
    const move = (event: PointerEvent): void => setHeight(start - (event.clientY - down.clientY));
    splitter.addEventListener("pointermove", move, { signal });
    splitter.addEventListener("pointerup", () => over.abort(), { signal });
    splitter.addEventListener("pointercancel", () => over.abort(), { signal });
  });
  splitter.addEventListener("keydown", (event) => {
    const by = { ArrowUp: STEP, ArrowDown: -STEP }[event.key];
    if (by === undefined) return;
    event.preventDefault();
    setHeight(timeline.clientHeight + by);
  });
  return splitter;
}
