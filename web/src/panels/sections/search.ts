/** Search: how the warp is found. */

import { setOption } from "../../document";
import { make, setText } from "../../dom";
import { GrammarError, parseNumber, parseRate, rateValue } from "../../grammar";
import { check, choice, type Field, textField } from "../fields";
import { documentOf, frame, type Section, type Side } from "./section";

/** Hz. A search at a rate far above any capture's would take for ever, and nobody could stop it. */
const FASTEST_SEARCH = 240;

type NumberName = "time_scale" | "low_pass" | "n_neighbors" | "max_skip" | "upsample" | "smoothing";

interface NumberOption {
  readonly name: NumberName;
  readonly label: string;
  /** What the number does, and by which name the command line has it. */
  readonly hint: string;
  /** What holds where nothing is given. */
  readonly usual: string;
  readonly least: number;
  readonly whole: boolean;
  /** May be typed after it. */
  readonly unit?: string;
}

/** Numbers that few people need. */
const NUMBERS: readonly NumberOption[] = [
  {
    name: "time_scale",
    label: "Time scale",
    hint: "How much the speed of the body counts beside its pose, in seconds (time scale)",
    usual: "0.2 s",
    least: 0,
    whole: false,
    unit: "s",
  },
  {
    name: "low_pass",
    label: "Low-pass",
    hint: "Shaking that is faster than this, in Hz, is not looked at (low-pass filter); 0: all is",
    usual: "4 Hz",
    least: 0,
    whole: false,
    unit: "Hz",
  },
  {
    name: "n_neighbors",
    label: "Neighbours",
    hint: "How many frames of the reference each frame is compared with",
    usual: "3",
    least: 1,
    whole: true,
  },
  {
    name: "max_skip",
    label: "Longest step",
    hint: "How many frames the search may leap to the next one it shows: the more, the faster it may play (max_skip)",
    usual: "as needed",
    least: 1,
    whole: true,
  },
  {
    name: "upsample",
    label: "Finest step",
    hint: "Into how many parts the search may divide a frame: 4 lets it play at a quarter of the speed (upsample)",
    usual: "as needed",
    least: 1,
    whole: true,
  },
  {
    name: "smoothing",
    label: "Smoothing",
    hint: "Over how many of its frames the search evens out the speed; 0: it does not",
    usual: "5",
    least: 0,
    whole: true,
  },
];

export function searchSection(side: Side): Section {
  const { store, connection } = side;
  const { root, body } = frame("Search");
  const method = choice<"guided" | "linear" | "spline">(
    "Method",
    "Search for a warp, or only join the keytimes",
    (value) => connection.edit(setOption(documentOf(store), "method", value), "choose method"),
  );
  const score = choice<"joint" | "conditional">("Score", "What makes a frame's speed look right", (value) =>
    connection.edit(setOption(documentOf(store), "score", value), "choose score"),
  );
  const features = choice<"" | "torso" | "heading" | "signal">("Pose", "In which space poses are compared", (value) =>
    connection.edit(setOption(documentOf(store), "features", value === "" ? null : value), "choose pose space"),
  );
  const rate = rateField(side);
  const average = check(
    "Average where it is sped up",
    "Where frames are skipped, blend them instead of dropping them",
    (on) => connection.edit(setOption(documentOf(store), "average", on), "set averaging"),
  );
  const more = moreNumbers(side);
  body.append(method.row, score.row, features.row, rate.row, average.row, more.root);
  return {
    root,
    update() {
      const { options } = documentOf(store);
      method.show(
        [
          { value: "guided", text: "Guided" },
          { value: "linear", text: "Linear" },
          { value: "spline", text: "Spline" },
        ],
        options.method,
      );
      score.show(
        [
          { value: "joint", text: "Joint (the paper's)" },
          { value: "conditional", text: "Conditional" },
        ],
        options.score,
      );
      features.show(
        [
          { value: "", text: "Default" },
          { value: "heading", text: "Heading" },
          { value: "torso", text: "Torso (the paper's)" },
          { value: "signal", text: "Plain channels" },
        ],
        options.features ?? "",
      );
      rate.show(options.rate ?? "");
      average.show(options.average);
      more.update();
    },
  };
}

function rateField({ store, connection, faults }: Side): Field {
  const hint =
    "How many frames a second the search looks at (the analysis rate): 30, 29.97; " +
    `${FASTEST_SEARCH} at most. Empty: 30. The output keeps the clip's own`;
  const field = textField("Search rate", hint, (text) => {
    const value = text === "" ? null : parseRate(text);
    if (value !== null && !(rateValue(value) >= 1 && rateValue(value) <= FASTEST_SEARCH)) {
      throw new GrammarError(`expected a rate from 1 to ${FASTEST_SEARCH} Hz, found '${text}'`);
    }
    connection.edit(setOption(documentOf(store), "rate", value), "set search rate");
    return true;
  });
  field.input.placeholder = "30 Hz";
  return faults.named("options.rate", field);
}

/** The numbers, folded away; beside them how many are given. */
function moreNumbers(side: Side): Section {
  const { store } = side;
  const fields = NUMBERS.map((option) => ({ name: option.name, field: numberField(side, option) }));
  const given = make("span", { class: "note" });
  const root = make(
    "details",
    { class: "reading" },
    make("summary", {}, "More", given),
    ...fields.map(({ field }) => field.row),
  );
  return {
    root,
    update() {
      const { options } = documentOf(store);
      for (const { name, field } of fields) field.show(options[name] === null ? "" : String(options[name]));
      const count = fields.filter(({ name }) => options[name] !== null).length;
      setText(given, count > 0 ? `${count} set` : "");
      if (fields.some(({ name }) => store.problem?.field === `options.${name}`)) root.open = true;
    },
  };
}

function numberField({ store, connection, faults }: Side, option: NumberOption): Field {
  const { name, label, hint, usual, least, whole, unit = "" } = option;
  const field = textField(label, `${hint}. Empty: ${usual}`, (text) => {
    const value = text === "" ? null : parseNumber(text, { least, whole, unit });
    connection.edit(setOption(documentOf(store), name, value), `set ${label.toLowerCase()}`);
    return true;
  });
  field.input.placeholder = usual;
  return faults.named(`options.${name}`, field);
}
