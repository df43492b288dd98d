/** Timing: how long the output is, how much the search has to say, and how fast and slow it may play. */

import { lengthText, setLength, setOption } from "../../document";
import { make, setText } from "../../dom";
import { parseLength, parseSpeed } from "../../grammar";
import type { Document } from "../../messages";
import { check, choice, type Field, slider, textField } from "../fields";
import { documentOf, frame, row, type Section, type Side } from "./section";

/** Some rows of the section. */
interface Rows {
  readonly rows: readonly HTMLElement[];
  update(document: Document): void;
}

export function timingSection(side: Side): Section {
  const { store, connection } = side;
  const { root, body } = frame("Timing");
  const loop = check("Loop: its end meets its beginning", "The clip is a cycle, and stays one", (on) =>
    connection.edit(setOption(documentOf(store), "loop", on), "set loop"),
  );
  const parts = [lengthRows(side), sliderRows(side), speedLimitRows(side)];
  const note = make("p", { class: "note" });
  body.append(...parts.flatMap((part) => part.rows), loop.row, note);
  return {
    root,
    update() {
      const document = documentOf(store);
      for (const part of parts) part.update(document);
      loop.show(document.options.loop);
      const { clip, curve } = store;
      setText(note, clip && curve ? lengthText(curve.n_output, clip) : "");
    },
  };
}

/** The length, and where the search chooses it: its bounds, and what it is chosen by. */
function lengthRows({ store, connection, faults }: Side): Rows {
  /** The text itself goes into the document, once it is one that says a length of this clip. */
  const lengthOf = (text: string): string => {
    // Without a clip nothing can be told of it here.
    if (store.clip) parseLength(text, store.clip.n_frames, store.clip.rate);
    return text;
  };
  const hint = "65%, 9.3 (seconds), 280f, 0:09.3 or free. Empty: after the last keytime the input plays on";
  const length = textField("Length", hint, (text) => {
    const isWord = text === "" || text.toLowerCase() === "free";
    const written = isWord ? text.toLowerCase() : lengthOf(text);
    connection.edit(setLength(documentOf(store), written === "" ? null : written), "set length");
    return true;
  });
  length.input.placeholder = "as the keys say";
  const bound = (name: "min_length" | "max_length", label: string, comparison: string): Field => {
    const says = `The free length is no ${comparison} than this: 65%, 9.3 (seconds), 280f. Empty: no bound`;
    const field = textField(label, says, (text) => {
      connection.edit({ ...documentOf(store), [name]: text === "" ? null : lengthOf(text) }, "bound length");
      return true;
    });
    field.input.placeholder = "no bound";
    return faults.named(name, field);
  };
  const least = bound("min_length", "At least", "shorter");
  const most = bound("max_length", "At most", "longer");
  const weighed = choice<"neutral" | "sum">("Weighed", "What makes one free length better than another", (value) =>
    connection.edit({ ...documentOf(store), free_weight: value }, "weigh free length"),
  );
  return {
    rows: [faults.named("length", length).row, least.row, most.row, weighed.row],
    update({ length: now, min_length, max_length, free_weight }) {
      length.show(now ?? "");
      const free = now === "free";
      for (const [field, value] of [
        [least, min_length],
        [most, max_length],
      ] as const) {
        field.row.hidden = !free && value === null;
        field.show(value ?? "");
      }
      weighed.row.hidden = !free;
      weighed.show(
        [
          { value: "neutral", text: "Both clocks alike" },
          { value: "sum", text: "Plain sum (the paper's)" },
        ],
        free_weight,
      );
    },
  };
}

function sliderRows({ store, connection }: Side): Rows {
  let gesture = "";
  /** The moves of one drag are one step to undo. */
  const slide =
    (apply: (value: number) => Document, label: string) =>
    (value: number, done: boolean): void => {
      gesture ||= connection.newGesture();
      connection.edit(apply(value), label, gesture, done);
      if (done) gesture = "";
    };
  const influence = slider(
    "Influence",
    "0 is the spline through the keytimes, 1 the guided warp",
    { min: 0, max: 1, step: 0.01 },
    slide((value) => ({ ...documentOf(store), influence: value }), "set influence"),
  );
  // What is small needs fine steps: the slider moves by the root of the value.
  const smoothness = slider(
    "Smoothness",
    "How much a change of speed costs: the more, the fewer changes",
    { min: 0, max: 4, step: 0.05 },
    slide((value) => setOption(documentOf(store), "smoothness", value ** 2), "set smoothness"),
  );
  return {
    rows: [influence.row, smoothness.row],
    update({ influence: share, options }) {
      influence.show(share, share.toFixed(2));
      smoothness.show(Math.sqrt(options.smoothness), options.smoothness.toFixed(2));
    },
  };
}

function speedLimitRows({ store, connection, faults }: Side): Rows {
  const limit = (name: "slowest" | "fastest", label: string, examples: string): Field => {
    const field = textField(label, `Speed limit for the whole clip: ${examples}. Empty: none`, (text) => {
      connection.edit(setOption(documentOf(store), name, text === "" ? null : parseSpeed(text)), "set speed limits");
      return true;
    });
    field.input.placeholder = "none";
    field.input.setAttribute("aria-label", `${label} speed`);
    return faults.named(`options.${name}`, field);
  };
  const slowest = limit("slowest", "Slowest", "0.5, 1/2, 50%");
  const fastest = limit("fastest", "Fastest", "2, 200%");
  const pair = make("div", { class: "pair" }, slowest.input, make("span", { class: "note" }, "to"), fastest.input);
  return {
    rows: [row("Speed limits", pair, slowest.trouble, fastest.trouble)],
    update({ options }) {
      slowest.show(options.slowest === null ? "" : String(options.slowest));
      fastest.show(options.fastest === null ? "" : String(options.fastest));
    },
  };
}
