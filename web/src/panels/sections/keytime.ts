/** The chosen keytime: its two times, and the speed there. */

import { deleteItem } from "../../deleting";
import { changeKey, findKey, keysInOrder } from "../../document";
import { make, setText } from "../../dom";
import { parseSpeed, parseTime } from "../../grammar";
import type { Key } from "../../messages";
import { speedAt } from "../../warp";
import { iconButton } from "../buttons";
import { textField } from "../fields";
import { documentOf, frame, type Section, type Side } from "./section";

export function keytimeSection({ store, connection }: Side): Section {
  const selected = (): Key | null =>
    store.selection?.kind === "key" ? findKey(documentOf(store), store.selection.id) : null;
  const change = (part: Parameters<typeof changeKey>[2], label: string): boolean => {
    const key = selected();
    if (key) connection.edit(changeKey(documentOf(store), key.id, part), label);
    return key !== null;
  };
  const remove = iconButton(
    "trash",
    "Delete keytime",
    () => deleteItem(store, connection, store.selection),
    "Delete keytime (Delete)",
  );
  const { root, heading, body } = frame("Keytime", remove);
  const output = textField("Output at", "Seconds, 105f, 1:03.5, or timecode 00:01:03:12", (text) =>
    change({ output_time: parseTime(text, store.rate) }, "move key"),
  );
  const input = textField("Shows input", "Seconds, 150f, 1:03.5, or timecode 00:01:03:12", (text) =>
    change({ input_time: parseTime(text, store.rate) }, "move key"),
  );
  const hint = "How fast the clip plays there (the tangent): 1, 0.5, 1/2 or 50%. Empty: as it comes";
  const speed = textField("Speed", hint, (text) => {
    if (text === "" || text === "free") return change({ speed: null }, "free speed at key");
    return change({ speed: parseSpeed(text) }, "set speed at key");
  });
  speed.input.placeholder = "free";
  const note = make("p", { class: "note" });
  const fields = make("div", {}, output.row, input.row, speed.row);
  body.append(fields, note);
  return {
    root,
    update() {
      const key = selected();
      const { keys } = documentOf(store);
      fields.hidden = key === null;
      note.hidden = key !== null;
      remove.hidden = key === null;
      if (!key) {
        setText(heading, "Keytime");
        setText(
          note,
          keys.length > 0
            ? "Click a keytime to type its times."
            : "Press I to put one at the playhead, or double-click the map.",
        );
        return;
      }
      const place = keysInOrder(documentOf(store)).findIndex((one) => one.id === key.id);
      setText(heading, `Keytime ${place + 1} of ${keys.length}`);
      output.show(key.output_time.toFixed(3));
      input.show(key.input_time.toFixed(3));
      speed.show(key.speed === null ? "" : String(key.speed));
      speed.input.placeholder = store.knots ? `free, ${speedAt(store.knots, key.output_time).toFixed(2)} now` : "free";
    },
  };
}
