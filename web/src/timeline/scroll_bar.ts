/** What of the output is in view: a bar that is dragged to move along, and at its ends to zoom. */

import { make, setAttribute } from "../dom";
import { clamp, type View } from "../scale";
import type { Store } from "../store";
import { said } from "../units";
import { type Drag, draggable } from "./drag";
import type { Zoom } from "./zoom";

type Part = "from" | "to" | "both";

/** Pixels that a thumb has at least. */
const LEAST = 24;

export class ScrollBar {
  readonly root = make("div", { class: "scrollbar" });
  private readonly thumb = make("div", { class: "thumb", role: "slider", tabindex: 0, "aria-label": "Part in view" });
  private readonly ends = [make("i", { "data-end": "from" }), make("i", { "data-end": "to" })] as const;

  constructor(
    private readonly store: Store,
    private readonly zoom: Zoom,
  ) {
    const { root, thumb, ends } = this;
    thumb.append(...ends);
    root.append(thumb);
    draggable(thumb, () => this.drag("both"));
    draggable(ends[0], () => this.drag("from"));
    draggable(ends[1], () => this.drag("to"));
    root.addEventListener("pointerdown", (event) => {
      const extent = zoom.extent;
      if (event.target !== root || !extent) return;
      // Beside the thumb: it comes to where the pointer is.
      const { view, all } = extent;
      const box = root.getBoundingClientRect();
      const middle = all.from + ((event.clientX - box.left) / box.width) * (all.to - all.from);
      const half = (view.to - view.from) / 2;
      zoom.show({ from: middle - half, to: middle + half });
    });
    thumb.addEventListener("dblclick", () => zoom.fit());
    thumb.addEventListener("keydown", (event) => {
      const by = { ArrowLeft: -0.1, ArrowRight: 0.1, PageDown: 0.9, PageUp: -0.9 }[event.key];
      if (by === undefined || event.ctrlKey || event.altKey || event.metaKey) return;
      event.preventDefault();
      event.stopPropagation();
      this.move(by);
    });
  }

  update(): void {
    const { root, thumb, store } = this;
    const extent = this.zoom.extent;
    root.hidden = extent === null;
    if (!extent) return;
    const { view, all } = extent;
    const width = all.to - all.from;
    const share = Math.min(1, (view.to - view.from) / width);
    const room = root.clientWidth;
    const pixels = Math.max(share * room, Math.min(LEAST, room));
    const left = share < 1 ? ((view.from - all.from) / (width - (view.to - view.from))) * (room - pixels) : 0;
    thumb.style.width = `${pixels}px`;
    thumb.style.transform = `translateX(${clamp(left, 0, room - pixels)}px)`;
    root.dataset.all = share > 0.999 ? "yes" : "no";
    setAttribute(thumb, "aria-valuemin", "0");
    setAttribute(thumb, "aria-valuemax", "100");
    setAttribute(thumb, "aria-valuenow", ((100 * (view.from - all.from)) / width).toFixed(1));
    const words = `output ${said(store, Math.max(0, view.from))} to ${said(store, view.to)}`;
    setAttribute(thumb, "aria-valuetext", words);
  }

  private move(shares: number): void {
    const extent = this.zoom.extent;
    if (!extent) return;
    const { view, all } = extent;
    this.zoom.show(held(view, all, shares * (view.to - view.from)));
  }

  private drag(part: Part): Drag | null {
    const extent = this.zoom.extent;
    if (!extent) return null;
    const { view, all } = extent;
    const seconds = (all.to - all.from) / Math.max(this.root.clientWidth, 1);
    return {
      move: (dx) => {
        const by = dx * seconds;
        if (part === "both") this.zoom.show(held(view, all, by));
        else if (part === "from") this.zoom.show({ from: clamp(view.from + by, all.from, view.to), to: view.to });
        else this.zoom.show({ from: view.from, to: clamp(view.to + by, view.from, all.to) });
      },
      end: () => undefined,
      cancel: () => this.zoom.show(view),
    };
  }
}

/** Move a view along, inside all that there is. */
function held(view: View, all: View, by: number): View {
  const move = clamp(by, all.from - view.from, all.to - view.to);
  return { from: view.from + move, to: view.to + move };
}
