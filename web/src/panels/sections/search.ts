/** Search: how the warp is found. */

import { make, setAttribute, setText } from "../../dom";
import { parseNumber } from "../../grammar";
import type { Document } from "../../messages";
import { blamable, check, choice, textField } from "../fields";
import { foldedRows, optionRows } from "../option_rows";
import { valueScrub } from "../scrub";
import { documentOf, frame, type Section, type Side } from "./section";

/** What a method is called, one line that says what it does, and what the paper calls it. */
const METHODS: readonly { value: Document["method"]; text: string; hint: string; term: string }[] = [
  {
    value: "guided",
    text: "Guided",
    hint: "Between your keytimes it moves as the reference does.",
    term: "The paper: guided time warping",
  },
  {
    value: "align",
    text: "Synchronise",
    hint: "Keeps step with the reference from beginning to end.",
    term: "The paper: dynamic time warping, what it compares itself with",
  },
  {
    value: "linear",
    text: "Linear",
    hint: "One speed from keytime to keytime.",
    term: "The paper: linear time warping through the keytimes",
  },
  {
    value: "spline",
    text: "Spline",
    hint: "A smooth curve through your keytimes, as in a graph editor.",
    term: "The paper: a spline through the keytimes, what animators draw by hand",
  },
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
  const said = make("p", { class: "note" });
  body.append(blamedMethod.root, said, repeat.row, ...rows.map((row) => row.root), average.row, more.root);
  return {
    root,
    update() {
      const document = documentOf(store);
      method.show(METHODS, document.method);
      const chosen = METHODS.find(({ value }) => value === document.method);
      setText(said, chosen?.hint ?? "");
      setAttribute(said, "title", chosen?.term ?? null);
      repeat.row.hidden = document.method !== "align";
      repeat.show(String(document.repeat));
      for (const row of rows) row.update(document);
      average.show(document.average);
      more.update(document);
    },
  };
}
