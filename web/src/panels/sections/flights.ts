/** Flights: when the figure is in the air, as it was found and as a person puts it right. */

import { deleteItem } from "../../deleting";
import { freshId } from "../../document";
import { make, setAttribute } from "../../dom";
import { type Flight, findFlight, flightsCount, flightText, markFlight } from "../../flights";
import { clamp } from "../../scale";
import { inField, unitsOf } from "../../units";
import { iconButton } from "../buttons";
import { check } from "../fields";
import { type Scrub, valueScrub } from "../scrub";
import { type SortedRow, SortedRows } from "../sorted_rows";
import { documentOf, frame, type Section, type Side } from "./section";
import { spanFields } from "./span_fields";

/** Seconds of a flight that is added: those of a hop. */
const USUAL = 0.3;

export function flightsSection(side: Side): Section {
  const { store, connection, faults } = side;
  const add = iconButton(
    "plus",
    "Add flight at the playhead",
    () => {
      const start = clamp(store.playback.inputTime - USUAL / 2, 0, Math.max(0, store.inputEnd - USUAL));
      const id = freshId(documentOf(store), "f");
      const mark = { id, start, end: Math.min(start + USUAL, store.inputEnd), flies: true };
      connection.edit(markFlight(documentOf(store), mark), "add flight");
      store.select({ kind: "flight", id });
    },
    "Say that the figure is in the air around the playhead",
  );
  const { root, body } = frame("Flights", add);
  const rows = new SortedRows<Flight>(
    [
      { name: "from", title: "Sort by the beginning", value: (flight) => flight.start },
      { name: "to", title: "Sort by the end", value: (flight) => flight.end },
      {
        name: "in the air",
        title: "Sort by whether the figure is in the air",
        value: (flight) => Number(!flight.flies),
      },
    ],
    (id) => flightRow(side, id),
  );
  const note = make("p", { class: "note" }, "None found. Drag along Feet, on the timeline, to mark one.");
  const idle = make(
    "p",
    { class: "note" },
    "Without effect now: nothing keeps flights at their own speed (see Keep jumps).",
  );
  const trouble = make("p", { class: "refused", hidden: true });
  faults.named("flights", {
    blame(message) {
      trouble.textContent = message ?? "";
      trouble.hidden = message === null;
    },
  });
  body.append(rows.root, note, idle, trouble);
  return {
    root,
    update() {
      const { flights } = store;
      // Channels have no feet; what a project says of flights all the same must be seen.
      root.hidden = store.clip?.holds !== "motion" && flights.length === 0;
      rows.update(flights, store.selectedId("flight"));
      note.hidden = flights.length > 0;
      idle.hidden = flightsCount(documentOf(store), store.curve) || !flights.some((flight) => flight.marked);
    },
  };
}

function flightRow({ store, connection }: Side, id: string): SortedRow {
  const change = (part: Partial<Flight>): boolean => {
    const flight = findFlight(store.flights, id);
    if (flight) connection.edit(markFlight(documentOf(store), { ...flight, ...part }), "change flight");
    return flight !== null;
  };
  const bound = (which: "start" | "end"): Scrub =>
    valueScrub({ store, connection }, "change flight", (document) => {
      const flight = findFlight(store.flights, id);
      if (!flight) return () => document;
      const frame = 1 / store.rate;
      return (steps) => {
        const time = flight[which] + steps / store.rate;
        const held =
          which === "start" ? clamp(time, 0, flight.end - frame) : clamp(time, flight.start + frame, store.inputEnd);
        return markFlight(document, { ...flight, [which]: held });
      };
    });
  const [from, to] = spanFields(store, change, bound);
  const flies = check("", "Whether the figure is in the air there", (on) => change({ flies: on }));
  const select = (): void => store.select({ kind: "flight", id });
  for (const [input, name] of [
    [from.input, "Flight from"],
    [to.input, "Flight to"],
    [flies.input, "In the air"],
  ] as const) {
    input.setAttribute("aria-label", name);
    input.addEventListener("focus", select);
  }
  const remove = iconButton("trash", "Delete flight", () => deleteItem(store, connection, { kind: "flight", id }));
  const source = make("span", { class: "note" });
  flies.row.append(source);
  const root = make("div", { class: "lock flight" }, from.input, to.input, flies.row, remove, from.trouble, to.trouble);
  return {
    root,
    update() {
      const flight = findFlight(store.flights, id);
      if (!flight) return;
      from.show(inField(store, flight.start, 2));
      to.show(inField(store, flight.end, 2));
      flies.show(flight.flies);
      source.textContent = flight.marked ? "by hand" : "found";
      setAttribute(root, "title", flightText(flight, store.rate, unitsOf(store)));
      const undo = flight.marked ? "Take back what was said of this stretch" : "Say that this is no flight";
      setAttribute(remove, "title", undo);
      setAttribute(remove, "aria-label", undo);
      root.setAttribute("aria-current", String(store.selectedId("flight") === id));
    },
  };
}
