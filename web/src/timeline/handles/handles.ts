/** What of the timeline can be taken hold of: keytimes, their speeds, the end, locks, flights, and the reference's range. */

import type { Connection } from "../../connection";
import { make } from "../../dom";
import type { Store } from "../../store";
import type { Shift } from "../../together";
import type { Layout, Scales } from "../layout";
import { ChosenFrame } from "./chosen_frame";
import { EndHandle } from "./end";
import { FlightHandles } from "./flights";
import { Hand, MARGIN } from "./hand";
import { KeyHandles } from "./keys";
import { LockHandles } from "./locks";
import { MarkHandles } from "./marks";
import { RangeHandles } from "./range";
import { SpeedHandles } from "./speeds";
import { TangentHandles } from "./tangents";

export class Handles {
  /** Over the map, the speed and the reference; and over the gutter, for locks. */
  readonly overlay = make("div", {
    class: "overlay",
    role: "group",
    "aria-label": "Keytimes, speeds, flights and reference range",
  });
  readonly gutter = make("div", { class: "overlay", role: "group", "aria-label": "Locks" });
  private readonly hand: Hand;
  private readonly keys: KeyHandles;
  private readonly locks: LockHandles;
  private readonly marks: MarkHandles;
  private readonly groups: readonly { place(): void }[];

  constructor(
    private readonly store: Store,
    connection: Connection,
  ) {
    const hand = new Hand(store, connection);
    this.hand = hand;
    const tangents = new TangentHandles(hand);
    const end = new EndHandle(hand);
    const range = new RangeHandles(hand);
    // In the order of the tab key, keytimes and their speeds last: those are made as they come.
    const frame = new ChosenFrame(hand);
    this.marks = new MarkHandles(hand, this.overlay);
    this.overlay.append(...this.marks.ends, ...frame.elements, ...tangents.elements, end.element, ...range.elements);
    this.keys = new KeyHandles(hand, this.overlay);
    this.locks = new LockHandles(hand, this.gutter);
    this.groups = [
      this.marks,
      frame,
      this.keys,
      new SpeedHandles(hand, this.overlay),
      end,
      tangents,
      range,
      this.locks,
      new FlightHandles(hand, this.overlay),
    ];
  }

  /** Put everything where it belongs. */
  place(layout: Layout, scales: Scales): void {
    this.hand.layout = layout;
    this.hand.scales = scales;
    if (!this.store.document) return;
    const { map } = layout;
    const { style } = this.overlay;
    // Wider than the map by half a handle: keys at its edges keep their shape.
    style.left = `${map.x - MARGIN}px`;
    style.width = `${map.width + MARGIN + 10}px`;
    style.top = "0";
    style.height = `${layout.height}px`;
    this.gutter.style.left = `${map.x - 16}px`;
    this.gutter.style.width = "16px";
    this.gutter.style.top = `${map.y}px`;
    this.gutter.style.height = `${map.height}px`;
    for (const group of this.groups) group.place();
  }

  /** Snap an output time to markers and frames. */
  snapOutput(time: number, event?: { readonly altKey: boolean }): number {
    return this.hand.snapOutput(time, event);
  }

  /** Move what is selected by some frames: keytimes on both axes, a lock or a marker on its own. */
  nudge(frames: Shift): void {
    const { document, selection } = this.store;
    if (!document) return;
    if (selection?.kind === "marker") this.marks.nudge(selection.id, frames.output || frames.input);
    else if (selection?.kind === "lock") this.locks.nudge(selection.id, frames.input || frames.output);
    else this.keys.nudge(frames);
  }
}
