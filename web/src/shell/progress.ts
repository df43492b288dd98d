/** How far a search is that takes long: a bar over the timeline, and what ends it. The last curve stays meanwhile. */

import { make, setAttribute, setText } from "../dom";
import type { Store, Topic } from "../store";

export class ProgressBar {
  private readonly words = make("span");
  private readonly bar = make("span", {
    class: "bar",
    role: "progressbar",
    "aria-label": "Search",
    "aria-valuemin": 0,
    "aria-valuemax": 100,
  });
  readonly root: HTMLElement;

  /** `stop` ends the search. */
  constructor(
    private readonly store: Store,
    stop: () => void,
  ) {
    const button = make("button", { type: "button", class: "button framed", title: "Stop the search (Esc)" }, "Stop");
    button.addEventListener("click", stop);
    this.root = make("div", { class: "progress", hidden: true }, this.bar, this.words, button);
  }

  update(changed: ReadonlySet<Topic>): void {
    if (!changed.has("status")) return;
    const { progress } = this.store;
    this.root.hidden = progress === null;
    if (!progress) return;
    const percent = progress.share === null ? null : Math.round(100 * progress.share);
    setText(this.words, progressWords(this.store));
    setAttribute(this.bar, "aria-valuenow", percent === null ? null : String(percent));
    this.bar.classList.toggle("unknown", percent === null);
    this.bar.style.setProperty("--share", `${percent ?? 100}%`);
  }
}

/** What is done, and how much of it is. */
export function progressWords({ progress }: Store): string {
  if (!progress) return "Opening…";
  const doing = { reading: "Reading", searching: "Searching" }[progress.doing];
  return progress.share === null ? `${doing}…` : `${doing}… ${Math.round(100 * progress.share)} %`;
}
