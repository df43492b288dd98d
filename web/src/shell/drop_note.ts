/** What becomes of a file that was dropped, beside the place where it was dropped: why it is refused, above all. */

import { make, setText } from "../dom";

export class DropNote {
  readonly root = make("div", { class: "dropnote", role: "alert", hidden: true });
  private place: { readonly x: number; readonly y: number } | null = null;

  /** `page` is what the note lies on: a click there takes it away. */
  constructor(private readonly page: HTMLElement) {
    const pressed = (event: PointerEvent): void => {
      if (!(event.target instanceof Node && this.root.contains(event.target))) this.root.hidden = true;
    };
    // Before whatever else is pressed there, which may keep the event to itself.
    page.addEventListener("pointerdown", pressed, { capture: true });
  }

  /** A file was dropped here: what is wrong with it is said here too, until it is taken. */
  dropped(event: { readonly clientX: number; readonly clientY: number }): void {
    const box = this.page.getBoundingClientRect();
    this.place = { x: event.clientX - box.left, y: event.clientY - box.top };
    this.root.hidden = true;
  }

  /** What was dropped last was taken. */
  taken(): void {
    this.place = null;
    this.root.hidden = true;
  }

  /** Say what is done with it; nothing where nothing was dropped. */
  tell(words: string): void {
    if (this.place) this.show(this.place, words, "working");
  }

  /** Say why not; false where nothing was dropped. */
  refuse(reason: string): boolean {
    const { place } = this;
    if (!place) return false;
    this.place = null;
    this.show(place, reason, "refused");
    return true;
  }

  private show(place: { readonly x: number; readonly y: number }, words: string, state: string): void {
    const { root, page } = this;
    setText(root, words);
    root.dataset.is = state;
    root.hidden = false;
    const x = Math.min(place.x + 12, page.clientWidth - root.offsetWidth - 8);
    const y = Math.min(place.y + 12, page.clientHeight - root.offsetHeight - 8);
    root.style.left = `${Math.max(8, x)}px`;
    root.style.top = `${Math.max(8, y)}px`;
  }
}
