/** What lies over the page while there is nothing to show, and says why. */

import { make } from "../dom";
import type { Remedy } from "./notices";

export class Veil {
  readonly root = make("div", { class: "veil", role: "status" });

  /** Cover all of the page. */
  cover(text: string): void {
    delete this.root.dataset.is;
    this.root.replaceChildren(make("p", {}, text));
    this.root.hidden = false;
  }

  /** Cover all of the page, and say what to type. */
  coverWithCommand(text: string, command: string): void {
    this.cover(text);
    if (command !== "") this.root.firstElementChild?.append(make("code", {}, command));
  }

  /** Cover all of the page, and offer what helps. */
  coverWithRemedy(text: string, { word, action }: Remedy): void {
    this.cover(text);
    this.root.dataset.is = "remedy";
    const button = make("button", { type: "button", class: "button main" }, word);
    button.addEventListener("click", action);
    this.root.firstElementChild?.append(button);
    button.focus();
  }

  /** Say something else, where it covers all: how far the opening is. */
  tell(text: string): void {
    if (!this.root.hidden && this.root.dataset.is === undefined) this.cover(text);
  }

  /** Cover what a document has nothing to show for; the top and the side, where it can be mended, stay at hand. */
  coverWithProblem(text: string): void {
    this.cover(text);
    this.root.dataset.is = "problem";
  }

  lift(): void {
    this.root.hidden = true;
  }
}
