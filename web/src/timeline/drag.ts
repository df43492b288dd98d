/** Dragging: a pointer that is held, and followed wherever it goes. */

export interface Drag {
  /** The pointer moved so far from where it went down; `event` is the latest. */
  move(dx: number, dy: number, event: PointerEvent): void;
  /** The pointer was let go; `moved` is false for a mere click. */
  end(moved: boolean): void;
  /** Escape was pressed: as if nothing had happened. */
  cancel(): void;
}

// A hand that clicks trembles.
const SLACK = 3;

// Told as soon as the hand moves; plain moves wait for the next frame. Safari, and pages from elsewhere, have only those.
const MOVED = "onpointerrawupdate" in window ? "pointerrawupdate" : "pointermove";

/** Begin drags on an element; `begin` returns null where there is nothing to drag. */
export function draggable(element: HTMLElement, begin: (event: PointerEvent) => Drag | null): void {
  element.addEventListener("pointerdown", (down) => {
    if (down.button > 1) return;
    const drag = begin(down);
    if (!drag) return;
    down.stopPropagation();
    element.setPointerCapture(down.pointerId);
    let moved = false;
    const over = new AbortController();
    const finish = (how: () => void): void => {
      over.abort();
      if (element.hasPointerCapture(down.pointerId)) element.releasePointerCapture(down.pointerId);
      how();
    };
    const { signal } = over;
    element.addEventListener(
      MOVED,
      (event) => {
        if (!(event instanceof PointerEvent) || event.pointerId !== down.pointerId) return;
        const dx = event.clientX - down.clientX;
        const dy = event.clientY - down.clientY;
        if (!moved && Math.hypot(dx, dy) < SLACK) return;
        moved = true;
        drag.move(dx, dy, event);
      },
      { signal },
    );
    element.addEventListener("pointerup", () => finish(() => drag.end(moved)), { signal });
    element.addEventListener("pointercancel", () => finish(() => drag.cancel()), { signal });
    window.addEventListener(
      "keydown",
      (event) => {
        if (event.key !== "Escape") return;
        event.stopPropagation();
        finish(() => drag.cancel());
      },
      { signal, capture: true },
    );
  });
}
