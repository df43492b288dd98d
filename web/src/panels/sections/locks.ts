/** Locked spans: from when to when of the input, and at which speeds it may play meanwhile. */

import { deleteItem } from "../../deleting";
import { addLock, changeLock, findLock } from "../../document";
import { make } from "../../dom";
import { parseLockSpeeds, speedsText } from "../../grammar";
import type { LockedTime } from "../../messages";
import { clamp } from "../../scale";
import { inField } from "../../units";
import { iconButton } from "../buttons";
import { textField } from "../fields";
import { type Scrub, timeScrub } from "../scrub";
import { type SortedRow, SortedRows } from "../sorted_rows";
import { documentOf, frame, type Section, type Side } from "./section";
import { spanFields } from "./span_fields";

export function locksSection(side: Side): Section {
  const { store, connection } = side;
  const add = iconButton(
    "plus",
    "Add lock at the playhead",
    () => {
      const middle = store.playback.inputTime;
      const start = clamp(middle - 0.5, 0, Math.max(0, store.inputEnd - 1));
      const [document, id] = addLock(documentOf(store), start, Math.min(start + 1, store.inputEnd));
      connection.edit(document, "add lock");
      store.select({ kind: "lock", id });
    },
    "Lock a second around the playhead",
  );
  const { root, body } = frame("Locked spans", add);
  const note = make("p", { class: "note" }, "Drag along the input times to keep a span at its speed.");
  const rows = new SortedRows<LockedTime>(
    [
      { name: "from", title: "Sort by the beginning", value: (lock) => lock.start },
      { name: "to", title: "Sort by the end", value: (lock) => lock.end },
      { name: "speed", title: "Sort by the fastest speed", value: (lock) => lock.fastest },
    ],
    (id) => lockRow(side, id),
  );
  body.append(rows.root, note);
  return {
    root,
    update() {
      const { locks } = documentOf(store);
      rows.update(locks, store.selectedId("lock"));
      note.hidden = locks.length > 0;
    },
  };
}

function lockRow({ store, connection }: Side, id: string): SortedRow {
  const change = (part: Parameters<typeof changeLock>[2]): boolean => {
    connection.edit(changeLock(documentOf(store), id, part), "change lock");
    return true;
  };
  const bound = (side: "start" | "end"): Scrub =>
    timeScrub(
      { store, connection },
      "change lock",
      () => findLock(documentOf(store), id)?.[side] ?? 0,
      (document, time) => {
        const lock = findLock(document, id);
        if (!lock) return document;
        const frame = 1 / store.rate;
        const held =
          side === "start" ? Math.min(time, lock.end - frame) : clamp(time, lock.start + frame, store.inputEnd);
        return changeLock(document, id, { [side]: held });
      },
    );
  const [from, to] = spanFields(store, change, bound);
  const speed = textField(
    "Speed",
    "The speed it plays at: 1, a range such as 0.5..2, or uncut (slowed down, never sped up)",
    (text) => {
      const [slowest, fastest] = parseLockSpeeds(text);
      return change({ slowest, fastest });
    },
  );
  for (const [field, name] of [
    [from, "Lock from"],
    [to, "Lock to"],
    [speed, "Lock speed"],
  ] as const) {
    field.input.setAttribute("aria-label", name);
    field.input.addEventListener("focus", () => store.select({ kind: "lock", id }));
  }
  const remove = iconButton("trash", "Delete lock", () => deleteItem(store, connection, { kind: "lock", id }));
  const root = make(
    "div",
    { class: "lock" },
    from.input,
    to.input,
    speed.input,
    remove,
    from.trouble,
    to.trouble,
    speed.trouble,
  );
  return {
    root,
    update() {
      const lock = findLock(documentOf(store), id);
      if (!lock) return;
      from.show(inField(store, lock.start, 2));
      to.show(inField(store, lock.end, 2));
      speed.show(speedsText(lock.slowest, lock.fastest));
      root.setAttribute("aria-current", String(store.selectedId("lock") === id));
      root.classList.toggle("faulty", store.problem?.lock === id);
    },
  };
}
