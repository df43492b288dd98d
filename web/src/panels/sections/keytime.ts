/** The chosen keytime: its two times, and the speed there; of several, what is done to all of them. */

import { deleteSelected } from "../../deleting";
import { changeKey, findKey, keysInOrder, type Room } from "../../document";
import { make, setText } from "../../dom";
import { GrammarError, parseSpeed, parseTime } from "../../grammar";
import type { Document, Key } from "../../messages";
import { stepSpeed } from "../../timeline/handles/speed_range";
import { changeKeys, type Extent, extentOf, keysOf, moveKeys, scaleKeys } from "../../together";
import { inField, said } from "../../units";
import { outputEnd, speedAt } from "../../warp";
import { iconButton } from "../buttons";
import { check, type Field, textField } from "../fields";
import { type Scrub, valueScrub } from "../scrub";
import { KeyList, keyScrub, speedScrub } from "./key_list";
import { documentOf, frame, type Section, type Side } from "./section";

export function keytimeSection(side: Side): Section {
  const { store, connection } = side;
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
    () => deleteSelected(store, connection),
    "Delete what is chosen (Delete)",
  );
  const { root, heading, body } = frame("Keytime", remove);
  const scrub = (axis: "output_time" | "input_time"): Scrub => keyScrub(side, axis, () => selected()?.id ?? null);
  const output = textField(
    "Output at",
    "Seconds, 105f, 1:03.5, or timecode 00:01:03:12",
    (text) => change({ output_time: parseTime(text, store.rate) }, "move key"),
    scrub("output_time"),
  );
  const input = textField(
    "Shows input",
    "Seconds, 150f, 1:03.5, or timecode 00:01:03:12",
    (text) => change({ input_time: parseTime(text, store.rate) }, "move key"),
    scrub("input_time"),
  );
  const hint = "How fast the clip plays there (the tangent): 1, 0.5, 1/2 or 50%. Empty: as it comes";
  const typed = (text: string): boolean => {
    if (text === "" || text === "free") return change({ speed: null }, "free speed at key");
    return change({ speed: parseSpeed(text) }, "set speed at key");
  };
  const speed = textField(
    "Speed",
    hint,
    typed,
    speedScrub(side, () => selected()?.id ?? null),
  );
  speed.input.placeholder = "free";
  const note = make("p", { class: "note" });
  const fields = make("div", {}, output.row, input.row, speed.row);
  const several = new SeveralKeys(side);
  const ripple = check("Ripple", "What follows a keytime that is moved moves along, the end too (R)", (on) =>
    store.look({ ripple: on }),
  );
  const list = new KeyList(side);
  body.append(fields, several.root, note, ripple.row, list.root);
  return {
    root,
    update() {
      const key = selected();
      const { keys } = documentOf(store);
      const { size } = store.chosenKeys;
      fields.hidden = key === null || size > 1;
      several.root.hidden = size < 2;
      ripple.row.hidden = keys.length === 0;
      ripple.show(store.view.ripple);
      list.update();
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
      if (size > 1) {
        setText(heading, `${size} keytimes`);
        several.update();
        return;
      }
      const place = keysInOrder(documentOf(store)).findIndex((one) => one.id === key.id);
      setText(heading, `Keytime ${place + 1} of ${keys.length}`);
      output.show(inField(store, key.output_time));
      input.show(inField(store, key.input_time));
      speed.show(key.speed === null ? "" : String(key.speed));
      speed.input.placeholder = store.knots ? `free, ${speedAt(store.knots, key.output_time).toFixed(2)} now` : "free";
    },
  };
}

/** What can be typed for several keytimes at once. */
class SeveralKeys {
  readonly root: HTMLElement;
  private readonly first: Field;
  private readonly duration: Field;
  private readonly speed: Field;
  private readonly note = make("p", { class: "note" });

  constructor(private readonly side: Side) {
    const { store } = side;
    const hint = "2.5 (seconds), 105f, 1:03.5, or timecode 00:01:03:12";
    this.first = textField(
      "Begin at",
      `Output time of the first: ${hint}`,
      (text) => {
        const by = parseTime(text, store.rate) - this.extent.outputStart;
        return this.edit("move keys", (document) =>
          moveKeys(document, store.chosenKeys, { output: by, input: 0 }, this.room, store.view.ripple),
        );
      },
      valueScrub(side, "move keys", (document) => {
        const { room } = this;
        const { chosenKeys, view } = store;
        return (steps) => moveKeys(document, chosenKeys, { output: steps / room.rate, input: 0 }, room, view.ripple);
      }),
    );
    this.duration = textField(
      "Last",
      `Output time from the first to the last: ${hint}, or a share, 150%`,
      (text) => {
        const { outputStart, outputEnd } = this.extent;
        const before = outputEnd - outputStart;
        const factor = text.endsWith("%") ? parseSpeed(text) : parseTime(text, store.rate) / before;
        if (!(factor > 0)) throw new GrammarError(`expected a time above 0, found '${text}'`);
        const scaling = { output: { about: outputStart, factor } };
        return this.edit("scale keys", (document) =>
          scaleKeys(document, store.chosenKeys, scaling, this.room, store.view.snap),
        );
      },
      valueScrub(side, "scale keys", (document) => {
        const { room } = this;
        const { chosenKeys, view } = store;
        const { outputStart, outputEnd } = this.extent;
        const before = Math.max(outputEnd - outputStart, 1 / room.rate);
        return (steps) => {
          const scaling = { about: outputStart, factor: Math.max(0, 1 + steps / room.rate / before) };
          return scaleKeys(document, chosenKeys, { output: scaling }, room, view.snap);
        };
      }),
    );
    this.speed = textField(
      "Speed",
      "How fast the clip plays at each: 1, 0.5, 1/2 or 50%; free: as it comes",
      (text) => {
        const free = text === "" || text === "free";
        return this.edit(free ? "free speed at keys" : "set speed at keys", (document) =>
          changeKeys(document, store.chosenKeys, { speed: free ? null : parseSpeed(text) }),
        );
      },
      valueScrub(side, "set speed at keys", (document) => {
        const { chosenKeys, knots } = store;
        const [first] = keysOf(document, chosenKeys);
        if (!first) return () => document;
        const start = first.speed ?? (knots ? speedAt(knots, first.output_time) : 1);
        return (steps) => changeKeys(document, chosenKeys, { speed: stepSpeed(start, steps) });
      }),
    );
    const fields = [this.first, this.duration, this.speed];
    this.root = make("div", { hidden: true }, ...fields.map((field) => field.row), this.note);
  }

  update(): void {
    const { store } = this.side;
    const keys = keysOf(documentOf(store), store.chosenKeys);
    const { outputStart, outputEnd, inputStart, inputEnd } = this.extent;
    this.first.show(inField(store, outputStart));
    this.duration.show(inField(store, outputEnd - outputStart));
    const [speed] = keys.map((key) => key.speed);
    const alike = keys.every((key) => key.speed === speed);
    this.speed.show(alike && typeof speed === "number" ? String(speed) : "");
    this.speed.input.placeholder = alike ? "free" : "several";
    setText(this.note, `Input ${said(store, inputStart)} to ${said(store, inputEnd)}`);
  }

  private get extent(): Extent {
    const { store } = this.side;
    return (
      extentOf(keysOf(documentOf(store), store.chosenKeys)) ?? {
        outputStart: 0,
        outputEnd: 0,
        inputStart: 0,
        inputEnd: 0,
      }
    );
  }

  private get room(): Room {
    const { store } = this.side;
    return { inputEnd: store.inputEnd, rate: store.rate, outputEnd: store.knots ? outputEnd(store.knots) : 0 };
  }

  private edit(label: string, change: (document: Document) => Document): boolean {
    const { store, connection } = this.side;
    connection.edit(change(documentOf(store)), label);
    return true;
  }
}
