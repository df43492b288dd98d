/** All keytimes, listed: chosen, typed, sorted and deleted there as well as on the map. */

import { deleteItem } from "../../deleting";
import { changeKey, findKey } from "../../document";
import { make, setText } from "../../dom";
import { parseSpeed, parseTime } from "../../grammar";
import type { Key } from "../../messages";
import { iconButton } from "../buttons";
import { textField } from "../fields";
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
    if (this.root.open) this.rows.update(keys);
  }
}

function keyRow({ store, connection }: Side, id: string): SortedRow {
  const change = (part: Parameters<typeof changeKey>[2], label: string): boolean => {
    connection.edit(changeKey(documentOf(store), id, part), label);
    return true;
  };
  const output = textField("Output", "When it is shown", (text) =>
    change({ output_time: parseTime(text, store.rate) }, "move key"),
  );
  const input = textField("Input", "What is shown", (text) =>
    change({ input_time: parseTime(text, store.rate) }, "move key"),
  );
  const speed = textField("Speed", "How fast the clip plays there; empty: free", (text) =>
    text === "" || text === "free"
      ? change({ speed: null }, "free speed at key")
      : change({ speed: parseSpeed(text) }, "set speed at key"),
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
      output.show(key.output_time.toFixed(3));
      input.show(key.input_time.toFixed(3));
      speed.show(key.speed === null ? "" : String(key.speed));
      root.setAttribute("aria-current", String(store.chosenKeys.has(id)));
      root.classList.toggle("faulty", store.problem?.key === id);
    },
  };
}
