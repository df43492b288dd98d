/** Light or dark: as the person chose, else as the system has it; and the colours that canvases need. */

import { recall, remember } from "./memory";
import type { Clip } from "./messages";

export type ThemeChoice = "system" | "light" | "dark";

const NAMES = [
  "surface",
  "panel",
  "line",
  "line-strong",
  "ink",
  "muted",
  "output",
  "output-soft",
  "input",
  "reference",
  "spline",
  "lock",
  "lock-soft",
  "flight",
  "danger",
  "key",
  "playhead",
  "stage-line",
  "stage-top",
  "stage-bottom",
  "figure-input",
  "figure-output",
  "figure-2",
  "figure-3",
  "figure-4",
  "figure-5",
  "heat-low",
  "heat-high",
] as const;

export type Palette = Record<(typeof NAMES)[number], string>;

/** The figures of a group: the first has the output's colour. Told apart in either theme, and by the colour-blind. */
export const FIGURES = ["figure-output", "figure-2", "figure-3", "figure-4", "figure-5"] as const;

/** The name of a clip's colour among all clips; of a sixth figure on they repeat. None for what has no figure. */
export function figureColor(clips: readonly Clip[], index: number): (typeof FIGURES)[number] | null {
  if (clips[index]?.holds !== "motion") return null;
  const before = clips.slice(0, index).filter((clip) => clip.holds === "motion").length;
  return FIGURES[before % FIGURES.length] ?? null;
}

const STORED = "retime.theme";

export class Theme {
  palette: Palette;
  private readonly media = matchMedia("(prefers-color-scheme: dark)");

  private changed: () => void = () => undefined;

  constructor(private readonly root: HTMLElement) {
    this.media.addEventListener("change", () => this.apply());
    this.palette = this.read();
    this.apply();
  }

  /** Call when the colours have changed. */
  listen(changed: () => void): void {
    this.changed = changed;
  }

  get choice(): ThemeChoice {
    const stored = recall(STORED);
    return stored === "light" || stored === "dark" ? stored : "system";
  }

  get dark(): boolean {
    return this.choice === "system" ? this.media.matches : this.choice === "dark";
  }

  /** Whether the style sheet has come: in a notebook it may come after the view. */
  get styled(): boolean {
    return this.palette.ink !== "";
  }

  /** Read the colours again. */
  refresh(): void {
    this.palette = this.read();
    if (this.styled) this.changed();
  }

  choose(choice: ThemeChoice): void {
    remember(STORED, choice);
    this.apply();
  }

  private apply(): void {
    this.root.dataset.theme = this.dark ? "dark" : "light";
    this.palette = this.read();
    this.changed();
  }

  private read(): Palette {
    const style = getComputedStyle(this.root);
    return Object.fromEntries(NAMES.map((name) => [name, style.getPropertyValue(`--${name}`).trim()])) as Palette;
  }
}
