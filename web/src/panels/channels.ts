/** Which channels of a signal are drawn. */

import { make, setText } from "../dom";
import type { Clip } from "../messages";
import { shownChannels } from "../stage/signals";
import type { Store } from "../store";

export class ChannelList {
  readonly root: HTMLDetailsElement;
  private readonly summary = make("summary");
  private readonly list = make("div", { class: "list" });
  private boxes: HTMLInputElement[] = [];
  private made: Clip | null = null;

  constructor(private readonly store: Store) {
    const all = make("button", { type: "button", class: "button" }, "All");
    const none = make("button", { type: "button", class: "button" }, "None");
    all.addEventListener("click", () => this.choose((clip) => clip.names.map((_, i) => i)));
    none.addEventListener("click", () => this.choose(() => []));
    this.root = make(
      "details",
      { class: "channels", hidden: true },
      this.summary,
      make("div", { role: "group", "aria-label": "Channels shown" }, all, none, this.list),
    );
    // Clicked elsewhere, or left by the keyboard, it gives the stage back.
    let open = new AbortController();
    this.root.addEventListener("toggle", () => {
      open.abort();
      if (!this.root.open) return;
      open = new AbortController();
      const { signal } = open;
      const page = this.root.ownerDocument;
      page.addEventListener(
        "pointerdown",
        ({ target }) => {
          if (!(target instanceof Node && this.root.contains(target))) this.root.open = false;
        },
        { signal },
      );
      page.addEventListener(
        "keydown",
        ({ key }) => {
          if (key === "Escape") this.root.open = false;
        },
        { signal },
      );
    });
    this.root.addEventListener("focusout", (event) => {
      if (event.relatedTarget instanceof Node && !this.root.contains(event.relatedTarget)) this.root.open = false;
    });
  }

  update(): void {
    const clip = this.store.clips[this.store.view.clip] ?? this.store.clip;
    this.root.hidden = clip?.holds !== "signal";
    if (clip?.holds !== "signal") return;
    if (clip !== this.made) this.build(clip);
    const shown = new Set(shownChannels(this.store, clip));
    setText(this.summary, `${shown.size} of ${clip.names.length} channels`);
    this.boxes.forEach((box, i) => (box.checked = shown.has(i)));
  }

  private choose(which: (clip: Clip) => readonly number[]): void {
    if (this.made) this.store.chooseChannels(this.made.name, which(this.made));
  }

  private build(clip: Clip): void {
    this.made = clip;
    this.boxes = clip.names.map((_, i) => {
      const box = make("input", { type: "checkbox" });
      box.addEventListener("change", () =>
        this.choose((now) => {
          const others = shownChannels(this.store, now).filter((channel) => channel !== i);
          return box.checked ? [...others, i].sort((a, b) => a - b) : others;
        }),
      );
      return box;
    });
    this.list.replaceChildren(...clip.names.map((name, i) => make("label", { class: "check" }, this.boxes[i], name)));
  }
}
