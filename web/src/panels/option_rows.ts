/**
 * Rows of the side for options of the search, each made from its declaration: a slider, a check box, a choice, or a
 * field. The document holds what was given: an empty field gives nothing, and neither does what is set to its default.
 */

import { setOption } from "../document";
import { make, setText } from "../dom";
import { GrammarError, parseLength, parseNumber, parseRate, parseSpeeds, rateValue } from "../grammar";
import type { Document } from "../messages";
import { OPTIONS, type Option, type OptionPanel } from "../options";
import { clamp } from "../scale";
import type { Store } from "../store";
import { blamable, check, choice, slider, textField } from "./fields";
import { type Scrub, valueScrub } from "./scrub";
import { documentOf, type Side } from "./sections/section";

type Value = string | number | boolean;

/** The row of one option. */
export interface OptionRow {
  readonly option: Option;
  readonly root: HTMLElement;
  update(document: Document): void;
}

/** Rows for the options of a panel, in the order of their declaration. */
export function optionRows(side: Side, panel: OptionPanel): readonly OptionRow[] {
  return OPTIONS.filter((option) => option.panel === panel).map((option) => optionRow(side, option));
}

/** Whether an option says something for the document's method; what was given waits until it does again. */
function says({ method, example }: Document, { methods }: Option): boolean {
  return methods.includes(method) || (example !== null && methods.includes("hand"));
}

/** What was given for an option; undefined: nothing. */
export function givenOf(document: Document, option: Option): Value | undefined {
  return document.options[option.name];
}

/** What pointing at a row tells; to people who know the command line its name there tells the rest. */
function hintOf({ hint, flag }: Option, ...more: string[]): string {
  return [hint, ...more, `On the command line: ${flag}`].join(". ");
}

/** What shows and changes one option. */
interface Control {
  readonly root: HTMLElement;
  show(given: Value | undefined): void;
  blame(message: string | null): void;
}

type Give = (value: Value | null, gesture?: string, done?: boolean) => void;

function optionRow(side: Side, option: Option): OptionRow {
  const { store, connection, faults } = side;
  // Undo speaks of "set loop", not of what a loop is.
  const label = `set ${(option.label.split(":")[0] ?? "").toLowerCase()}`;
  const give: Give = (value, gesture, done) =>
    connection.edit(setOption(documentOf(store), option.name, value), label, gesture, done);
  const control = controlOf(side, option, give);
  faults.named(`options.${option.name}`, control);
  return {
    option,
    root: control.root,
    update(document) {
      const given = givenOf(document, option);
      control.show(given);
      // What can't be used where the length is not free is shown if it is given: someone has to take it back.
      const waits = option.needsFree && document.options.length !== "free" && given === undefined;
      control.root.hidden = waits || !says(document, option);
    },
  };
}

function controlOf(side: Side, option: Option, give: Give): Control {
  // Where an option has a default that can be shown, to choose that is to give nothing.
  const unlessDefault: Give = (value, ...rest) => give(value === option.default ? null : value, ...rest);
  if (option.slider) return sliderControl(side, option, option.slider, unlessDefault);
  if (option.kind === "flag") return checkControl(option, unlessDefault);
  if (option.kind === "choice") return choiceControl(option, unlessDefault);
  return fieldControl(side, option, give);
}

function fieldControl(side: Side, option: Option, give: Give): Control {
  const commit = (text: string): boolean => {
    give(text === "" ? null : readValue(text, option, side.store));
    return true;
  };
  const hint = hintOf(option, `Empty: ${option.usual}`);
  const field = textField(option.label, hint, commit, optionScrub(side, option));
  field.input.placeholder = option.inShort;
  return {
    root: field.row,
    show: (given) => field.show(given === undefined ? "" : String(given)),
    blame: (message) => field.blame(message),
  };
}

/** Drag a length by frames, a whole number by ones, another by tenths of its size; what is no number is only typed. */
function optionScrub(side: Side, option: Option): Scrub | undefined {
  const { kind, name, least, most } = option;
  if (kind !== "length" && kind !== "number" && kind !== "whole") return undefined;
  return valueScrub(side, `set ${(option.label.split(":")[0] ?? "").toLowerCase()}`, (document) => {
    const { clip, curve } = side.store;
    const given = givenOf(document, option);
    if (kind === "length") {
      const isSaid = typeof given === "string" && given !== "free" && clip !== null;
      const frames = isSaid ? parseLength(given, clip.n_frames, clip.rate) : (curve?.n_output ?? clip?.n_frames ?? 2);
      return (steps) => setOption(document, name, `${Math.max(2, frames + steps)}f`);
    }
    const start = Number(given ?? option.default ?? usedOf(side, option));
    const step = kind === "whole" ? 1 : 10 ** Math.floor(Math.log10(Math.max(Math.abs(start), 0.1))) / 10;
    return (steps) => {
      const value = clamp(start + steps * step, least ?? 0, most ?? Infinity);
      return setOption(document, name, kind === "whole" ? Math.round(value) : Number(value.toPrecision(6)));
    };
  });
}

/** What the document holds for what was typed; throws where that says nothing. */
function readValue(text: string, option: Option, store: Store): Value {
  switch (option.kind) {
    case "length":
      if (option.name === "length" && text.toLowerCase() === "free") return "free";
      // Without a clip nothing can be told of it here.
      if (store.clip) parseLength(text, store.clip.n_frames, store.clip.rate);
      return text;
    case "rate":
      return within(parseRate(text), option, rateValue);
    case "speeds":
      parseSpeeds(text);
      return text;
    default: {
      const { least, unit, kind } = option;
      return within(parseNumber(text, { least: least ?? 0, whole: kind === "whole", unit }), option, Number);
    }
  }
}

/** Refuse what is outside an option's bounds. */
function within<T extends Value>(value: T, { least, most, unit }: Option, read: (value: T) => number): T {
  const number = read(value);
  if (number >= (least ?? -Infinity) && number <= (most ?? Infinity)) return value;
  const bounds = most === null ? `of at least ${least}` : `from ${least ?? 0} to ${most}`;
  throw new GrammarError(`expected a number ${bounds}${unit && ` ${unit}`}, found '${value}'`);
}

/** What the search used of an option that the document leaves open. */
function usedOf({ store }: Side, option: Option): number {
  const used = store.curve as Partial<Record<string, unknown>> | null;
  const value = used?.[option.name];
  return typeof value === "number" ? value : 0;
}

function sliderControl(side: Side, option: Option, [most, step]: readonly [number, number], give: Give): Control {
  // What is small needs fine steps: the slider moves by the root of the value.
  const square = option.curve === "square";
  let gesture = "";
  const row = slider(
    option.label,
    hintOf(option, ...(option.default === null ? [`Else: ${option.usual}`] : [])),
    { min: 0, max: most, step },
    (place, done) => {
      // The moves of one drag are one step to undo.
      gesture ||= side.connection.newGesture();
      give(square ? place ** 2 : place, gesture, done);
      if (done) gesture = "";
    },
  );
  if (option.name === "influence") row.row.append(endsOfInfluence());
  const { root, blame } = blamable(row.row, row.input);
  return {
    root,
    blame,
    show(given) {
      const value = Number(given ?? option.default ?? usedOf(side, option));
      row.show(square ? Math.sqrt(value) : value, value.toFixed(2));
    },
  };
}

/** What the ends of the slider are, in the words of animators; the paper's stand in the tooltip. */
function endsOfInfluence(): HTMLElement {
  const title = "The paper: the influence of the search beside that of the spline through the keytimes";
  return make("div", { class: "ends", title }, make("span", {}, "Spline"), make("span", {}, "Guided"));
}

function checkControl(option: Option, give: Give): Control {
  const row = check(option.label, hintOf(option), (on) => give(on));
  const { root, blame } = blamable(row.row, row.input);
  return { root, blame, show: (given) => row.show((given ?? option.default) === true) };
}

function choiceControl(option: Option, give: Give): Control {
  const open = option.default === null;
  const hint = open ? hintOf(option, `Default: ${option.usual}`) : hintOf(option);
  const choices = [
    ...(open ? [{ value: "", text: "Default" }] : []),
    ...option.choices.map(({ value, label }) => ({ value, text: label })),
  ];
  const row = choice<string>(option.label, hint, (value) => give(value === "" ? null : value));
  const { root, blame } = blamable(row.row, row.select);
  return { root, blame, show: (given) => row.show(choices, String(given ?? option.default ?? "")) };
}

/** Rows that few people need, folded away; beside them how many are given. */
export function foldedRows(side: Side, panel: OptionPanel): { root: HTMLElement; update(document: Document): void } {
  const rows = optionRows(side, panel);
  const said = make("span", { class: "note" });
  const root = make("details", { class: "reading" }, make("summary", {}, "More", said), ...rows.map((row) => row.root));
  return {
    root,
    update(document) {
      for (const row of rows) row.update(document);
      const count = rows.filter(({ option, root }) => !root.hidden && givenOf(document, option) !== undefined).length;
      root.hidden = rows.every((row) => row.root.hidden);
      setText(said, count > 0 ? `${count} set` : "");
      if (rows.some(({ option }) => side.store.problem?.field === `options.${option.name}`)) root.open = true;
    },
  };
}
