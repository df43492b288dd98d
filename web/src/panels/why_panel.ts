/** Why: the frame under the pointer, or at the playhead. */

import { make, setAttribute, setText } from "../dom";
import { flightText, standing } from "../flights";
import { recall, remember } from "../memory";
import { isWithin } from "../propagation";
import type { Store, Topic } from "../store";
import { fieldTime, said, unitsOf } from "../units";
import { at, inputAt, speedAt } from "../warp";
import { bindingWords, type Match, matchesAt, rank, rankedScores, rowAt } from "../why";

const STORED = "retime.why";
/** Pixels of the page's height from which it is open at first. */
const HIGH = 800;

export class WhyPanel {
  readonly root: HTMLElement;
  private readonly title = make("button", { type: "button", class: "fold" }, "Why");
  private readonly facts: HTMLElement;
  private readonly shows = make("dd");
  private readonly score = make("dd");
  private readonly bar = make("span", { class: "scorebar", "aria-hidden": true });
  private readonly scoreText = make("span");
  private readonly matched = make("dd");
  private readonly bound = make("dd");
  private readonly feet = make("dd");
  private readonly spoken = make("dd");
  private readonly feetRow: HTMLElement[];
  private readonly spokenRow: HTMLElement[];
  private readonly givenUp = make("dd");
  private readonly givenUpRow: HTMLElement[];
  private readonly solved = make("dd");
  private ranked: Float64Array = new Float64Array(0);

  constructor(private readonly store: Store) {
    this.score.append(this.bar, this.scoreText);
    const row = (name: string, value: HTMLElement): HTMLElement[] => [make("dt", {}, name), value];
    this.feetRow = row("Feet", this.feet);
    this.spokenRow = row("Example", this.spoken);
    this.givenUpRow = row("Not quite kept", this.givenUp);
    this.facts = make(
      "dl",
      { class: "facts" },
      ...row("Shows", this.shows),
      ...row("Score", this.score),
      ...row("Matched", this.matched),
      ...row("Bound by", this.bound),
      ...this.feetRow,
      ...this.spokenRow,
      ...this.givenUpRow,
      ...row("Search", this.solved),
    );
    this.root = make(
      "section",
      { class: "why", "aria-label": "Why" },
      make("header", {}, make("h2", {}, this.title)),
      this.facts,
    );
    this.title.addEventListener("click", () => {
      const open = this.root.dataset.folded === "yes";
      remember(STORED, open ? "open" : "folded");
      this.show(open);
    });
    // Where the screen is low the sections above need the room, until a person says otherwise.
    const chosen = recall(STORED);
    this.show(chosen === null ? innerHeight >= HIGH : chosen === "open");
  }

  /** Fold it away, or open it again. */
  private show(open: boolean): void {
    setAttribute(this.title, "aria-expanded", String(open));
    this.facts.hidden = !open;
    this.root.dataset.folded = open ? "no" : "yes";
  }

  update(changed: Set<Topic>): void {
    if (
      !["hover", "playhead", "why", "curve", "document", "clips", "view"].some((topic) => changed.has(topic as Topic))
    )
      return;
    const { why, knots, curve, hover, playback, rate } = this.store;
    if (changed.has("why")) this.ranked = why ? rankedScores(why) : new Float64Array(0);
    if (!knots || !curve) return;
    const time = hover ?? playback.outputTime;
    setText(this.title, `Why, at output ${said(this.store, time)} (frame ${Math.round(time * rate)})`);
    this.tellGround(inputAt(knots, time));
    setText(this.shows, `input ${said(this.store, inputAt(knots, time))} at ${speedAt(knots, time).toFixed(2)}×`);
    for (const part of this.givenUpRow) part.hidden = curve.given_up.length === 0;
    setText(this.givenUp, curve.given_up.join("; "));
    setText(
      this.solved,
      curve.total === null
        ? `${curve.method}, no search`
        : `${curve.optimal ? "best possible, proved" : "not proved best"}; ${curve.solve_ms.toFixed(0)} ms`,
    );
    if (!why || why.n_output < 3) {
      for (const part of [this.scoreText, this.matched, this.bound]) setText(part, "–");
      this.bar.style.setProperty("--share", "0%");
      return;
    }
    const row = rowAt(why, time);
    const score = at(why.scores, row);
    const share = Number.isFinite(score) ? rank(this.ranked, score) : 0;
    this.bar.style.setProperty("--share", `${(100 * share).toFixed(0)}%`);
    setText(this.scoreText, Number.isFinite(score) ? `${score.toPrecision(3)}, ${placed(share)}` : "none at the ends");
    const matches = matchesAt(why, row);
    const name = matches[0] && matches[0].source >= 0 ? `${matches[0].name} ` : "itself ";
    setText(this.matched, matches.length > 0 ? `${name}at ${matchTimes(this.store, matches)}` : "nothing");
    const words = bindingWords(at(why.binding, row));
    setText(this.bound, words.length > 0 ? words.join(", ") : "nothing");
  }

  /** Whether the figure stands or flies at an input time, and whether an example speaks for it. */
  private tellGround(time: number): void {
    const { clip, curve, document, flights } = this.store;
    const figure = clip?.holds === "motion";
    for (const part of this.feetRow) part.hidden = !figure;
    if (clip && figure) {
      const flight = flights.find(({ start, end }) => start <= time && time <= end);
      const feet = standing(clip, time);
      const stand = feet.length > 0 ? `${feet.join(", ")} on the ground` : "none at rest";
      setText(this.feet, flight ? flightText(flight, this.store.rate, unitsOf(this.store)) : stand);
    }
    for (const part of this.spokenRow) part.hidden = !document?.example;
    const example = document?.example;
    if (!example || !curve) return;
    const inExample = example.start <= time && time <= example.end;
    const silent = isWithin(curve.unspoken, time) ? "has nothing like this: own speed" : "speaks for this";
    setText(this.spoken, inExample ? "this is it" : curve.spoken_share === null ? "not known" : silent);
  }
}

/** When matched frames are, in all of their references; the unit of seconds stands at the end. */
function matchTimes(store: Store, matches: readonly Match[]): string {
  const units = unitsOf(store);
  const said = matches.map((match) => {
    const rate = (match.source < 0 ? store.clip : store.references[match.source])?.rate ?? store.rate;
    const time = fieldTime(store.wholeTime(match), rate, units, 2);
    return `${time}${match.mirrored ? " mirrored" : ""}`;
  });
  return `${said.join(", ")}${units === "seconds" ? " s" : ""}`;
}

function placed(share: number): string {
  return `worse than ${(100 * share).toFixed(0)} %`;
}
