/** Words about what can't be done, beside the keytime, the lock or the reference at fault. */

import { findKey, findLock } from "../document";
import { make, setText } from "../dom";
import type { Problem } from "../messages";
import type { Store } from "../store";
import { inputY, type Layout, outputX, type Scales } from "./layout";

export class TroubleNote {
  readonly root = make("div", { class: "trouble", role: "alert", hidden: true });

  constructor(private readonly store: Store) {}

  update(layout: Layout, scales: Scales): void {
    const { store, root } = this;
    const { problem } = store;
    // Without a clip there is nothing to point at; what lies over all of it says it.
    root.hidden = problem === null || store.clip === null;
    if (!problem || root.hidden) return;
    setText(root, problem.message);
    const { x, y } = this.placeOf(problem, layout, scales);
    const { offsetWidth, offsetHeight } = root;
    const right = x + 18 + offsetWidth < layout.width - 8;
    const top = Math.max(layout.map.y + 4, y - offsetHeight / 2);
    root.style.left = `${Math.max(8, right ? x + 18 : x - 18 - offsetWidth)}px`;
    root.style.top = `${Math.min(top, layout.height - offsetHeight - 6)}px`;
  }

  /** Pixels to what is at fault; where it is not on the timeline, a corner of the map. */
  private placeOf(problem: Problem, layout: Layout, scales: Scales): { x: number; y: number } {
    const { document } = this.store;
    const x = layout.map.x + 6;
    const key = document && findKey(document, problem.key);
    if (key) return { x: outputX(layout, scales, key.output_time), y: inputY(layout, scales, key.input_time) };
    const lock = document && findLock(document, problem.lock);
    if (lock) return { x, y: inputY(layout, scales, (lock.start + lock.end) / 2) };
    return { x, y: problem.reference === null ? layout.map.y + 26 : layout.reference.y };
  }
}
