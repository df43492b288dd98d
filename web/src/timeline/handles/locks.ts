/** Locks, beside the input times: bands that are moved, and their ends. */

import { deleteItem } from "../../deleting";
import { changeLock, findLock } from "../../document";
import { make, setAttribute } from "../../dom";
import type { Document, LockedTime } from "../../messages";
import { clamp } from "../../scale";
import type { Store } from "../../store";
import { said, saidSpan } from "../../units";
import { draggable } from "../drag";
import { inputY } from "../layout";
import { describe, keep, move } from "./elements";
import { type Hand, isDelete, take } from "./hand";

type Side = "start" | "end";

interface Band {
  readonly band: HTMLButtonElement;
  readonly edges: Record<Side, HTMLElement>;
}

export class LockHandles {
  private readonly made = new Map<string, Band>();

  constructor(
    private readonly hand: Hand,
    private readonly gutter: HTMLElement,
  ) {}

  place(): void {
    const { hand } = this;
    const { layout, scales, store } = hand;
    const { locks } = hand.document;
    const elements = ({ band, edges }: Band): HTMLElement[] => [band, edges.start, edges.end];
    keep(this.made, locks, (lock) => this.make(lock), elements, this.gutter);
    locks.forEach((lock, i) => {
      const { band, edges } = this.made.get(lock.id) as Band;
      const top = inputY(layout, scales, lock.end) - layout.map.y;
      const bottom = inputY(layout, scales, lock.start) - layout.map.y;
      band.style.width = "8px";
      band.style.height = `${Math.max(bottom - top, 6)}px`;
      move(band, 5, top, true);
      setAttribute(band, "aria-pressed", String(store.selection?.kind === "lock" && store.selection.id === lock.id));
      band.classList.toggle("faulty", store.problem?.lock === lock.id);
      setAttribute(band, "aria-label", `Lock ${i + 1}: ${described(store, lock)}`);
      for (const side of ["start", "end"] as const) {
        const edge = edges[side];
        edge.style.width = "14px";
        move(edge, 2, side === "start" ? bottom : top, true);
        setAttribute(edge, "aria-label", `${side === "start" ? "Beginning" : "End"} of lock ${i + 1}`);
        describe(edge, lock[side], 0, store.inputEnd, said(store, lock[side]));
      }
    });
  }

  /** Move a lock by some frames of the input. */
  nudge(id: string, frames: number): void {
    const lock = findLock(this.hand.document, id);
    if (lock) this.hand.nudge(id, this.shifted(lock, frames / this.hand.store.rate), "move lock");
  }

  private shifted(lock: LockedTime, by: number, event?: PointerEvent): Document {
    const { hand } = this;
    const duration = lock.end - lock.start;
    const wanted = lock.start + by;
    // A step of the keyboard is a frame, whatever is marked near by.
    const place = event ? hand.snapInput(wanted, event) : hand.onFrame(wanted);
    const start = clamp(place, 0, hand.store.inputEnd - duration);
    return changeLock(hand.document, lock.id, { start, end: start + duration });
  }

  /** Convert pixels downward to seconds of input. */
  private seconds(dy: number): number {
    const { layout, scales } = this.hand;
    return (-dy / layout.map.height) * (scales.input.to - scales.input.from);
  }

  private make(made: LockedTime): Band {
    const { hand } = this;
    const { id } = made;
    const now = (): LockedTime => (hand.store.document && findLock(hand.store.document, id)) ?? made;
    return { band: this.makeBand(now), edges: { start: this.makeEdge(now, "start"), end: this.makeEdge(now, "end") } };
  }

  private makeBand(now: () => LockedTime): HTMLButtonElement {
    const { hand } = this;
    const { store } = hand;
    const { id } = now();
    const band = make("button", { type: "button", class: "handle band" });
    band.addEventListener("focus", () => store.select({ kind: "lock", id }));
    draggable(band, (down) => {
      if (down.button !== 0) return null;
      band.focus({ preventScroll: true });
      const lock = now();
      return hand.gesture("move lock", (_dx, dy, event) => this.shifted(lock, this.seconds(dy), event));
    });
    band.addEventListener("keydown", (event) => {
      if (event.key === "ArrowUp" || event.key === "ArrowDown") {
        this.nudge(id, (event.key === "ArrowUp" ? 1 : -1) * (event.shiftKey ? 10 : 1));
      } else if (isDelete(event)) deleteItem(store, hand.connection, { kind: "lock", id });
      else return;
      take(event);
    });
    return band;
  }

  private makeEdge(now: () => LockedTime, side: Side): HTMLElement {
    const { hand } = this;
    const { store } = hand;
    const { id } = now();
    const put = (lock: LockedTime, time: number): Document => {
      const frame = 1 / store.rate;
      const change =
        side === "start"
          ? { start: clamp(time, 0, lock.end - frame) }
          : { end: clamp(time, lock.start + frame, store.inputEnd) };
      return changeLock(hand.document, id, change);
    };
    const handle = hand.slider(
      "handle edge",
      "Lock",
      () => {
        const lock = now();
        return hand.gesture("change lock", (_dx, dy, event) =>
          put(lock, hand.snapInput(lock[side] + this.seconds(dy), event)),
        );
      },
      (by) => {
        const lock = now();
        hand.nudge(id, put(lock, lock[side] + by / store.rate), "change lock");
      },
    );
    handle.addEventListener("focus", () => store.select({ kind: "lock", id }));
    return handle;
  }
}

function described(store: Store, { start, end, slowest, fastest }: LockedTime): string {
  const speeds = `speed ${slowest.toFixed(2)} to ${fastest.toFixed(2)}`;
  return `input ${saidSpan(store, { start, end })} at ${speeds}`;
}
