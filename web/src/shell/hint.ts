/** First steps, shown until a person has seen them. */

import { make } from "../dom";
import { recall, remember } from "../memory";

const SEEN = "retime.hint";

export class Hint {
  readonly root: HTMLElement;

  /** `showAll` shows the list of all shortcuts. */
  constructor(showAll: () => void) {
    const done = make("button", { type: "button", class: "button framed" }, "Got it");
    const all = make("button", { type: "button", class: "button" }, "All shortcuts");
    this.root = make(
      "section",
      { class: "hint", "aria-label": "First steps", hidden: true },
      make("header", {}, make("h2", {}, "First steps")),
      make(
        "ol",
        {},
        make("li", {}, "Pull the round end of the curve to make the clip shorter or longer."),
        make("li", {}, "Double-click the curve to put a keytime, and drag it: the rest finds its own timing."),
        make("li", {}, "Drag along the input times at the left to lock what must keep its own speed: a punch, a word."),
        make("li", {}, "It moves like itself. Add a reference at the right, and it moves like another clip."),
        make("li", {}, "Press Space to play. Point at any frame to see why it plays as it does."),
      ),
      make("footer", {}, all, done),
    );
    done.addEventListener("click", () => {
      this.root.hidden = true;
      remember(SEEN, "seen");
    });
    all.addEventListener("click", showAll);
  }

  /** Show it to who has not seen it. */
  offer(): void {
    if (recall(SEEN) === null) this.root.hidden = false;
  }
}
