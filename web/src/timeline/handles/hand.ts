/** What all handles share: where things lie, and how a drag or a key of the keyboard becomes an edit. */

import type { Connection } from "../../connection";
import type { Snap } from "../../document";
import { make } from "../../dom";
import { type Axis, markedTimes, nearestMark } from "../../markers";
import type { Document } from "../../messages";
import { snapped } from "../../scale";
import type { Store } from "../../store";
import { outputEnd, speedAt } from "../../warp";
import { type Drag, draggable } from "../drag";
import { type Layout, layoutOf, outputX, type Scales } from "../layout";

/** Pixels by which the overlay begins left of the map. */
export const MARGIN = 14;

/** Milliseconds: nudges of one handle that follow each other faster than this are one step to undo. */
const NUDGE_MS = 900;

/** Pixels within which a time snaps to a marker. */
const SNAP = 7;

export class Hand {
  layout: Layout = layoutOf(800, 300);
  scales: Scales = {
    output: { from: 0, to: 1 },
    input: { from: 0, to: 1 },
    speed: { from: -2, to: 2 },
    share: { from: 0, to: 1 },
  };
  private nudging = { id: "", gesture: "", at: 0 };

  constructor(
    readonly store: Store,
    readonly connection: Connection,
  ) {}

  /** The document; handles are there only while there is one. */
  get document(): Document {
    return this.store.document as Document;
  }

  /** Pixels from the overlay's left edge to an output time. */
  overlayX(outputTime: number): number {
    return outputX(this.layout, this.scales, outputTime) - this.layout.map.x + MARGIN;
  }

  /** Where the output ends, seconds. */
  get outputEnd(): number {
    return this.store.knots ? outputEnd(this.store.knots) : 0;
  }

  /** The speed that the curve has at an output time; 1 while there is none. */
  curveSpeed(outputTime: number): number {
    return this.store.knots ? speedAt(this.store.knots, outputTime) : 1;
  }

  /** Snap an output time to a marker near by, else to the nearest frame; Alt turns it off, or on. */
  snapOutput(time: number, event?: { readonly altKey: boolean }): number {
    const { from, to } = this.scales.output;
    const reach = (SNAP * (to - from)) / this.layout.map.width;
    return this.isSnapping(event) ? this.snapTo("output", time, reach) : time;
  }

  /** Snap an input time so. */
  snapInput(time: number, event?: { readonly altKey: boolean }): number {
    const { from, to } = this.scales.input;
    const reach = (SNAP * (to - from)) / this.layout.map.height;
    return this.isSnapping(event) ? this.snapTo("input", time, reach) : time;
  }

  /** How times snap while something is dragged. */
  snap(event?: { readonly altKey: boolean }): Snap {
    return { output: (time) => this.snapOutput(time, event), input: (time) => this.snapInput(time, event) };
  }

  private isSnapping(event?: { readonly altKey: boolean }): boolean {
    return this.store.view.snap !== (event?.altKey ?? false);
  }

  private snapTo(axis: Axis, time: number, reach: number): number {
    return nearestMark(markedTimes(this.store.document, axis), time, reach) ?? snapped(time, this.store.rate);
  }

  /** Snap a time to the nearest frame, if snapping is on; Alt turns it off, or on. */
  onFrame(time: number, event?: { readonly altKey: boolean }): number {
    return this.isSnapping(event) ? snapped(time, this.store.rate) : time;
  }

  /** A drag: every position is an edit, and all of them are one step to undo. */
  gesture(
    label: string,
    moved: (dx: number, dy: number, event: PointerEvent) => Document | null,
    clicked?: () => void,
    /** The keytime that is dragged: the stage shows its pose meanwhile. */
    key: string | null = null,
  ): Drag {
    const { store, connection } = this;
    const before = store.document;
    const gesture = connection.newGesture();
    let latest: Document | null = null;
    return {
      move: (dx, dy, event) => {
        store.beginDrag(key);
        const next = moved(dx, dy, event);
        if (next && next !== latest) {
          latest = next;
          connection.edit(next, label, gesture, false, event.timeStamp);
        }
      },
      end: (didMove) => {
        if (didMove && latest) connection.edit(latest, label, gesture, true);
        else clicked?.();
        store.endDrag();
      },
      cancel: () => {
        if (latest && before) connection.edit(before, label, gesture, true);
        store.endDrag();
      },
    };
  }

  /** An edit by the keyboard; quick ones in a row, of the same `id`, are one step to undo. */
  nudge(id: string, document: Document, label: string): void {
    const now = performance.now();
    const goesOn = this.nudging.id === id && now - this.nudging.at < NUDGE_MS;
    const gesture = goesOn ? this.nudging.gesture : this.connection.newGesture();
    this.nudging = { id, gesture, at: now };
    this.connection.edit(document, label, gesture, true, now);
  }

  /** A handle that a screen reader takes for a slider: arrows move it by one, page keys and shift by ten. */
  slider(
    className: string,
    label: string,
    begin: (event: PointerEvent) => Drag | null,
    nudge: (by: number) => void,
  ): HTMLElement {
    const handle = make("div", { class: className, role: "slider", tabindex: 0, "aria-label": label });
    draggable(handle, (down) => {
      if (down.button !== 0) return null;
      handle.focus({ preventScroll: true });
      return begin(down);
    });
    handle.addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      const many = event.shiftKey ? 10 : 1;
      const steps: Record<string, number> = {
        ArrowRight: many,
        ArrowUp: many,
        ArrowLeft: -many,
        ArrowDown: -many,
        PageUp: 10,
        PageDown: -10,
      };
      const by = steps[event.key];
      if (by === undefined) return;
      take(event);
      nudge(by);
    });
    return handle;
  }
}

/** Say that a handle has dealt with an event, so that nothing else does. */
export function take(event: Event): void {
  event.preventDefault();
  event.stopPropagation();
}

/** Give the editor the focus, not the handle, when a handle is pressed: the arrows stay the playhead's. */
export function keepFocus(handle: HTMLElement): void {
  handle.addEventListener("mousedown", (event) => {
    if (document.activeElement === handle) return;
    event.preventDefault();
    handle.closest<HTMLElement>(".retime")?.focus({ preventScroll: true });
  });
}

export function isDelete(event: KeyboardEvent): boolean {
  return event.key === "Delete" || event.key === "Backspace";
}
