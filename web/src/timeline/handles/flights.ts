/** Flights, beside the feet: stretches that are moved, and their ends. */

import { deleteItem } from "../../deleting";
import { make, setAttribute } from "../../dom";
import { type Flight, findFlight, flightText, markFlight } from "../../flights";
import type { Document } from "../../messages";
import { clamp } from "../../scale";
import { said, unitsOf } from "../../units";
import { inputAt, outputAt } from "../../warp";
import { draggable } from "../drag";
import { describe, keep, move } from "./elements";
import { type Hand, isDelete, take } from "./hand";

type Side = "start" | "end";

/** Pixels that a flight is wide at least, to be taken hold of; of a long take, zoom in for that, or use the list. */
const LEAST_WIDE = 4;
/** So few have handles however narrow they are. */
const FEW = 40;

interface Made {
  readonly band: HTMLButtonElement;
  readonly edges: Record<Side, HTMLElement>;
}

export class FlightHandles {
  private readonly made = new Map<string, Made>();

  constructor(
    private readonly hand: Hand,
    private readonly overlay: HTMLElement,
  ) {}

  place(): void {
    const { hand } = this;
    const { layout, store } = hand;
    const { feet, map } = layout;
    const { knots } = store;
    const all = knots && feet.height > 0 ? store.flights : [];
    const flights = all.length <= FEW ? all : all.filter((flight) => this.canBeHeld(flight));
    const elements = ({ band, edges }: Made): HTMLElement[] => [band, edges.start, edges.end];
    keep(this.made, flights, (flight) => this.make(flight), elements, this.overlay);
    flights.forEach((flight) => {
      if (!knots) return;
      const i = all.indexOf(flight);
      const { band, edges } = this.made.get(flight.id) as Made;
      const [left, right] = [flight.start, flight.end].map((time) => hand.overlayX(outputAt(knots, time)));
      const low = hand.overlayX(hand.scales.output.from);
      const from = clamp(left as number, low, low + map.width);
      const to = clamp(right as number, low, low + map.width);
      band.style.width = `${Math.max(to - from, 3)}px`;
      band.style.height = `${feet.height}px`;
      move(band, from, feet.y, (right as number) >= low && (left as number) <= low + map.width);
      const chosen = store.selection?.kind === "flight" && store.selection.id === flight.id;
      setAttribute(band, "aria-pressed", String(chosen));
      setAttribute(band, "aria-label", `Flight ${i + 1}: ${flightText(flight, store.rate, unitsOf(store))}`);
      setAttribute(band, "title", flightText(flight, store.rate, unitsOf(store)));
      band.classList.toggle("marked", flight.marked);
      band.classList.toggle("denied", !flight.flies);
      for (const side of ["start", "end"] as const) {
        const edge = edges[side];
        const x = (side === "start" ? left : right) as number;
        edge.style.height = `${feet.height}px`;
        move(edge, x, feet.y, x >= low && x <= low + map.width);
        setAttribute(edge, "aria-label", `${side === "start" ? "Beginning" : "End"} of flight ${i + 1}`);
        describe(edge, flight[side], 0, store.inputEnd, said(store, flight[side]));
      }
    });
  }

  /** Whether a flight is in view, and wide enough there; the chosen one always is. */
  private canBeHeld({ id, start, end }: Flight): boolean {
    const { store, layout, scales } = this.hand;
    const { selection, knots } = store;
    if (selection?.kind === "flight" && selection.id === id) return true;
    if (!knots) return false;
    const [left, right] = [start, end].map((time) => this.hand.overlayX(outputAt(knots, time))) as [number, number];
    const low = this.hand.overlayX(scales.output.from);
    return right - left >= LEAST_WIDE && right >= low && left <= low + layout.map.width;
  }

  private make(made: Flight): Made {
    const { store } = this.hand;
    const { id } = made;
    const now = (): Flight => findFlight(store.flights, id) ?? made;
    return { band: this.makeBand(now), edges: { start: this.makeEdge(now, "start"), end: this.makeEdge(now, "end") } };
  }

  /** The input time that the curve shows so many pixels from where it shows another. */
  private moved(inputTime: number, dx: number, event?: PointerEvent): number {
    const { hand } = this;
    const { knots } = hand.store;
    if (!knots) return inputTime;
    const { from, to } = hand.scales.output;
    const seconds = (dx / hand.layout.map.width) * (to - from);
    return hand.onFrame(inputAt(knots, outputAt(knots, inputTime) + seconds), event);
  }

  private makeBand(now: () => Flight): HTMLButtonElement {
    const { hand } = this;
    const { store } = hand;
    const { id } = now();
    const shifted = (flight: Flight, to: number): Document => {
      const duration = flight.end - flight.start;
      const start = clamp(to, 0, store.inputEnd - duration);
      return markFlight(hand.document, { ...flight, start, end: start + duration });
    };
    const band = make("button", { type: "button", class: "handle flight" });
    band.addEventListener("focus", () => store.select({ kind: "flight", id }));
    draggable(band, (down) => {
      if (down.button !== 0) return null;
      band.focus({ preventScroll: true });
      const flight = now();
      return hand.gesture("move flight", (dx, _dy, event) => shifted(flight, this.moved(flight.start, dx, event)));
    });
    band.addEventListener("keydown", (event) => {
      if (event.key === "ArrowLeft" || event.key === "ArrowRight") {
        const by = ((event.key === "ArrowRight" ? 1 : -1) * (event.shiftKey ? 10 : 1)) / store.rate;
        hand.nudge(id, shifted(now(), now().start + by), "move flight");
      } else if (isDelete(event)) deleteItem(store, hand.connection, { kind: "flight", id });
      else return;
      take(event);
    });
    return band;
  }

  private makeEdge(now: () => Flight, side: Side): HTMLElement {
    const { hand } = this;
    const { store } = hand;
    const { id } = now();
    const put = (flight: Flight, time: number): Document => {
      const frame = 1 / store.rate;
      const change =
        side === "start"
          ? { start: clamp(time, 0, flight.end - frame) }
          : { end: clamp(time, flight.start + frame, store.inputEnd) };
      return markFlight(hand.document, { ...flight, ...change });
    };
    const handle = hand.slider(
      "handle flightedge",
      "Flight",
      () => {
        const flight = now();
        return hand.gesture("change flight", (dx, _dy, event) => put(flight, this.moved(flight[side], dx, event)));
      },
      (by) => {
        const flight = now();
        hand.nudge(`${id} ${side}`, put(flight, flight[side] + by / store.rate), "change flight");
      },
    );
    handle.addEventListener("focus", () => store.select({ kind: "flight", id }));
    return handle;
  }
}
