/** The timeline: the time map and the speed over one axis of output time, with what can be dragged on top. */

import type { Connection } from "../connection";
import { addKey, addLock, freshId } from "../document";
import { make } from "../dom";
import { markFlight } from "../flights";
import { type Axis, addMarker } from "../markers";
import type { Document } from "../messages";
import { snapped } from "../scale";
import type { Store, Topic } from "../store";
import type { Theme } from "../theme";
import { inputAt, outputEnd } from "../warp";
import { ChooseBox } from "./choose_box";
import { type Drag, draggable } from "./drag";
import { Handles } from "./handles/handles";
import { GUTTER, inputTimeAt, inside, type Layout, layoutOf, outputTimeAt, type Scales } from "./layout";
import { Legend } from "./legend";
import { paintInfluence } from "./paint_influence";
import { ReferenceChooser } from "./reference_chooser";
import { ScrollBar } from "./scroll_bar";
import { onlyMarkers, Surface } from "./surface";
import { TroubleNote } from "./trouble";
import { Zoom } from "./zoom";

export class Timeline {
  readonly root = make("div", { class: "timeline", role: "region", "aria-label": "Timeline" });
  private readonly surface: Surface;
  private readonly zoom: Zoom;
  private readonly handles: Handles;
  private readonly trouble: TroubleNote;
  private readonly legend = new Legend();
  private readonly chooser: ReferenceChooser;
  private readonly chooseBox: ChooseBox;
  private readonly scrollBar: ScrollBar;
  private readonly foot = make("div", { class: "foot" });
  private layout: Layout = layoutOf(800, 300);
  private scales: Scales = {
    output: { from: 0, to: 1 },
    input: { from: 0, to: 1 },
    speed: { from: -2, to: 2 },
    share: { from: 0, to: 1 },
  };
  constructor(
    private readonly store: Store,
    private readonly connection: Connection,
    theme: Theme,
    private readonly scrub: (outputTime: number) => void,
  ) {
    this.surface = new Surface(store, theme);
    this.zoom = new Zoom(store);
    this.handles = new Handles(store, connection);
    this.trouble = new TroubleNote(store);
    this.chooser = new ReferenceChooser(store);
    this.chooseBox = new ChooseBox(store);
    this.scrollBar = new ScrollBar(store, this.zoom);
    this.foot.append(this.legend.root, this.scrollBar.root);
    this.root.append(
      this.surface.canvas,
      this.surface.markers,
      this.foot,
      this.handles.gutter,
      this.handles.overlay,
      this.chooseBox.root,
      this.chooser.root,
      this.trouble.root,
    );
    this.listen();
  }

  /** How high the rows are that are there now and then: influence over time, and sound. */
  get rowsHeight(): number {
    return [this.layout.influence, this.layout.sound].reduce((sum, { height }) => sum + (height && height + 4), 0);
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
    // The playhead has left what is in view: all moves.
    const turned = changed.has("playhead") && !this.store.dragging && this.zoom.follow();
    if (onlyMarkers(changed) && !turned) {
      this.surface.paint(this.layout, this.scales, changed);
      return;
    }
    this.layout = layoutOf(clientWidth, clientHeight, {
      hasFeet: this.store.clip?.holds === "motion",
      hasSound: this.store.beside.peaks !== null,
      hasInfluence: this.store.view.paintsInfluence || (this.store.document?.influence.length ?? 0) > 0,
    });
    if (!this.store.dragging) this.scales = this.zoom.scales(this.scales);
    this.surface.paint(this.layout, this.scales, turned ? new Set([...changed, "view"]) : changed);
    this.handles.place(this.layout, this.scales);
    const { foot } = this.layout;
    this.foot.style.left = `${foot.x}px`;
    this.foot.style.top = `${foot.y}px`;
    this.foot.style.width = `${foot.width}px`;
    this.foot.style.height = `${foot.height}px`;
    this.legend.update(this.store);
    this.scrollBar.update();
    this.chooser.update(this.layout);
    this.trouble.update(this.layout, this.scales);
  }

  /** The output time under a pixel of the page, if the map is there and the output goes so far. */
  timeAtPixel(x: number): number | null {
    const { knots } = this.store;
    const time = outputTimeAt(this.layout, this.scales, x - this.root.getBoundingClientRect().left);
    return knots && time >= 0 && time <= outputEnd(knots) ? time : null;
  }

  /** Show all of the output again. */
  fit(): void {
    this.zoom.fit();
  }

  /** Zoom about the playhead; below 1 comes closer. */
  zoomBy(factor: number): void {
    this.zoom.by(factor, this.store.playback.outputTime);
  }

  private listen(): void {
    const { store } = this;
    const { canvas } = this.surface;
    const place = (event: MouseEvent): { x: number; y: number } => {
      const box = this.root.getBoundingClientRect();
      return { x: event.clientX - box.left, y: event.clientY - box.top };
    };
    const time = (event: MouseEvent): number => outputTimeAt(this.layout, this.scales, place(event).x);
    draggable(canvas, (down) => {
      const { x, y } = place(down);
      if (down.button === 1 || down.altKey) return this.pan();
      if (inside(this.layout.gutter, x, y) && store.document) return this.drawLock(y);
      if (inside(this.layout.feet, x, y) && this.layout.feet.height > 0 && store.knots) return this.drawFlight(x);
      if (inside(this.layout.influence, x, y) && this.layout.influence.height > 0 && store.knots)
        return paintInfluence(store, this.connection, this.layout, this.scales, { x, y });
      if (y > this.layout.heat.y + this.layout.heat.height) return null;
      if (x < GUTTER - 8) return null;
      (document.activeElement as HTMLElement | null)?.blur();
      if (inside(this.layout.map, x, y))
        return this.chooseBox.begin(down, this.layout, this.scales, { x, y }, () =>
          this.scrub(this.onFrame(time(down), down)),
        );
      store.select(null);
      this.scrub(this.onFrame(time(down), down));
      return {
        move: (_dx, _dy, event) => this.scrub(this.onFrame(time(event), event)),
        end: () => undefined,
        cancel: () => undefined,
      };
    });
    canvas.addEventListener("dblclick", (event) => {
      const { x, y } = place(event);
      if (inside(this.layout.map, x, y) || inside(this.layout.speed, x, y))
        this.addKeyAt(this.onFrame(time(event), event), true);
      if (inside(this.layout.ruler, x, y)) this.mark("output", this.onFrame(time(event), event));
    });
    this.root.addEventListener(
      "wheel",
      (event) => {
        event.preventDefault();
        const pixels = event.deltaMode === 1 ? 24 : 1;
        const across = event.shiftKey ? event.deltaY : event.deltaX;
        if (event.shiftKey || Math.abs(event.deltaX) > Math.abs(event.deltaY))
          this.zoom.pan(across * pixels, this.layout.map.width);
        else this.zoom.by(1.0022 ** (event.deltaY * pixels), time(event));
      },
      { passive: false },
    );
    this.root.addEventListener("pointermove", (event) => {
      if (store.dragging) return store.point(null);
      const { x, y } = place(event);
      const { map, heat } = this.layout;
      const end = store.knots ? outputEnd(store.knots) : 0;
      const over =
        x >= map.x && x <= map.x + map.width && y >= map.y && y <= heat.y + heat.height && time(event) <= end;
      // What is pointed at is a frame.
      store.point(over ? Math.max(0, snapped(time(event), store.rate)) : null);
      const cursor = inside(this.layout.gutter, x, y) ? "row-resize" : "default";
      const { influence } = this.layout;
      if (influence.height > 0 && inside(influence, x, y)) canvas.style.cursor = "crosshair";
      else canvas.style.cursor = inside(this.layout.feet, x, y) && this.layout.feet.height > 0 ? "col-resize" : cursor;
    });
    this.root.addEventListener("pointerleave", () => store.point(null));
  }

  private onFrame(time: number, event: MouseEvent): number {
    return this.handles.snapOutput(time, event);
  }

  /** Put a keytime on the curve, at an output time: on a frame, or just there where the hand has snapped it already. */
  addKeyAt(outputTime: number, isPlaced = false): void {
    const { store, connection } = this;
    const knots = store.knots;
    if (!knots || !store.document) return;
    const end = outputEnd(knots);
    const frame = 1 / store.rate;
    const when = store.view.snap && !isPlaced ? snapped(outputTime, store.rate) : outputTime;
    // The ends are keys already.
    if (when < frame / 2 || when > end - frame / 2) return;
    const shown = inputAt(knots, when);
    const [document, id] = addKey(store.document, store.view.snap ? snapped(shown, store.rate) : shown, when);
    if (document !== store.document) connection.edit(document, "add key");
    // The focus stays where it is: the arrows go on moving the playhead.
    store.select({ kind: "key", id });
  }

  /** Put a marker at a time of the output, or of the input. */
  mark(on: Axis, time: number): void {
    const { store, connection } = this;
    if (!store.document) return;
    const [document, id] = addMarker(store.document, on, time);
    if (document !== store.document) connection.edit(document, "add marker");
    store.select({ kind: "marker", id });
  }

  /** Move what is selected by some frames of the output, and of the input. */
  nudge(output: number, input: number): void {
    this.handles.nudge({ output, input });
  }

  private pan(): Drag {
    let last = 0;
    return {
      move: (dx) => {
        this.zoom.pan(last - dx, this.layout.map.width);
        last = dx;
      },
      end: () => undefined,
      cancel: () => undefined,
    };
  }

  /** A drag along the input times draws a lock. */
  private drawLock(startY: number): Drag {
    const timeAt = (_dx: number, dy: number): number => inputTimeAt(this.layout, this.scales, startY + dy);
    return this.drawSpan("lock", timeAt, (document, start, end) => addLock(document, start, end));
  }

  /** A drag along the feet draws a flight. */
  private drawFlight(startX: number): Drag {
    const { store } = this;
    const timeAt = (dx: number): number => store.shownInput(outputTimeAt(this.layout, this.scales, startX + dx));
    return this.drawSpan("flight", timeAt, (document, start, end) => {
      const id = freshId(document, "f");
      return [markFlight(document, { id, start, end, flies: true }), id];
    });
  }

  /** A drag draws a span of input time. */
  private drawSpan(
    kind: "lock" | "flight",
    timeAt: (dx: number, dy: number) => number,
    add: (document: Document, start: number, end: number) => [Document, string],
  ): Drag {
    const { store, connection } = this;
    const gesture = connection.newGesture();
    const before = store.document;
    const from = snapped(timeAt(0, 0), store.rate);
    const label = `add ${kind}`;
    let id: string | null = null;
    let latest = before;
    return {
      move: (dx, dy) => {
        if (!before) return;
        store.beginDrag();
        const to = snapped(timeAt(dx, dy), store.rate);
        const start = Math.max(0, Math.min(from, to));
        const end = Math.min(store.inputEnd, Math.max(from, to));
        if (end - start < 2 / store.rate) return;
        [latest, id] = add(before, start, end);
        connection.edit(latest, label, gesture, false);
      },
      end: () => {
        store.endDrag();
        if (id && latest) {
          connection.edit(latest, label, gesture, true);
          store.select({ kind, id });
        }
      },
      cancel: () => {
        store.endDrag();
        if (id && before) connection.edit(before, label, gesture, true);
      },
    };
  }
}
