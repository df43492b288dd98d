/** Propagate: what was done by hand to a stretch is carried over to the rest of the clip. */

import { make, setText } from "../../dom";
import { GrammarError, parseTime } from "../../grammar";
import { retimedStretch, setExample, stretchesText } from "../../propagation";
import { clamp } from "../../scale";
import { inField, saidSpan, saidTime, unitsOf } from "../../units";
import { button } from "../buttons";
import { textField } from "../fields";
import { type Scrub, valueScrub } from "../scrub";
import { documentOf, frame, row, type Section, type Side } from "./section";

export function propagateSection({ store, connection, faults }: Side): Section {
  const { root, body } = frame("Propagate");
  const begin = button("Propagate", "Carry the timing made by hand over to the rest of the clip", () => {
    const example = retimedStretch(documentOf(store), store.inputEnd);
    if (example) connection.edit(setExample(documentOf(store), example), "propagate");
  });
  const end = button("Stop", "Keep the timing made by hand to its own stretch", () =>
    connection.edit(setExample(documentOf(store), null), "stop propagating"),
  );
  for (const one of [begin, end]) one.classList.add("framed", "wide");
  end.setAttribute("aria-label", "Stop propagating");
  const bound =
    (side: "start" | "end") =>
    (text: string): boolean => {
      const { example } = documentOf(store);
      if (!example) return false;
      const next = { ...example, [side]: parseTime(text, store.rate) };
      if (!(next.start < next.end && next.start >= 0 && next.end <= store.inputEnd + 0.5 / store.rate))
        throw new GrammarError(
          `expected a stretch of the input, from 0 to ${saidTime(store.inputEnd, store.rate, unitsOf(store))}, found '${text}'`,
        );
      connection.edit(setExample(documentOf(store), next), "change example");
      return true;
    };
  const drag = (side: "start" | "end"): Scrub =>
    valueScrub({ store, connection }, "change example", (before) => {
      const { example } = before;
      if (!example) return () => before;
      const frame = 1 / store.rate;
      return (steps) => {
        const time = example[side] + steps * frame;
        const held =
          side === "start" ? clamp(time, 0, example.end - frame) : clamp(time, example.start + frame, store.inputEnd);
        return setExample(before, { ...example, [side]: held });
      };
    });
  const from = textField("From", "Input time at which the example begins", bound("start"), drag("start"));
  const to = textField("To", "Input time at which the example ends", bound("end"), drag("end"));
  from.input.setAttribute("aria-label", "Example from");
  to.input.setAttribute("aria-label", "Example to");
  faults.named("example", from);
  const pair = make("div", { class: "pair" }, from.input, make("span", { class: "note" }, "to"), to.input);
  const range = row("Example", pair, from.trouble, to.trouble);
  const note = make("p", { class: "note" });
  const share = make("p", { class: "note", role: "status" });
  const warnings = make("ul", { class: "warnings", "aria-label": "What to look at" });
  let warned = "";
  body.append(note, begin, range, share, warnings, end);
  return {
    root,
    update() {
      const document = documentOf(store);
      const { example } = document;
      const stretch = retimedStretch(document, store.inputEnd);
      for (const part of [range, share, warnings, end]) part.hidden = example === null;
      for (const part of [note, begin]) part.hidden = example !== null;
      begin.disabled = stretch === null;
      setText(
        note,
        stretch === null
          ? "Retime a stretch by hand first, with keytimes or locks; then the rest can follow."
          : `Input ${saidSpan(store, stretch)} was retimed by hand; the rest follows.`,
      );
      if (!example) return;
      from.show(inField(store, example.start, 2));
      to.show(inField(store, example.end, 2));
      const { curve } = store;
      const spoken = curve?.spoken_share ?? null;
      const said = curve?.example_warnings ?? [];
      const silent = curve ? stretchesText(curve.unspoken, store.rate, unitsOf(store)) : "";
      const stays = silent === "" ? "" : ` Of input ${silent} it says little (hatched on the map).`;
      setText(
        share,
        spoken === null
          ? "How much of the clip the example speaks for is not known: the paper's way does not tell."
          : `The example speaks for ${(100 * spoken).toFixed(0)} % of the clip.${stays}`,
      );
      if (said.join("\n") !== warned) {
        warned = said.join("\n");
        warnings.replaceChildren(
          ...said.map((text) => make("li", {}, `${text.charAt(0).toUpperCase()}${text.slice(1)}.`)),
        );
      }
      warnings.hidden = said.length === 0;
    },
  };
}
