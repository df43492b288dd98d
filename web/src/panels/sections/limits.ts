/** Speed limits, suggested where the curve spikes. */

import { setOption } from "../../document";
import { make, setText } from "../../dom";
import { spikeOf } from "../../spikes";
import { button } from "../buttons";
import { documentOf, type Side } from "./section";

export class LimitNote {
  readonly root: HTMLElement;
  private readonly words = make("p", { class: "note" });
  private readonly set: HTMLButtonElement;
  private limit = "";

  constructor(private readonly side: Side) {
    const { store, connection } = side;
    this.set = button("", "Let the search play no faster than this", () =>
      connection.edit(setOption(documentOf(store), "speed", this.limit), "set speed limits"),
    );
    this.set.classList.add("framed");
    this.root = make(
      "div",
      { class: "length", role: "group", "aria-label": "Speed limit suggested" },
      this.words,
      this.set,
    );
  }

  update(): void {
    const { store } = this.side;
    const spike = store.knots && store.curve ? spikeOf(documentOf(store), store.knots) : null;
    this.root.hidden = spike === null;
    if (!spike) return;
    this.limit = `..${spike.limit}`;
    setText(this.words, `It plays at ${spike.speed.toFixed(1)}× at ${spike.time.toFixed(2)} s.`);
    setText(this.set, `At most ${spike.limit}×`);
  }
}
