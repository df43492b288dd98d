/** Which stretch of a clip's file is used. */

import { make } from "../../dom";
import { GrammarError, parseTime } from "../../grammar";
import type { Clip, ClipFile } from "../../messages";
import { clamp } from "../../scale";
import { type Trim, trimClip, trimOf } from "../../trim";
import { fieldTime, saidTime, unitsOf } from "../../units";
import { button } from "../buttons";
import { textField } from "../fields";
import { type Scrub, valueScrub } from "../scrub";
import { documentOf, row, type Side } from "./section";

/** Frames of a clip that are used at least. */
const LEAST = 4;

export class TrimRow {
  readonly root: HTMLElement;
  update: () => void;

  constructor({ store, connection }: Pick<Side, "store" | "connection">, index: number) {
    const clipNow = (): Clip | null => store.clips[index] ?? null;
    const now = (clip: Clip): Trim => trimOf(documentOf(store).clips[index] as ClipFile, clip);
    const trim = (clip: Clip, start: number, end: number): void =>
      connection.edit(trimClip(documentOf(store), index, clip, start, end), "trim clip");
    const bound =
      (which: "start" | "end") =>
      (text: string): boolean => {
        const clip = clipNow();
        if (!clip) return false;
        const whole = now(clip);
        const usual = which === "start" ? 0 : whole.last;
        const time = text === "" ? usual : parseTime(text, clip.rate);
        const start = which === "start" ? time : whole.start;
        const end = which === "end" ? time : whole.end;
        if (start < 0 || end > whole.last + 0.5 / clip.rate || end - start < (LEAST - 1.5) / clip.rate) {
          const last = saidTime(whole.last, clip.rate, unitsOf(store));
          throw new GrammarError(`expected a stretch of ${LEAST} frames or more, from 0 to ${last}, found '${text}'`);
        }
        trim(clip, start, end);
        return true;
      };
    const drag = (which: "start" | "end"): Scrub =>
      valueScrub({ store, connection }, "trim clip", (before) => {
        const clip = clipNow();
        const file = before.clips[index];
        if (!clip || !file) return () => before;
        const { start, end, last } = trimOf(file, clip);
        const least = (LEAST - 1) / clip.rate;
        return (steps) => {
          const by = steps / clip.rate;
          return which === "start"
            ? trimClip(before, index, clip, clamp(start + by, 0, end - least), end)
            : trimClip(before, index, clip, start, clamp(end + by, start + least, last));
        };
      });
    const hint = "counted from the first frame of its file: seconds, 105f, 1:03.5";
    const from = textField("From", `The first frame used, ${hint}`, bound("start"), drag("start"));
    const to = textField("To", `The last frame used, ${hint}`, bound("end"), drag("end"));
    from.input.setAttribute("aria-label", `Clip ${index + 1}: used from`);
    to.input.setAttribute("aria-label", `Clip ${index + 1}: used to`);
    const all = button("All", "Use all of it", () => {
      const clip = clipNow();
      if (clip) trim(clip, 0, now(clip).last);
    });
    const pair = make("div", { class: "pair" }, from.input, make("span", { class: "note" }, "to"), to.input, all);
    this.root = row("Used", pair, from.trouble, to.trouble);
    this.update = () => {
      const clip = clipNow();
      const there = documentOf(store).clips[index] !== undefined && clip !== null;
      this.root.hidden = !there;
      if (!there) return;
      const { start, end, last } = now(clip);
      from.show(fieldTime(start, clip.rate, unitsOf(store), 2));
      to.show(fieldTime(end, clip.rate, unitsOf(store), 2));
      all.style.visibility = start > 0 || end < last ? "visible" : "hidden";
    };
  }
}
