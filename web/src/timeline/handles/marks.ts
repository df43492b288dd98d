/** Markers, along the ruler and beside the input times, and the ends of the work area: dragged, or moved by the arrows. */

import { deleteItem } from "../../deleting";
import { make, setAttribute } from "../../dom";
import { changeMarker, findMarker, playedStretch, setWorkArea } from "../../markers";
import type { Document, Marker } from "../../messages";
import { clamp } from "../../scale";
import { said } from "../../units";
import { draggable } from "../drag";
import { inputTimeAt, inputY, outputTimeAt, outputX } from "../layout";
import { describe, keep, move } from "./elements";
import { type Hand, isDelete, MARGIN, take } from "./hand";

type Side = "start" | "end";

const SIDES: readonly Side[] = ["start", "end"];

export class MarkHandles {
  readonly ends: readonly HTMLElement[];
  private readonly made = new Map<string, HTMLButtonElement>();

  constructor(
    private readonly hand: Hand,
    private readonly overlay: HTMLElement,
  ) {
    this.ends = SIDES.map((side) => this.makeEnd(side));
  }

  place(): void {
    const { hand, made } = this;
    const { layout, scales, store } = hand;
    const { map, ruler } = layout;
    const { markers } = hand.document;
    keep(
      made,
      markers,
      (marker) => this.make(marker.id),
      (button) => [button],
      this.overlay,
    );
    markers.forEach((marker) => {
      const button = made.get(marker.id) as HTMLButtonElement;
      const isOutput = marker.on === "output";
      const x = isOutput ? hand.overlayX(marker.time) : MARGIN;
      const y = isOutput ? ruler.y + ruler.height - 8 : inputY(layout, scales, marker.time);
      const inView = isOutput
        ? x > MARGIN - 4 && x < map.width + MARGIN + 4
        : y > map.y - 2 && y < map.y + map.height + 2;
      move(button, x, y, inView);
      button.dataset.on = marker.on;
      const name = marker.name === "" ? "Marker" : `Marker ${marker.name}`;
      setAttribute(button, "aria-label", `${name}: ${marker.on} ${said(store, marker.time, 3)}`);
      setAttribute(button, "title", `${marker.name || "Marker"}, ${marker.on} ${said(store, marker.time)}`);
      const { selection } = store;
      setAttribute(button, "aria-pressed", String(selection?.kind === "marker" && selection.id === marker.id));
    });
    const area = store.knots ? playedStretch(hand.document, store.knots) : null;
    this.ends.forEach((handle, i) => {
      const time = area ? area[SIDES[i] as Side] : 0;
      const x = outputX(layout, scales, time) - map.x + MARGIN;
      move(handle, x, ruler.y + ruler.height - 3, area !== null && x > MARGIN - 4 && x < map.width + MARGIN + 4);
      describe(handle, time, 0, hand.outputEnd, said(store, time));
    });
  }

  /** Move a marker by some frames. */
  nudge(id: string, frames: number): void {
    const { hand } = this;
    const marker = findMarker(hand.document, id);
    if (marker) hand.nudge(id, this.put(hand.document, marker, marker.time + frames / hand.store.rate), "move marker");
  }

  private put(document: Document, marker: Marker, time: number): Document {
    const { store, outputEnd } = this.hand;
    const most = marker.on === "output" ? Math.max(outputEnd, marker.time) : store.inputEnd;
    return changeMarker(document, marker.id, { time: clamp(time, 0, most) });
  }

  private make(id: string): HTMLButtonElement {
    const { hand } = this;
    const { store } = hand;
    const button = make("button", { type: "button", class: "handle mark" });
    button.addEventListener("focus", () => store.select({ kind: "marker", id }));
    draggable(button, (down) => {
      const marker = findMarker(hand.document, id);
      if (down.button !== 0 || !marker) return null;
      button.focus({ preventScroll: true });
      const { layout, scales } = hand;
      return hand.gesture("move marker", (dx, dy, event) => {
        const time =
          marker.on === "output"
            ? outputTimeAt(layout, scales, outputX(layout, scales, marker.time) + dx)
            : inputTimeAt(layout, scales, inputY(layout, scales, marker.time) + dy);
        return this.put(hand.document, marker, hand.onFrame(time, event));
      });
    });
    button.addEventListener("dblclick", () => {
      const name = this.overlay.ownerDocument.querySelector<HTMLInputElement>(`[data-marker="${CSS.escape(id)}"]`);
      name?.focus();
      name?.select();
    });
    button.addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      const many = event.shiftKey ? 10 : 1;
      const steps: Record<string, number> = { ArrowRight: many, ArrowUp: many, ArrowLeft: -many, ArrowDown: -many };
      const by = steps[event.key];
      if (by !== undefined) this.nudge(id, by);
      else if (isDelete(event)) deleteItem(store, hand.connection, { kind: "marker", id });
      else return;
      take(event);
    });
    return button;
  }

  private makeEnd(side: Side): HTMLElement {
    const { hand } = this;
    const now = (): number => hand.document.work_area?.[side] ?? 0;
    const put = (time: number): Document | null => {
      const area = hand.document.work_area;
      if (!area) return null;
      const frame = 1 / hand.store.rate;
      const held = side === "start" ? Math.min(time, area.end - frame) : Math.max(time, area.start + frame);
      return setWorkArea(hand.document, side, clamp(held, 0, hand.outputEnd), hand.outputEnd);
    };
    const handle = hand.slider(
      "handle areaend",
      side === "start" ? "Beginning of the work area" : "End of the work area",
      () => {
        const { layout, scales } = hand;
        const start = outputX(layout, scales, now());
        return hand.gesture("set work area", (dx, _dy, event) =>
          put(hand.snapOutput(outputTimeAt(layout, scales, start + dx), event)),
        );
      },
      (by) => {
        const next = put(now() + by / hand.store.rate);
        if (next) hand.nudge("work area", next, "set work area");
      },
    );
    handle.dataset.side = side;
    return handle;
  }
}
