/** Locked spans: from when to when of the input, and at which speeds it may play meanwhile. */

import { deleteItem } from "../../deleting";
import { addLock, changeLock, findLock } from "../../document";
import { make } from "../../dom";
import { parseLockSpeeds, parseTime, speedsText } from "../../grammar";
import { clamp } from "../../scale";
import { iconButton } from "../buttons";
import { textField } from "../fields";
import { documentOf, frame, type Section, type Side } from "./section";

interface LockRow {
  readonly root: HTMLElement;
  update(): void;
}

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
  const list = make("div");
  const heads = make(
    "div",
    { class: "heads", "aria-hidden": true },
    ...["from", "to", "speed"].map((head) => make("span", {}, head)),
  );
  const note = make("p", { class: "note" }, "Drag along the input times to keep a span at its speed.");
  body.append(heads, list, note);
  const rows = new Map<string, LockRow>();
  return {
    root,
    update() {
      const { locks } = documentOf(store);
      for (const [id, row] of rows) {
        if (locks.some((lock) => lock.id === id)) continue;
        row.root.remove();
        rows.delete(id);
      }
      for (const { id } of locks) {
        let row = rows.get(id);
        if (!row) {
          row = lockRow(side, id);
          rows.set(id, row);
          list.append(row.root);
        }
        row.update();
      }
      heads.hidden = locks.length === 0;
      note.hidden = locks.length > 0;
    },
  };
}

function lockRow({ store, connection }: Side, id: string): LockRow {
  const change = (part: Parameters<typeof changeLock>[2]): boolean => {
    connection.edit(changeLock(documentOf(store), id, part), "change lock");
    return true;
  };
  const from = textField("From", "Input time at which it begins", (text) =>
    change({ start: parseTime(text, store.rate) }),
  );
  const to = textField("To", "Input time at which it ends", (text) => change({ end: parseTime(text, store.rate) }));
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
      from.show(lock.start.toFixed(2));
      to.show(lock.end.toFixed(2));
      speed.show(speedsText(lock.slowest, lock.fastest));
      root.setAttribute("aria-current", String(store.selection?.kind === "lock" && store.selection.id === id));
      root.classList.toggle("faulty", store.problem?.lock === id);
    },
  };
}
