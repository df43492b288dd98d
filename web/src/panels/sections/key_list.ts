/** All keytimes, listed: chosen, typed, sorted and deleted there as well as on the map. */

import { deleteItem } from "../../deleting";
import { changeKey, findKey, keyPlace } from "../../document";
import { make, setText } from "../../dom";
import { parseSpeed, parseTime } from "../../grammar";
import type { Document, Key } from "../../messages";
import { stepSpeed } from "../../timeline/handles/speed_range";
import { inField } from "../../units";
import { outputEnd, speedAt } from "../../warp";
import { iconButton } from "../buttons";
import { textField } from "../fields";
import { type Scrub, timeScrub, valueScrub } from "../scrub";
import { type SortedRow, SortedRows } from "../sorted_rows";
import { documentOf, type Side } from "./section";

export class KeyList {
  readonly root: HTMLDetailsElement;
  private readonly summary = make("summary");
  private readonly rows: SortedRows<Key>;

  constructor(private readonly side: Side) {
    this.rows = new SortedRows<Key>(
      [
        { name: "output", title: "Sort by output time", value: (key) => key.output_time },
        { name: "input", title: "Sort by input time", value: (key) => key.input_time },
        // Free ones come first.
        { name: "speed", title: "Sort by speed", value: (key) => key.speed ?? 0 },
      ],
      (id) => keyRow(side, id),
    );
    this.root = make("details", { class: "reading keylist" }, this.summary, this.rows.root);
    this.root.addEventListener("toggle", () => this.update());
  }

  update(): void {
    const { keys } = documentOf(this.side.store);
    this.root.hidden = keys.length === 0;
    setText(this.summary, keys.length === 1 ? "One keytime" : `All ${keys.length} keytimes`);
    // Hundreds of fields cost time: they are made where they are looked at.
    if (this.root.open) this.rows.update(keys, this.side.store.selectedId("key"));
  }
}

type Where = Pick<Side, "store" | "connection">;

/** Drag a time of a keytime: held by its neighbours and the ends, as on the map. */
export function keyScrub(where: Where, axis: "output_time" | "input_time", id: () => string | null): Scrub {
  const { store } = where;
  const key = (document: Document): Key | null => findKey(document, id());
  return timeScrub(
    where,
    "move key",
    () => key(documentOf(store))?.[axis] ?? 0,
    (document, time) => {
      const there = key(document);
      if (!there || !store.knots) return document;
      const room = { inputEnd: store.inputEnd, rate: store.rate, outputEnd: outputEnd(store.knots) };
      const wanted = { outputTime: there.output_time, inputTime: there.input_time };
      if (axis === "output_time") wanted.outputTime = time;
      else wanted.inputTime = time;
      return changeKey(document, there.id, keyPlace(document, there.id, wanted, room, store.view.snap));
    },
  );
}

/** Drag the speed at a keytime; eight steps double it. */
export function speedScrub(where: Where, id: () => string | null): Scrub {
  const { store } = where;
  return valueScrub(where, "set speed at key", (document) => {
    const key = findKey(document, id());
    if (!key) return () => document;
    const start = key.speed ?? (store.knots ? speedAt(store.knots, key.output_time) : 1);
    return (steps) => changeKey(document, key.id, { speed: stepSpeed(start, steps) });
  });
}

function keyRow({ store, connection }: Side, id: string): SortedRow {
  const change = (part: Parameters<typeof changeKey>[2], label: string): boolean => {
    connection.edit(changeKey(documentOf(store), id, part), label);
    return true;
  };
  const output = textField(
    "Output",
    "When it is shown",
    (text) => change({ output_time: parseTime(text, store.rate) }, "move key"),
    keyScrub({ store, connection }, "output_time", () => id),
  );
  const input = textField(
    "Input",
    "What is shown",
    (text) => change({ input_time: parseTime(text, store.rate) }, "move key"),
    keyScrub({ store, connection }, "input_time", () => id),
  );
  const speed = textField(
    "Speed",
    "How fast the clip plays there; empty: free",
    (text) =>
      text === "" || text === "free"
        ? change({ speed: null }, "free speed at key")
        : change({ speed: parseSpeed(text) }, "set speed at key"),
    speedScrub({ store, connection }, () => id),
  );
  speed.input.placeholder = "free";
  for (const [field, name] of [
    [output, "Keytime's output"],
    [input, "Keytime's input"],
    [speed, "Keytime's speed"],
  ] as const) {
    field.input.setAttribute("aria-label", name);
    field.input.addEventListener("focus", () => store.select({ kind: "key", id }));
  }
  const remove = iconButton("trash", "Delete this keytime", () => deleteItem(store, connection, { kind: "key", id }));
  const fields = [output, input, speed];
  const root = make(
    "div",
    { class: "lock keyrow" },
    ...fields.map((field) => field.input),
    remove,
    ...fields.map((field) => field.trouble),
  );
  return {
    root,
    update() {
      const key = findKey(documentOf(store), id);
      if (!key) return;
      output.show(inField(store, key.output_time));
      input.show(inField(store, key.input_time));
      speed.show(key.speed === null ? "" : String(key.speed));
      root.setAttribute("aria-current", String(store.chosenKeys.has(id)));
      root.classList.toggle("faulty", store.problem?.key === id);
    },
  };
}
