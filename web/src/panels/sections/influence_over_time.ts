/** Influence that changes over time: painted on the timeline, or typed. */

import { make, setText } from "../../dom";
import { influenceText, parseInfluence } from "../../influence";
import { button } from "../buttons";
import { textField } from "../fields";
import { documentOf, type Side } from "./section";

export class InfluenceOverTime {
  readonly root: HTMLElement;
  private readonly paint: HTMLButtonElement;
  private readonly field;

  constructor(private readonly side: Side) {
    const { store, connection } = side;
    this.paint = button("", "Show a row of the timeline where it is painted", () => {
      const { influence } = documentOf(store);
      if (influence.length > 0) connection.edit({ ...documentOf(store), influence: [] }, "set influence");
      store.look({ paintsInfluence: influence.length === 0 && !store.view.paintsInfluence });
    });
    this.paint.classList.add("framed", "wide");
    this.field = textField("Over time", "Output times and shares: 0s=0, 2s=1; empty: the same everywhere", (text) => {
      connection.edit({ ...documentOf(store), influence: parseInfluence(text, store.rate) }, "set influence");
      return true;
    });
    this.field.input.placeholder = "0s=0, 2s=1";
    this.root = make("div", { class: "over" }, this.paint, this.field.row);
  }

  update(): void {
    const { store } = this.side;
    const document = documentOf(store);
    const changes = document.influence.length > 0;
    const shown = changes || store.view.paintsInfluence;
    this.root.hidden = document.method === "linear" || document.method === "spline";
    setText(
      this.paint,
      changes ? "Influence the same everywhere" : shown ? "Don't paint it" : "Paint influence over time",
    );
    this.field.row.hidden = !shown;
    this.field.show(influenceText(document.influence));
  }
}
