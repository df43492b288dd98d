/** What of the timeline can be taken hold of: keytimes, their speeds, the end, locks, and the reference's range. */

import {
  changeKey,
  changeLock,
  deleteKey,
  deleteLock,
  findKey,
  keyPlace,
  keysInOrder,
  lengthInFrames,
  setLength,
} from "../document";
import { make, setAttribute } from "../dom";
import type { Document, Key, LockedTime } from "../messages";
import { setReferenceRange } from "../references";
import { clamp, snapped, toPixels, toValue } from "../scale";
import type { Session } from "../session";
import type { Selection, Store } from "../store";
import { outputEnd, speedAt } from "../warp";
import { type Drag, draggable } from "./drag";
import { inputTimeAt, inputY, type Layout, outputTimeAt, outputX, type Scales, speedAtY, speedY } from "./layout";
import { frameRange, referenceSpan } from "./reference_span";

const TANGENT = 46;
const SLOWEST = 1 / 24;
const FASTEST = 10;

/** Nudges of one key that follow each other quickly are one undo step. */
const NUDGE_MS = 900;

export class Handles {
  /** Over the map, the speed and the reference; and over the gutter, for locks. */
  readonly overlay = make("div", {
    class: "overlay",
    role: "group",
    "aria-label": "Keytimes, speeds and reference range",
  });
  readonly gutter = make("div", { class: "overlay", role: "group", "aria-label": "Locks" });
  private readonly keys = new Map<string, HTMLButtonElement>();
  private readonly speeds = new Map<string, HTMLElement>();
  private readonly locks = new Map<string, { band: HTMLButtonElement; edges: [HTMLElement, HTMLElement] }>();
  private readonly end: HTMLElement;
  private readonly tangents: [HTMLElement, HTMLElement];
  private readonly range: [HTMLElement, HTMLElement];
  private layout!: Layout;
  private scales!: Scales;
  private nudging = { id: "", gesture: "", at: 0 };

  constructor(
    private readonly store: Store,
    private readonly session: Session,
    private readonly changeOf: (selection: Selection) => void,
  ) {
    this.end = this.slider(
      "handle key end",
      "End of the output",
      (event) => this.dragEnd(event),
      (by) => this.nudgeEnd(by),
    );
    this.end.addEventListener("focus", () => this.changeOf({ kind: "end" }));
    this.tangents = [this.makeTangent(-1), this.makeTangent(1)];
    this.range = [this.makeRange(0), this.makeRange(1)];
    this.overlay.append(...this.tangents, this.end, ...this.range);
  }

  /** Put everything where it belongs. */
  place(layout: Layout, scales: Scales): void {
    this.layout = layout;
    this.scales = scales;
    const document = this.store.document;
    if (!document) return;
    const { map, reference } = layout;
    const box = this.overlay.style;
    // Wider than the map by half a handle: keys at its edges keep their shape.
    box.left = `${map.x - 14}px`;
    box.width = `${map.width + 24}px`;
    box.top = "0";
    box.height = `${layout.height}px`;
    this.gutter.style.left = `${map.x - 16}px`;
    this.gutter.style.width = "16px";
    this.gutter.style.top = `${map.y}px`;
    this.gutter.style.height = `${map.height}px`;
    const knots = this.store.knots;
    const { selection } = this.store;

    const ordered = keysInOrder(document);
    keep(this.keys, ordered, (key) => this.makeKey(key), this.overlay);
    keep(this.speeds, ordered, (key) => this.makeSpeed(key), this.overlay);
    ordered.forEach((key, i) => {
      const chosen = selection?.kind === "key" && selection.id === key.id;
      const x = outputX(layout, scales, key.output_time) - map.x + 14;
      const inView = x > 4 && x < map.width + 22;
      const button = this.keys.get(key.id) as HTMLButtonElement;
      const y = inputY(layout, scales, key.input_time);
      move(button, x, clamp(y, map.y, map.y + map.height), inView && y > map.y - 8 && y < map.y + map.height + 8);
      const tangent = key.speed === null ? "" : `, speed ${key.speed.toFixed(2)}`;
      setAttribute(
        button,
        "aria-label",
        `Keytime ${i + 1} of ${ordered.length}: input ${key.input_time.toFixed(3)} s at output ${key.output_time.toFixed(3)} s${tangent}`,
      );
      setAttribute(button, "aria-pressed", String(chosen));
      button.classList.toggle("faulty", this.store.problem?.key === key.id);
      const handle = this.speeds.get(key.id) as HTMLElement;
      const shown = key.speed ?? (knots ? speedAt(knots, key.output_time) : 1);
      move(handle, x, speedY(layout, scales, shown), inView);
      handle.classList.toggle("set", key.speed !== null);
      handle.classList.toggle("selected", chosen);
      setAttribute(handle, "aria-label", `Speed at keytime ${i + 1}`);
      describe(handle, shown, SLOWEST, FASTEST, `${shown.toFixed(2)} times${key.speed === null ? ", free" : ", set"}`);
    });

    const last = knots ? outputEnd(knots) : 0;
    const endX = outputX(layout, scales, last) - map.x + 14;
    const endY = inputY(layout, scales, this.store.inputEnd);
    // The end of a length that the search chooses is not one's own to drag; it becomes given where it is dragged.
    move(this.end, endX, clamp(endY, map.y, map.y + map.height), knots !== null && endX > 4 && endX < map.width + 23);
    describe(this.end, last, 0, 10 * Math.max(last, 1), `${last.toFixed(3)} s`);
    this.end.classList.toggle("selected", selection?.kind === "end");

    const chosen = selection?.kind === "key" ? findKey(document, selection.id) : null;
    this.tangents.forEach((handle, side) => {
      const shownSpeed = chosen ? (chosen.speed ?? (knots ? speedAt(knots, chosen.output_time) : 1)) : 1;
      const [dx, dy] = chosen ? this.tangentArm(shownSpeed) : [0, 0];
      const sign = side === 0 ? -1 : 1;
      const x = chosen ? outputX(layout, scales, chosen.output_time) - map.x + 14 : 0;
      const y = chosen ? inputY(layout, scales, chosen.input_time) : 0;
      const [tipX, tipY] = [x + sign * dx, y + sign * dy];
      const inMap = tipX > 12 && tipX < map.width + 16 && tipY > map.y && tipY < map.y + map.height;
      move(handle, tipX, tipY, chosen !== null && inMap);
      describe(handle, shownSpeed, SLOWEST, FASTEST, `${shownSpeed.toFixed(2)} times`);
    });

    const span = referenceSpan(this.store);
    this.range.forEach((handle, side) => {
      const time = span ? (side === 0 ? span.start : span.end) : 0;
      const x = span ? toPixels({ from: 0, to: span.lastTime }, reference.width, time) + 14 : 0;
      handle.style.height = `${reference.height}px`;
      move(handle, x, reference.y, span !== null);
      describe(handle, time, 0, span?.lastTime ?? 0, `${time.toFixed(2)} s`);
    });

    const lockItems = [...document.locks];
    for (const [id, parts] of this.locks) {
      if (lockItems.some((lock) => lock.id === id)) continue;
      parts.band.remove();
      for (const edge of parts.edges) edge.remove();
      this.locks.delete(id);
    }
    lockItems.forEach((lock, i) => {
      let parts = this.locks.get(lock.id);
      if (!parts) {
        parts = this.makeLock(lock);
        this.locks.set(lock.id, parts);
        this.gutter.append(parts.band, ...parts.edges);
      }
      const top = inputY(layout, scales, lock.end) - map.y;
      const bottom = inputY(layout, scales, lock.start) - map.y;
      parts.band.style.width = "8px";
      parts.band.style.height = `${Math.max(bottom - top, 6)}px`;
      move(parts.band, 5, top, true);
      setAttribute(parts.band, "aria-pressed", String(selection?.kind === "lock" && selection.id === lock.id));
      parts.band.classList.toggle("faulty", this.store.problem?.lock === lock.id);
      setAttribute(
        parts.band,
        "aria-label",
        `Lock ${i + 1}: input ${lock.start.toFixed(2)} to ${lock.end.toFixed(2)} s at speed ${lock.slowest.toFixed(2)} to ${lock.fastest.toFixed(2)}`,
      );
      parts.edges.forEach((edge, side) => {
        edge.style.width = "14px";
        move(edge, 2, side === 0 ? bottom : top, true);
        const time = side === 0 ? lock.start : lock.end;
        setAttribute(edge, "aria-label", `${side === 0 ? "Beginning" : "End"} of lock ${i + 1}`);
        describe(edge, time, 0, this.store.inputEnd, `${time.toFixed(2)} s`);
      });
    });
  }

  focusKey(id: string): void {
    this.keys.get(id)?.focus({ preventScroll: true });
  }

  /** Line from a key to its tangent handles, in pixels to the right and downward. */
  tangentArm(speed: number): [number, number] {
    const { layout, scales } = this;
    const dx = layout.map.width / (scales.output.to - scales.output.from);
    const dy = (-speed * layout.map.height) / (scales.input.to - scales.input.from);
    const length = Math.hypot(dx, dy);
    return [(TANGENT * dx) / length, (TANGENT * dy) / length];
  }

  /** A drag whose every position is one edit of a gesture. */
  private gesture(
    label: string,
    moved: (dx: number, dy: number, event: PointerEvent) => Document | null,
    clicked?: () => void,
  ): Drag {
    const { store, session } = this;
    const before = store.document;
    const gesture = session.newGesture();
    let latest: Document | null = null;
    return {
      move: (dx, dy, event) => {
        store.dragging = true;
        const next = moved(dx, dy, event);
        if (next && next !== latest) {
          latest = next;
          session.edit(next, label, gesture, false, event.timeStamp);
        }
      },
      end: (didMove) => {
        store.dragging = false;
        if (didMove && latest) session.edit(latest, label, gesture, true);
        else clicked?.();
        store.touch("view");
      },
      cancel: () => {
        store.dragging = false;
        if (latest && before) session.edit(before, label, gesture, true);
        store.touch("view");
      },
    };
  }

  /** An edit by the keyboard; quick ones in a row are one undo step. */
  private nudge(id: string, document: Document, label: string): void {
    const now = performance.now();
    const goesOn = this.nudging.id === id && now - this.nudging.at < NUDGE_MS;
    const gesture = goesOn ? this.nudging.gesture : this.session.newGesture();
    this.nudging = { id, gesture, at: now };
    this.session.edit(document, label, gesture, true, now);
  }

  private room(): { inputEnd: number; rate: number; outputEnd: number } {
    const knots = this.store.knots;
    return { inputEnd: this.store.inputEnd, rate: this.store.rate, outputEnd: knots ? outputEnd(knots) : 0 };
  }

  private makeKey(made: Key): HTMLButtonElement {
    const { store, session } = this;
    const button = make("button", { type: "button", class: "handle key" });
    const { id } = made;
    button.addEventListener("focus", () => this.changeOf({ kind: "key", id }));
    draggable(button, (down) => {
      const key = store.document && findKey(store.document, id);
      if (!key || down.button !== 0) return null;
      button.focus({ preventScroll: true });
      const room = this.room();
      const grab = {
        x: outputX(this.layout, this.scales, key.output_time),
        y: inputY(this.layout, this.scales, key.input_time),
      };
      return this.gesture("move key", (dx, dy, event) => {
        // With shift along one axis only: a key's pose or its time, not both.
        const straight = event.shiftKey ? (Math.abs(dx) > Math.abs(dy) ? "time" : "pose") : null;
        const wanted = {
          outputTime: straight === "pose" ? key.output_time : outputTimeAt(this.layout, this.scales, grab.x + dx),
          inputTime: straight === "time" ? key.input_time : inputTimeAt(this.layout, this.scales, grab.y + dy),
        };
        const document = store.document as Document;
        const place = keyPlace(document, id, wanted, room, store.view.snap !== event.altKey);
        return changeKey(document, id, place);
      });
    });
    button.addEventListener("keydown", (event) => {
      const key = store.document && findKey(store.document, id);
      if (!key || event.ctrlKey || event.metaKey || event.altKey) return;
      const by = (event.shiftKey ? 10 : 1) / store.rate;
      const wanted = { outputTime: key.output_time, inputTime: key.input_time };
      if (event.key === "ArrowLeft") wanted.outputTime -= by;
      else if (event.key === "ArrowRight") wanted.outputTime += by;
      else if (event.key === "ArrowUp") wanted.inputTime += by;
      else if (event.key === "ArrowDown") wanted.inputTime -= by;
      else if (event.key === "Delete" || event.key === "Backspace") {
        event.preventDefault();
        event.stopPropagation();
        this.changeOf(null);
        session.edit(deleteKey(store.document as Document, id), "delete key");
        return;
      } else return;
      event.preventDefault();
      event.stopPropagation();
      const place = keyPlace(store.document as Document, id, wanted, this.room(), store.view.snap);
      this.nudge(id, changeKey(store.document as Document, id, place), "move key");
    });
    return button;
  }

  private makeSpeed(made: Key): HTMLElement {
    const { store } = this;
    const { id } = made;
    const shown = (): number => {
      const key = store.document && findKey(store.document, id);
      return key?.speed ?? (store.knots && key ? speedAt(store.knots, key.output_time) : 1);
    };
    const handle = this.slider(
      "handle speed",
      "Speed",
      () => {
        const start = speedY(this.layout, this.scales, shown());
        return this.gesture("set speed at key", (_dx, dy) =>
          changeKey(store.document as Document, id, {
            speed: roundSpeed(speedAtY(this.layout, this.scales, start + dy)),
          }),
        );
      },
      (by) => {
        const speed = roundSpeed(shown() * 2 ** (by / 8));
        this.nudge(`${id} speed`, changeKey(store.document as Document, id, { speed }), "set speed at key");
      },
    );
    handle.addEventListener("focus", () => this.changeOf({ kind: "key", id }));
    const free = (): void => {
      const key = store.document && findKey(store.document, id);
      if (key && key.speed !== null) {
        this.session.edit(changeKey(store.document as Document, id, { speed: null }), "free speed at key");
      }
    };
    handle.addEventListener("dblclick", free);
    handle.addEventListener("keydown", (event) => {
      if (event.key !== "Delete" && event.key !== "Backspace") return;
      event.preventDefault();
      event.stopPropagation();
      free();
    });
    return handle;
  }

  /** A handle at the end of the line through the chosen key, whose slope is the speed there. */
  private makeTangent(side: -1 | 1): HTMLElement {
    const { store } = this;
    const chosen = (): Key | null =>
      store.selection?.kind === "key" && store.document ? findKey(store.document, store.selection.id) : null;
    const set = (id: string, speed: number): Document =>
      changeKey(store.document as Document, id, { speed: roundSpeed(speed) });
    return this.slider(
      "handle tangent",
      side < 0 ? "Tangent before the keytime" : "Tangent after the keytime",
      () => {
        const key = chosen();
        if (!key) return null;
        const [armX, armY] = this.tangentArm(key.speed ?? (store.knots ? speedAt(store.knots, key.output_time) : 1));
        return this.gesture("set speed at key", (dx, dy) => {
          const { map } = this.layout;
          const { output, input } = this.scales;
          // Behind the key there is no slope: the arm stays on its side.
          const x = Math.max(side * (side * armX + dx), 1);
          const y = side * (side * armY + dy);
          const speed = ((-y / map.height) * (input.to - input.from)) / ((x / map.width) * (output.to - output.from));
          return set(key.id, Math.max(speed, SLOWEST));
        });
      },
      (by) => {
        const key = chosen();
        if (!key) return;
        const speed = key.speed ?? (store.knots ? speedAt(store.knots, key.output_time) : 1);
        this.nudge(`${key.id} speed`, set(key.id, speed * 2 ** (by / 8)), "set speed at key");
      },
    );
  }

  private dragEnd(down: PointerEvent): Drag | null {
    const { store } = this;
    if (!store.knots || down.button !== 0) return null;
    const start = outputEnd(store.knots);
    return this.gesture("set length", (dx) => {
      const seconds = (dx / this.layout.map.width) * (this.scales.output.to - this.scales.output.from);
      return setLength(store.document as Document, lengthInFrames(start + seconds, store.rate));
    });
  }

  private nudgeEnd(by: number): void {
    const { store } = this;
    if (!store.knots) return;
    const length = lengthInFrames(outputEnd(store.knots) + by / store.rate, store.rate);
    this.nudge("end", setLength(store.document as Document, length), "set length");
  }

  private makeRange(side: 0 | 1): HTMLElement {
    const { store } = this;
    const change = (time: number): Document | null => {
      const span = referenceSpan(store);
      if (!span || !store.document) return null;
      // A third of a second at least: less is no motion to imitate.
      const least = Math.min(1 / 3, span.lastTime);
      const start = side === 0 ? clamp(time, 0, span.end - least) : span.start;
      const end = side === 1 ? clamp(time, span.start + least, span.lastTime) : span.end;
      return setReferenceRange(store.document, Math.max(span.source, 0), frameRange(span, start, end));
    };
    return this.slider(
      "handle span",
      side === 0 ? "First frame of the reference that is imitated" : "Last frame of the reference that is imitated",
      () => {
        const span = referenceSpan(store);
        if (!span) return null;
        const whole = { from: 0, to: span.lastTime };
        const start = toPixels(whole, this.layout.reference.width, side === 0 ? span.start : span.end);
        return this.gesture("choose reference range", (dx) =>
          change(toValue(whole, this.layout.reference.width, start + dx)),
        );
      },
      (by) => {
        const span = referenceSpan(store);
        if (!span) return;
        const next = change((side === 0 ? span.start : span.end) + by / span.clip.rate);
        if (next) this.nudge("reference", next, "choose reference range");
      },
    );
  }

  private makeLock(made: LockedTime): { band: HTMLButtonElement; edges: [HTMLElement, HTMLElement] } {
    const { store, session } = this;
    const { id } = made;
    const now = (): LockedTime => store.document?.locks.find((lock) => lock.id === id) ?? made;
    const onFrame = (time: number, event?: PointerEvent): number =>
      store.view.snap !== (event?.altKey ?? false) ? snapped(time, store.rate) : time;
    const seconds = (dy: number): number =>
      (-dy / this.layout.map.height) * (this.scales.input.to - this.scales.input.from);
    const choose = (): void => this.changeOf({ kind: "lock", id });
    const shifted = (lock: LockedTime, by: number, event?: PointerEvent): Document => {
      const start = clamp(onFrame(lock.start + by, event), 0, store.inputEnd - (lock.end - lock.start));
      return changeLock(store.document as Document, id, { start, end: start + lock.end - lock.start });
    };
    const band = make("button", { type: "button", class: "handle band" });
    band.addEventListener("focus", choose);
    draggable(band, (down) => {
      if (down.button !== 0) return null;
      band.focus({ preventScroll: true });
      const lock = now();
      return this.gesture("move lock", (_dx, dy, event) => shifted(lock, seconds(dy), event));
    });
    band.addEventListener("keydown", (event) => {
      if (event.key === "ArrowUp" || event.key === "ArrowDown") {
        const by = ((event.key === "ArrowUp" ? 1 : -1) * (event.shiftKey ? 10 : 1)) / store.rate;
        this.nudge(id, shifted(now(), by), "move lock");
      } else if (event.key === "Delete" || event.key === "Backspace") {
        this.changeOf(null);
        session.edit(deleteLock(store.document as Document, id), "delete lock");
      } else return;
      event.preventDefault();
      event.stopPropagation();
    });
    const edge = (side: 0 | 1): HTMLElement => {
      const put = (lock: LockedTime, time: number): Document => {
        const frame = 1 / store.rate;
        const change =
          side === 0
            ? { start: clamp(time, 0, lock.end - frame) }
            : { end: clamp(time, lock.start + frame, store.inputEnd) };
        return changeLock(store.document as Document, id, change);
      };
      const handle = this.slider(
        "handle edge",
        "Lock",
        () => {
          const lock = now();
          const start = side === 0 ? lock.start : lock.end;
          return this.gesture("change lock", (_dx, dy, event) => put(lock, onFrame(start + seconds(dy), event)));
        },
        (by) => {
          const lock = now();
          this.nudge(id, put(lock, (side === 0 ? lock.start : lock.end) + by / store.rate), "change lock");
        },
      );
      handle.addEventListener("focus", choose);
      return handle;
    };
    return { band, edges: [edge(0), edge(1)] };
  }

  /** A handle that a screen reader takes for a slider: arrows move it by one, page keys and shift by ten. */
  private slider(
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
      event.preventDefault();
      event.stopPropagation();
      nudge(by);
    });
    return handle;
  }
}

/** Speeds that a hand sets have two digits after the point, or three below 1. */
function roundSpeed(speed: number): number {
  const held = clamp(speed, SLOWEST, FASTEST);
  return held >= 1 ? Math.round(held * 100) / 100 : Math.round(held * 1000) / 1000;
}

function move(element: HTMLElement, x: number, y: number, shown: boolean): void {
  element.hidden = !shown;
  if (shown) element.style.transform = `translate(${x.toFixed(2)}px, ${y.toFixed(2)}px)`;
}

function describe(element: HTMLElement, now: number, low: number, high: number, text: string): void {
  setAttribute(element, "aria-valuemin", low.toFixed(3));
  setAttribute(element, "aria-valuemax", high.toFixed(3));
  setAttribute(element, "aria-valuenow", now.toFixed(3));
  setAttribute(element, "aria-valuetext", text);
}

/** Make what is new, remove what is gone. */
function keep<T extends { id: string }, E extends HTMLElement>(
  kept: Map<string, E>,
  wanted: readonly T[],
  create: (item: T) => E,
  parent: HTMLElement,
): void {
  const ids = new Set(wanted.map((item) => item.id));
  for (const [id, element] of kept) {
    if (ids.has(id)) continue;
    element.remove();
    kept.delete(id);
  }
  for (const item of wanted) {
    if (kept.has(item.id)) continue;
    const element = create(item);
    kept.set(item.id, element);
    parent.append(element);
  }
}
