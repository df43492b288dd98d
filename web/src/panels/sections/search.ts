/** Search: how the warp is found. */

import { parseNumber } from "../../grammar";
import type { Document } from "../../messages";
import { blamable, check, choice, textField } from "../fields";
import { foldedRows, optionRows } from "../option_rows";
import { valueScrub } from "../scrub";
import { documentOf, frame, type Section, type Side } from "./section";

const METHODS: readonly { value: Document["method"]; text: string }[] = [
  { value: "guided", text: "Guided" },
  { value: "align", text: "Synchronise" },
  { value: "linear", text: "Linear" },
  { value: "spline", text: "Spline" },
];

export function searchSection(side: Side): Section {
  const { store, connection, faults } = side;
  const { root, body } = frame("Search");
  const methodHint = "Search for a warp, keep step with the reference all the way, or only join the keytimes";
  const method = choice<Document["method"]>("Method", methodHint, (value) =>
    connection.edit({ ...documentOf(store), method: value }, "choose method"),
  );
  const blamedMethod = blamable(method.row, method.select);
  faults.named("method", blamedMethod);
  const repeatHint =
    "How often the reference is played: 6 for one cycle of a walk and six strides, 2.5 for two and a half";
  const setRepeat = (text: string): boolean => {
    connection.edit({ ...documentOf(store), repeat: parseNumber(text || "1", { least: 1, unit: "x" }) }, "set repeat");
    return true;
  };
  const dragRepeat = valueScrub(side, "set repeat", (before) => (steps) => ({
    ...before,
    repeat: Math.max(1, Number((before.repeat + steps / 10).toFixed(2))),
  }));
  const repeat = textField("Repeat", repeatHint, setRepeat, dragRepeat);
  faults.named("repeat", repeat);
  const rows = optionRows(side, "search");
  const average = check(
    "Average where it is sped up",
    "Where frames are skipped, blend them instead of dropping them",
    (on) => connection.edit({ ...documentOf(store), average: on }, "set averaging"),
  );
  const more = foldedRows(side, "more");
  body.append(blamedMethod.root, repeat.row, ...rows.map((row) => row.root), average.row, more.root);
  return {
    root,
    update() {
      const document = documentOf(store);
      method.show(METHODS, document.method);
      repeat.row.hidden = document.method !== "align";
      repeat.show(String(document.repeat));
      for (const row of rows) row.update(document);
      average.show(document.average);
      more.update(document);
    },
  };
}
