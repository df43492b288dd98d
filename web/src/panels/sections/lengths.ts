/** Clips of a group whose lengths differ: said, and put right by one click. */

import { make, setText } from "../../dom";
import { apart, endOf, endTogether, trimTogether } from "../../group";
import type { Store } from "../../store";
import { button } from "../buttons";
import { documentOf, type Side } from "./section";

export class LengthNotes {
  readonly root = make("div", { class: "lengths", role: "group", "aria-label": "Lengths that differ", hidden: true });
  private shown = "";

  constructor(private readonly side: Side) {}

  update(): void {
    const { store } = this.side;
    const { clips } = store;
    const different = clips.length === documentOf(store).clips.length ? apart(clips) : [];
    const now = JSON.stringify([different, clips.map((clip) => clip.name)]);
    if (now === this.shown) return;
    this.shown = now;
    this.root.hidden = different.length === 0;
    this.root.replaceChildren(...different.map(({ index, seconds }) => this.note(store, index, seconds)));
    if (different.length > 0) this.root.append(this.trim(store));
  }

  private note(store: Store, index: number, seconds: number): HTMLElement {
    const name = store.clips[index]?.name ?? "";
    const first = store.clips[0]?.name ?? "";
    const by = `${Math.abs(seconds).toFixed(2)} s`;
    const words =
      seconds < 0
        ? `${name} ends ${by} before ${first}: its last frame is held.`
        : `${name} lasts ${by} longer than ${first}: its end is not shown.`;
    const together = button(
      "End together",
      `Let ${name} begin ${by} ${seconds < 0 ? "later" : "earlier"}, so that both end together`,
      () => this.edit(endTogether(documentOf(store), store.clips, index), "align clip"),
    );
    together.classList.add("framed");
    together.setAttribute("aria-label", `End ${name} together with ${first}`);
    const text = make("p", { class: "note" });
    setText(text, words);
    return make("div", { class: "length" }, text, together);
  }

  private trim(store: Store): HTMLElement {
    const shortest = Math.min(...store.clips.map(endOf));
    const made = button(
      `Trim all to ${shortest.toFixed(2)} s`,
      "Use of every clip only as much as the shortest has",
      () => this.edit(trimTogether(documentOf(store), store.clips), "trim clips"),
    );
    made.classList.add("framed", "wide");
    return made;
  }

  private edit(document: ReturnType<typeof documentOf>, label: string): void {
    this.side.connection.edit(document, label);
  }
}
