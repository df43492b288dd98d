/** A film of the stage: every frame is drawn, one after the other, sent to the server, and encoded there. */

import { make, setText } from "../dom";
import { parseRate, rateValue } from "../grammar";
import { closeButton, form, makeDialog, Refusal } from "../panels/dialogs/dialog";
import { fileName } from "../panels/top";
import { leading, type PlaybackState, seek } from "../playback";
import type { Stage } from "../stage/stage";
import type { Store } from "../store";
import type { Theme } from "../theme";
import { heardIn } from "./film_sound";

export type FilmSize = "1280x720" | "1920x1080" | "640x360";

export const FILM_SIZES: readonly { value: FilmSize; text: string }[] = [
  { value: "1280x720", text: "1280 × 720" },
  { value: "1920x1080", text: "1920 × 1080" },
  { value: "640x360", text: "640 × 360" },
];

export class FilmDialog {
  readonly root = makeDialog("Film of the stage");
  private readonly progress = make("progress", { "aria-label": "Frames that are drawn", max: 1 });
  private readonly words = make("p", { class: "note", role: "status" });
  private readonly refusal = new Refusal();
  private readonly close = closeButton(this.root, "Stop");
  private ends = new AbortController();

  constructor(
    private readonly store: Store,
    private readonly stage: Stage,
    private readonly theme: Theme,
  ) {
    this.root.classList.add("filming");
    const title = make("h3", { tabindex: -1 }, "Film of the stage");
    this.root.append(form(title, [this.progress, this.words, this.refusal.root], [this.close]));
    this.root.addEventListener("close", () => this.ends.abort());
  }

  /** Whether there are figures to film. */
  get works(): boolean {
    const { clips, view } = this.store;
    return this.stage.works && clips[view.clip]?.holds === "motion";
  }

  /**
   * Film what playing once would show, at a rate as a person wrote it; empty: the clip's. `heard`: with the sound of
   * what stands beside the stage, as it is heard then.
   */
  begin(path: string, rate: string, size: FilmSize, overwrite: boolean, heard: boolean): void {
    this.ends = new AbortController();
    this.refusal.say(null);
    setText(this.close, "Stop");
    this.tell(0, "Beginning…");
    this.root.showModal();
    const { signal } = this.ends;
    this.film(path, rate, size, overwrite, heard, signal).then(
      (words) => {
        if (signal.aborted) return;
        this.tell(1, words);
        setText(this.close, "Close");
      },
      (error: unknown) => {
        if (signal.aborted) return;
        this.refusal.say(error instanceof Error ? error.message : String(error));
        setText(this.close, "Close");
      },
    );
  }

  private async film(
    path: string,
    rateText: string,
    size: FilmSize,
    overwrite: boolean,
    heard: boolean,
    signal: AbortSignal,
  ): Promise<string> {
    const { store } = this;
    const { knots, playback, inputEnd, document } = store;
    const media = heard ? (document?.media ?? null) : null;
    if (!knots) throw new Error("There is no curve yet: wait for it, or solve its problem first.");
    const rateSaid = rateText.trim() === "" ? String(store.rate) : parseRate(rateText);
    const rate = rateValue(rateSaid);
    const still: PlaybackState = { ...playback, rate: 0, loop: false };
    const [, start, end] = leading(still, knots, inputEnd);
    const frames = Math.max(2, Math.floor((end - start) * rate + 1e-6) + 1);
    const [width, height] = size.split("x").map(Number) as [number, number];
    const query = new URLSearchParams({
      path,
      rate: rateSaid,
      frames: String(frames),
      overwrite: String(overwrite),
    });
    const keys = document?.keys.map((key) => key.output_time) ?? [];
    const sound = media && JSON.stringify(heardIn(playback, knots, inputEnd, media, store.rate, keys));
    const begun = await asked(`/film?${query}`, sound, signal);
    const { film, heard: hasSound } = (await begun.json()) as { film: string; heard: boolean };
    try {
      const canvas = make("canvas", { width, height });
      for (let i = 0; i < frames; i++) {
        this.tell(i / frames, `Frame ${i + 1} of ${frames}`);
        const moment = seek(still, knots, inputEnd, Math.min(start + i / rate, end));
        await asked(`/film/${film}/${i}`, await this.picture(canvas, moment), signal);
      }
      this.tell(1, "Encoding…");
      const done = await asked(`/film/${film}/end`, null, signal);
      const { path: place } = (await done.json()) as { path: string };
      return media && !hasSound ? `Wrote ${place}. ${fileName(media.path)} has no sound.` : `Wrote ${place}`;
    } catch (error) {
      // Also where the server has gone: then this can't be sent either, and nothing is lost by it.
      await fetch(`/film/${film}/stop`, { method: "POST" }).catch(() => undefined);
      throw error;
    } finally {
      store.viewMoved();
    }
  }

  /** Draw a moment with all that lies around the figures. */
  private async picture(canvas: HTMLCanvasElement, moment: PlaybackState): Promise<Blob> {
    const { width, height } = canvas;
    const pen = canvas.getContext("2d", { alpha: false });
    const drawn = this.stage.still(moment, width, height);
    if (!pen || !drawn) throw new Error("This browser can't draw the stage.");
    const { palette } = this.theme;
    const backdrop = pen.createLinearGradient(0, 0, 0, height);
    backdrop.addColorStop(0, palette["stage-top"]);
    backdrop.addColorStop(1, palette["stage-bottom"]);
    pen.fillStyle = backdrop;
    pen.fillRect(0, 0, width, height);
    pen.drawImage(drawn, 0, 0, width, height);
    const { store } = this;
    const { view } = store;
    const unit = height / 36;
    pen.font = `${0.8 * unit}px system-ui, "Segoe UI", "Noto Sans", "DejaVu Sans", sans-serif`;
    pen.textBaseline = "alphabetic";
    const side = view.layout === "side";
    if (side) {
      pen.fillStyle = palette["stage-line"];
      pen.fillRect(width / 2, 0, 1, height);
    }
    const isInput = view.companion === "input";
    const left = view.showB ? "This warp" : store.companionName;
    const right = view.showB ? `Output, ${store.companionName}` : "Output";
    const say = (text: string, color: string, x: number): number => {
      pen.fillStyle = color;
      pen.fillText(text, x, height - unit);
      return x + pen.measureText(text).width + 2 * unit;
    };
    const times = [isInput ? moment.inputTime : moment.outputTime, moment.outputTime].map((t) => `${t.toFixed(2)} s`);
    const next = say(`${left}  ${times[0]}`, isInput ? palette.input : palette.spline, unit);
    say(`${right}  ${times[1]}`, palette.output, side ? width / 2 + unit : next);
    return new Promise((resolve, reject) =>
      canvas.toBlob((blob) => (blob ? resolve(blob) : reject(new Error("The picture can't be kept."))), "image/png"),
    );
  }

  private tell(share: number, words: string): void {
    this.progress.value = share;
    setText(this.words, words);
  }
}

/** Send something to the server; what it refuses is an error with its words. */
async function asked(address: string, body: Blob | string | null, signal: AbortSignal): Promise<Response> {
  const answer = await fetch(address, { method: "POST", body, signal });
  if (!answer.ok) throw new Error(await answer.text());
  return answer;
}
