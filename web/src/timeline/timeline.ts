/** The timeline: the time map and the speed over one axis of output time, with what can be dragged on top. */

import { addKey, addLock } from "../document";
import { make, setText } from "../dom";
import { panned, snapped, type View, within, zoomed } from "../scale";
import type { Session } from "../session";
import type { Selection, Store, Topic } from "../store";
import type { Theme } from "../theme";
import { inputAt, outputEnd, slopes, speedAt } from "../warp";
import { draggable } from "./drag";
import { Handles } from "./handles";
import {
  GUTTER,
  inputTimeAt,
  inputView,
  inputY,
  inside,
  type Layout,
  layoutOf,
  outputTimeAt,
  outputX,
  type Scales,
  speedView,
  wholeOutput,
} from "./layout";
import { Painter } from "./paint";
import { referenceNames } from "./reference_span";

export class Timeline {
  readonly root = make("div", { class: "timeline", role: "region", "aria-label": "Timeline" });
  private readonly canvas = make("canvas", {
    role: "img",
    "aria-label":
      "Time map, speed, scores and reference. Click to move the playhead, double-click the map to add a keytime.",
  });
  private readonly handles: Handles;
  private readonly trouble = make("div", { class: "trouble", role: "alert", hidden: true });
  private readonly legend: HTMLElement;
  /** Of several references: which one is shown, and ranged. */
  private readonly chooser = make("select", { class: "field chooser", "aria-label": "Reference shown", hidden: true });
  private chosen = "";
  private layout: Layout = layoutOf(800, 300);
  private scales: Scales = { output: { from: 0, to: 1 }, input: { from: 0, to: 1 }, speed: { from: -2, to: 2 } };
  /** What of the output is in view; none: all of it, whatever its length. */
  private zoom: View | null = null;
  private shown: readonly [number, number, number] = [0, 0, 0];
  /** What stays while a curve changes, and what it was painted of: text and many small marks take milliseconds. */
  private readonly backdrop = document.createElement("canvas");
  private backdropOf: readonly unknown[] = [];

  constructor(
    private readonly store: Store,
    private readonly session: Session,
    private readonly theme: Theme,
    private readonly scrub: (outputTime: number) => void,
  ) {
    this.handles = new Handles(store, session, (selection) => this.choose(selection));
    this.legend = make(
      "div",
      { class: "tools", "aria-hidden": true },
      swatch("output", "", "Guided"),
      swatch("spline", "dotted", "Spline"),
      swatch("muted", "dashed", "Linear"),
      swatch("reference", "", "In the air"),
    );
    this.chooser.addEventListener("change", () => store.look({ reference: Number(this.chooser.value) }));
    this.root.append(this.canvas, this.legend, this.handles.gutter, this.handles.overlay, this.chooser, this.trouble);
    this.listen();
  }

  update(changed: Set<Topic>): void {
    if (changed.size === 0) return;
    const { clientWidth, clientHeight } = this.root;
    if (clientWidth === 0) return;
    if (this.store.dragging && [...changed].every((topic) => topic === "document" || topic === "status")) {
      // The handle goes with the hand at once; what is painted changes with the curve that answers.
      this.handles.place(this.layout, this.scales);
      return;
    }
    const scale = devicePixelRatio;
    this.layout = layoutOf(clientWidth, clientHeight);
    this.rescale();
    if (this.shown[0] !== clientWidth || this.shown[1] !== clientHeight || this.shown[2] !== scale) {
      this.canvas.width = Math.round(clientWidth * scale);
      this.canvas.height = Math.round(clientHeight * scale);
      this.shown = [clientWidth, clientHeight, scale];
    }
    // Without transparency: what lies behind it need not be drawn.
    const pen = this.canvas.getContext("2d", { alpha: false });
    if (!pen) return;
    this.paintBackdrop(scale, changed);
    pen.setTransform(1, 0, 0, 1, 0, 0);
    pen.globalCompositeOperation = "copy";
    pen.drawImage(this.backdrop, 0, 0);
    pen.globalCompositeOperation = "source-over";
    pen.setTransform(scale, 0, 0, scale, 0, 0);
    new Painter(pen, this.layout, this.scales, this.store, this.theme.palette).foreground();
    this.handles.place(this.layout, this.scales);
    this.tangentLine(pen);
    const { map } = this.layout;
    this.legend.style.left = `${map.x + 8}px`;
    this.legend.style.top = `${map.y + 5}px`;
    this.showChooser();
    this.tell();
  }

  private showChooser(): void {
    const { store, chooser } = this;
    const { reference } = this.layout;
    const names = referenceNames(store);
    const now = JSON.stringify([names, store.reference, reference]);
    if (now === this.chosen) return;
    this.chosen = now;
    chooser.hidden = names.length < 2;
    chooser.replaceChildren(...names.map((name, i) => make("option", { value: i }, name)));
    chooser.value = String(store.reference);
    chooser.title = `Reference shown: ${names[store.reference] ?? ""}`;
    chooser.style.top = `${reference.y + (reference.height - 24) / 2}px`;
    chooser.style.width = `${reference.x - 14}px`;
  }

  private paintBackdrop(scale: number, changed: Set<Topic>): void {
    const { store, theme } = this;
    const { width, height } = this.canvas;
    const end = store.knots ? outputEnd(store.knots) : null;
    const references = store.document?.references;
    const of = [width, height, scale, this.scales, theme.palette, store.why, end, references, store.reference];
    if (!changed.has("clips") && of.every((part, i) => part === this.backdropOf[i])) return;
    this.backdropOf = of;
    const { backdrop } = this;
    if (backdrop.width !== width || backdrop.height !== height) {
      backdrop.width = width;
      backdrop.height = height;
    }
    const pen = backdrop.getContext("2d", { alpha: false });
    if (!pen) return;
    pen.setTransform(scale, 0, 0, scale, 0, 0);
    new Painter(pen, this.layout, this.scales, store, theme.palette).backdrop();
  }

  /** Show all of the output again. */
  fit(): void {
    this.zoom = null;
    this.store.touch("view");
  }

  zoomBy(factor: number): void {
    const about = this.store.playback.outputTime;
    this.zoomAbout(factor, about);
  }

  private zoomAbout(factor: number, about: number): void {
    const end = this.store.knots ? outputEnd(this.store.knots) : 1;
    const { home, whole } = wholeOutput(end, this.store.inputEnd);
    this.zoom = zoomed(this.zoom ?? home, whole, factor, about, 6 / this.store.rate);
    this.store.touch("view");
  }

  private rescale(): void {
    const { store } = this;
    const knots = store.knots;
    if (!knots || store.dragging) return;
    const { home, whole } = wholeOutput(outputEnd(knots), store.inputEnd);
    const output = this.zoom ? within(this.zoom, whole) : home;
    const speed = speedView(store.curve ? slopes(knots) : []);
    let input = inputView(0, store.inputEnd, store.inputEnd);
    if (this.zoom) {
      const times = [inputAt(knots, output.from), inputAt(knots, output.to)];
      for (const key of store.document?.keys ?? []) {
        if (key.output_time >= output.from && key.output_time <= output.to) times.push(key.input_time);
      }
      input = inputView(Math.min(...times), Math.max(...times), store.inputEnd);
    }
    const same = (a: View, b: View): boolean => a.from === b.from && a.to === b.to;
    const { scales } = this;
    if (same(scales.output, output) && same(scales.input, input) && same(scales.speed, speed)) return;
    this.scales = { output, input, speed };
  }

  private choose(selection: Selection): void {
    this.store.select(selection);
  }

  private listen(): void {
    const { canvas, store } = this;
    const place = (event: MouseEvent): { x: number; y: number } => {
      const box = this.root.getBoundingClientRect();
      return { x: event.clientX - box.left, y: event.clientY - box.top };
    };
    const time = (event: MouseEvent): number => outputTimeAt(this.layout, this.scales, place(event).x);
    draggable(canvas, (down) => {
      const { x, y } = place(down);
      if (down.button === 1 || down.altKey) return this.pan();
      if (inside(this.layout.gutter, x, y) && store.document) return this.drawLock(y);
      if (y > this.layout.heat.y + this.layout.heat.height) return null;
      if (x < GUTTER - 8) return null;
      this.choose(null);
      (document.activeElement as HTMLElement | null)?.blur();
      this.scrub(this.onFrame(time(down), down));
      return {
        move: (_dx, _dy, event) => this.scrub(this.onFrame(time(event), event)),
        end: () => undefined,
        cancel: () => undefined,
      };
    });
    canvas.addEventListener("dblclick", (event) => {
      const { x, y } = place(event);
      if (inside(this.layout.map, x, y) || inside(this.layout.speed, x, y)) this.addKeyAt(time(event));
    });
    this.root.addEventListener(
      "wheel",
      (event) => {
        event.preventDefault();
        const pixels = event.deltaMode === 1 ? 24 : 1;
        const across = event.shiftKey ? event.deltaY : event.deltaX;
        if (event.shiftKey || Math.abs(event.deltaX) > Math.abs(event.deltaY)) this.panBy(across * pixels);
        else this.zoomAbout(1.0022 ** (event.deltaY * pixels), time(event));
      },
      { passive: false },
    );
    this.root.addEventListener("pointermove", (event) => {
      if (store.dragging) return this.look(null);
      const { x, y } = place(event);
      const { map, heat } = this.layout;
      const end = store.knots ? outputEnd(store.knots) : 0;
      const over =
        x >= map.x && x <= map.x + map.width && y >= map.y && y <= heat.y + heat.height && time(event) <= end;
      this.look(over ? Math.max(0, time(event)) : null);
      canvas.style.cursor = inside(this.layout.gutter, x, y) ? "row-resize" : "default";
    });
    this.root.addEventListener("pointerleave", () => this.look(null));
  }

  private look(hover: number | null): void {
    if (hover === this.store.hover) return;
    this.store.hover = hover;
    this.store.touch("hover");
  }

  private onFrame(time: number, event: MouseEvent): number {
    return this.store.view.snap !== event.altKey ? snapped(time, this.store.rate) : time;
  }

  /** Put a keytime on the curve, at an output time. */
  addKeyAt(outputTime: number): void {
    const { store, session } = this;
    const knots = store.knots;
    if (!knots || !store.document) return;
    const end = outputEnd(knots);
    const frame = 1 / store.rate;
    const when = store.view.snap ? snapped(outputTime, store.rate) : outputTime;
    // The ends are keys already.
    if (when < frame / 2 || when > end - frame / 2) return;
    const shown = inputAt(knots, when);
    const [document, id] = addKey(store.document, store.view.snap ? snapped(shown, store.rate) : shown, when);
    if (document !== store.document) session.edit(document, "add key");
    this.choose({ kind: "key", id });
    requestAnimationFrame(() => this.handles.focusKey(id));
  }

  private panBy(pixels: number): void {
    if (!this.store.knots) return;
    const { home, whole } = wholeOutput(outputEnd(this.store.knots), this.store.inputEnd);
    const view = this.zoom ?? home;
    this.zoom = panned(view, whole, (pixels / this.layout.map.width) * (view.to - view.from));
    this.store.touch("view");
  }

  private pan(): { move(dx: number): void; end(): void; cancel(): void } {
    let last = 0;
    return {
      move: (dx) => {
        this.panBy(last - dx);
        last = dx;
      },
      end: () => undefined,
      cancel: () => undefined,
    };
  }

  /** A drag along the input times draws a lock. */
  private drawLock(startY: number): { move(dx: number, dy: number): void; end(moved: boolean): void; cancel(): void } {
    const { store, session } = this;
    const gesture = session.newGesture();
    const before = store.document;
    const from = snapped(inputTimeAt(this.layout, this.scales, startY), store.rate);
    let id: string | null = null;
    let latest = before;
    return {
      move: (_dx, dy) => {
        if (!before) return;
        store.dragging = true;
        const to = snapped(inputTimeAt(this.layout, this.scales, startY + dy), store.rate);
        const start = Math.max(0, Math.min(from, to));
        const end = Math.min(store.inputEnd, Math.max(from, to));
        if (end - start < 2 / store.rate) return;
        [latest, id] = addLock(before, start, end);
        session.edit(latest, "add lock", gesture, false);
      },
      end: () => {
        store.dragging = false;
        if (id && latest) {
          session.edit(latest, "add lock", gesture, true);
          this.choose({ kind: "lock", id });
        }
      },
      cancel: () => {
        store.dragging = false;
        if (id && before) session.edit(before, "add lock", gesture, true);
      },
    };
  }

  private tangentLine(pen: CanvasRenderingContext2D): void {
    const { store, layout, scales } = this;
    if (store.selection?.kind !== "key" || !store.document || !store.curve) return;
    const { id } = store.selection;
    const key = store.document.keys.find((one) => one.id === id);
    if (!key) return;
    const knots = store.knots;
    const shown = key.speed ?? (knots ? speedAt(knots, key.output_time) : 1);
    const [dx, dy] = this.handles.tangentArm(shown);
    const x = outputX(layout, scales, key.output_time);
    const y = inputY(layout, scales, key.input_time);
    pen.save();
    pen.beginPath();
    pen.rect(layout.map.x, layout.map.y, layout.map.width, layout.map.height);
    pen.clip();
    pen.strokeStyle = this.theme.palette.output;
    pen.globalAlpha = key.speed === null ? 0.45 : 1;
    pen.lineWidth = 1.3;
    if (key.speed === null) pen.setLineDash([3, 3]);
    pen.beginPath();
    pen.moveTo(x - dx, y - dy);
    pen.lineTo(x + dx, y + dy);
    pen.stroke();
    pen.restore();
  }

  /** Words about what can't be done, beside the key or lock at fault. */
  private tell(): void {
    const { store, trouble, layout, scales } = this;
    const { problem } = store;
    // Without a clip there is nothing to point at; what lies over all of it says it.
    trouble.hidden = problem === null || store.clip === null;
    if (!problem || trouble.hidden) return;
    setText(trouble, problem.message);
    const key = store.document?.keys.find((one) => one.id === problem.key);
    const lock = store.document?.locks.find((one) => one.id === problem.lock);
    const x = key ? outputX(layout, scales, key.output_time) : layout.map.x + 6;
    const y = key
      ? inputY(layout, scales, key.input_time)
      : lock
        ? inputY(layout, scales, (lock.start + lock.end) / 2)
        : problem.reference !== null
          ? layout.reference.y
          : layout.map.y + 26;
    const { offsetWidth, offsetHeight } = trouble;
    const right = x + 18 + offsetWidth < layout.width - 8;
    trouble.style.left = `${Math.max(8, right ? x + 18 : x - 18 - offsetWidth)}px`;
    trouble.style.top = `${Math.min(Math.max(layout.map.y + 4, y - offsetHeight / 2), layout.height - offsetHeight - 6)}px`;
  }
}

function swatch(color: string, dash: string, text: string): HTMLElement {
  const line = make("i", { class: dash });
  line.style.color = `var(--${color})`;
  if (color === "reference") {
    line.style.borderTopWidth = "8px";
    line.style.opacity = "0.3";
  }
  return make("span", { class: "swatch" }, line, text);
}
