/** From when to when of the input something is: two fields, typed or dragged. */

import { parseTime } from "../../grammar";
import type { Store } from "../../store";
import { type Field, textField } from "../fields";
import type { Scrub } from "../scrub";

/** A field for the beginning and one for the end; `change` takes what was typed, `bound` is what a drag across one does. */
export function spanFields(
  store: Store,
  change: (part: { start?: number; end?: number }) => boolean,
  bound: (side: "start" | "end") => Scrub,
): readonly [from: Field, to: Field] {
  return [
    textField(
      "From",
      "Input time at which it begins",
      (text) => change({ start: parseTime(text, store.rate) }),
      bound("start"),
    ),
    textField(
      "To",
      "Input time at which it ends",
      (text) => change({ end: parseTime(text, store.rate) }),
      bound("end"),
    ),
  ];
}
