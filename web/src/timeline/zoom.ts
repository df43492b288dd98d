/** What of the output is in view, and the scales that follow from it. */

import { panned, type View, within, zoomed } from "../scale";
import type { Store } from "../store";
import { inputAt, type Knots, outputEnd, slopes } from "../warp";
import { inputView, type Scales, speedView, wholeOutput } from "./layout";

/** Frames that are in view at least. */
const LEAST_FRAMES = 6;

export class Zoom {
  /** The part of the output that is in view; null: all of it, whatever its length. */
  private part: View | null = null;

  constructor(private readonly store: Store) {}

  /** Show all of the output again. */
  fit(): void {
    this.part = null;
    this.store.viewMoved();
  }

  /** Zoom about an output time, which stays where it is; a factor below 1 comes closer. */
  by(factor: number, about: number): void {
    const { home, whole } = this.views;
    this.part = zoomed(this.part ?? home, whole, factor, about, LEAST_FRAMES / this.store.rate);
    this.store.viewMoved();
  }

  /** Move along by some pixels of a map so wide. */
  pan(pixels: number, width: number): void {
    if (!this.store.knots) return;
    const { home, whole } = this.views;
    const view = this.part ?? home;
    this.part = panned(view, whole, (pixels / width) * (view.to - view.from));
    this.store.viewMoved();
  }

  /** The scales for what there is now; the same value as before, where nothing of it changed. */
  scales(before: Scales): Scales {
    const { store } = this;
    const { knots } = store;
    if (!knots) return before;
    const { home, whole } = this.views;
    const output = this.part ? within(this.part, whole) : home;
    const input = this.part ? this.inputIn(knots, output) : inputView(0, store.inputEnd, store.inputEnd);
    const speed = speedView(store.curve ? slopes(knots) : []);
    const same = (a: View, b: View): boolean => a.from === b.from && a.to === b.to;
    if (same(before.output, output) && same(before.input, input) && same(before.speed, speed)) return before;
    return { output, input, speed };
  }

  private get views(): { home: View; whole: View } {
    const { knots, inputEnd } = this.store;
    return wholeOutput(knots ? outputEnd(knots) : 1, inputEnd);
  }

  /** The input times to show with a part of the output: those that the curve has there, and the keytimes in it. */
  private inputIn(knots: Knots, output: View): View {
    const { document, inputEnd } = this.store;
    const times = [inputAt(knots, output.from), inputAt(knots, output.to)];
    for (const key of document?.keys ?? []) {
      if (key.output_time >= output.from && key.output_time <= output.to) times.push(key.input_time);
    }
    return inputView(Math.min(...times), Math.max(...times), inputEnd);
  }
}
