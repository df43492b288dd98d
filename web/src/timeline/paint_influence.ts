/** A drag along the row of influence paints it. */

import type { Connection } from "../connection";
import { painted, type Spot } from "../influence";
import { clamp } from "../scale";
import type { Store } from "../store";
import { outputEnd } from "../warp";
import type { Drag } from "./drag";
import { type Layout, outputTimeAt, type Scales } from "./layout";

/** Pixels from a stroke to where all is as it was: at once, the output would jump from one curve to the other. */
const EDGE = 28;

export function paintInfluence(
  store: Store,
  connection: Connection,
  layout: Layout,
  scales: Scales,
  down: { readonly x: number; readonly y: number },
): Drag {
  const box = layout.influence;
  const gesture = connection.newGesture();
  const before = store.document;
  const end = store.knots ? outputEnd(store.knots) : 0;
  const edge = outputTimeAt(layout, scales, box.x + EDGE) - outputTimeAt(layout, scales, box.x);
  const spot = (dx: number, dy: number): Spot => ({
    time: clamp(outputTimeAt(layout, scales, down.x + dx), 0, end),
    share: clamp(1 - (down.y + dy - box.y - 2) / (box.height - 4), 0, 1),
  });
  let last = spot(0, 0);
  let latest = before;
  return {
    move(dx, dy, event) {
      if (!latest) return;
      store.beginDrag();
      const next = spot(dx, dy);
      latest = painted(latest, last, next, end, edge);
      last = next;
      connection.edit(latest, "paint influence", gesture, false, event.timeStamp);
    },
    end(moved) {
      store.endDrag();
      if (moved && latest) connection.edit(latest, "paint influence", gesture, true);
    },
    cancel() {
      store.endDrag();
      if (before && latest !== before) connection.edit(before, "paint influence", gesture, true);
    },
  };
}
