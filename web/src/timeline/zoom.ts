/** What of the output is in view, and the scales that follow from it. */

import { clamp, panned, type View, within, zoomed } from "../scale";
import type { Store } from "../store";
import { inputAt, type Knots, outputEnd, slopes } from "../warp";
import { inputView, type Scales, speedView, wholeOutput } from "./layout";

/** Frames that are in view at least. */
const LEAST_FRAMES = 6;
/** Of what is in view: the playhead keeps this far from the edges. */
const MARGIN = 0.06;

export class Zoom {
  /** The part of the output that is in view; null: all of it, whatever its length. */
  private part: View | null = null;
  /** The speeds that were shown before, which stay in view. */
  private speeds: View | null = null;
  /** A hand has moved the playhead out of view while it runs: it may run there. */
  private letGo = false;

  constructor(private readonly store: Store) {}

  /** Show all of the output again. */
  fit(): void {
    this.part = null;
    this.speeds = null;
    this.store.viewMoved();
  }

  /** What of the output is in view, and what there is to see; null while there is nothing. */
  get extent(): { readonly view: View; readonly all: View } | null {
    if (!this.store.knots) return null;
    const { home, whole } = this.views;
    const view = this.part ? within(this.part, whole) : home;
    return { view, all: { from: Math.min(home.from, view.from), to: Math.max(home.to, view.to) } };
  }

  /** Show a part of the output. */
  show(view: View): void {
    const { whole } = this.views;
    const width = Math.max(view.to - view.from, LEAST_FRAMES / this.store.rate);
    this.part = within({ from: view.from, to: view.from + width }, whole);
    this.letGo = true;
    this.store.viewMoved();
  }

  /** The playhead has moved: while it plays turn the page, else move along with it; whether another part is shown. */
  follow(): boolean {
    const { rate, outputTime } = this.store.playback;
    if (!this.part) return false;
    const { from, to } = this.part;
    const width = to - from;
    const margin = MARGIN * width;
    const inView = outputTime >= from && outputTime <= to;
    if (inView || rate === 0) this.letGo = false;
    if (this.letGo) return false;
    let start = from;
    if (rate === 0) start = clamp(from, outputTime - width + margin, outputTime - margin);
    else if (!inView) start = rate > 0 ? outputTime - margin : outputTime - width + margin;
    if (start === from) return false;
    this.part = within({ from: start, to: start + width }, this.views.whole);
    return this.part.from !== from;
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
    this.letGo = true;
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
    const speed = speedView(store.curve ? slopes(knots) : [], this.speeds);
    this.speeds = store.curve ? speed : null;
    const width = home.to - home.from;
    const share = { from: (output.from - home.from) / width, to: (output.to - home.from) / width };
    const same = (a: View, b: View): boolean => a.from === b.from && a.to === b.to;
    if (
      same(before.output, output) &&
      same(before.input, input) &&
      same(before.speed, speed) &&
      same(before.share, share)
    )
      return before;
    return { output, input, speed, share };
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
