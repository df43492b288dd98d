/** Timing: how long the output is, how much the search has to say, and how fast and slow it may play. */

import { lengthText } from "../../document";
import { make, setText } from "../../dom";
import { optionRows } from "../option_rows";
import { InfluenceOverTime } from "./influence_over_time";
import { LimitNote } from "./limits";
import { documentOf, frame, type Section, type Side } from "./section";

export function timingSection(side: Side): Section {
  const { store } = side;
  const { root, body } = frame("Timing");
  const rows = optionRows(side, "timing");
  const note = make("p", { class: "note" });
  const over = new InfluenceOverTime(side);
  const limits = new LimitNote(side);
  for (const { option, root } of rows) body.append(root, ...(option.name === "influence" ? [over.root] : []));
  body.append(limits.root, note);
  return {
    root,
    update() {
      const document = documentOf(store);
      for (const row of rows) row.update(document);
      over.update();
      limits.update();
      const { clip, curve } = store;
      setText(note, clip && curve ? lengthText(curve.n_output, clip) : "");
    },
  };
}
