/** Search: how the warp is found. */

import type { Document } from "../../messages";
import { check, choice } from "../fields";
import { foldedRows, optionRows } from "../option_rows";
import { documentOf, frame, type Section, type Side } from "./section";

const METHODS: readonly { value: Document["method"]; text: string }[] = [
  { value: "guided", text: "Guided" },
  { value: "linear", text: "Linear" },
  { value: "spline", text: "Spline" },
];

export function searchSection(side: Side): Section {
  const { store, connection } = side;
  const { root, body } = frame("Search");
  const method = choice<Document["method"]>("Method", "Search for a warp, or only join the keytimes", (value) =>
    connection.edit({ ...documentOf(store), method: value }, "choose method"),
  );
  const rows = optionRows(side, "search");
  const average = check(
    "Average where it is sped up",
    "Where frames are skipped, blend them instead of dropping them",
    (on) => connection.edit({ ...documentOf(store), average: on }, "set averaging"),
  );
  const more = foldedRows(side, "more");
  body.append(method.row, ...rows.map((row) => row.root), average.row, more.root);
  return {
    root,
    update() {
      const document = documentOf(store);
      method.show(METHODS, document.method);
      for (const row of rows) row.update(document);
      average.show(document.average);
      more.update(document);
    },
  };
}
