/** The rectangle that is drawn on the map to choose the keytimes in it; a mere click puts the playhead there. */

import { make } from "../dom";
import type { Store } from "../store";
import { keysInside } from "../together";
import type { Drag } from "./drag";
import { inputTimeAt, type Layout, outputTimeAt, type Scales } from "./layout";

export class ChooseBox {
  readonly root = make("div", { class: "choosebox", "aria-hidden": true, hidden: true });

  constructor(private readonly store: Store) {}

  /** Begin at a place of the map; with shift what was chosen stays so. `click` is called where nothing was drawn. */
  begin(
    down: PointerEvent,
    layout: Layout,
    scales: Scales,
    from: { readonly x: number; readonly y: number },
    click: () => void,
  ): Drag {
    const { store, root } = this;
    const before = store.chosenKeys;
    const selected = store.selection;
    const kept = down.shiftKey ? before : new Set<string>();
    const { map } = layout;
    return {
      move: (dx, dy) => {
        const { document } = store;
        if (!document) return;
        store.point(null);
        const [left, right] = ordered(from.x, from.x + dx, map.x, map.x + map.width);
        const [top, bottom] = ordered(from.y, from.y + dy, map.y, map.y + map.height);
        root.hidden = false;
        root.style.transform = `translate(${left}px, ${top}px)`;
        root.style.width = `${right - left}px`;
        root.style.height = `${bottom - top}px`;
        const inside = keysInside(document, {
          outputStart: outputTimeAt(layout, scales, left),
          outputEnd: outputTimeAt(layout, scales, right),
          inputStart: inputTimeAt(layout, scales, bottom),
          inputEnd: inputTimeAt(layout, scales, top),
        });
        store.chooseKeys([...kept, ...inside]);
      },
      end: (moved) => {
        root.hidden = true;
        if (moved) return;
        if (!down.shiftKey) store.select(null);
        click();
      },
      cancel: () => {
        root.hidden = true;
        if (selected?.kind === "key" || selected === null) store.chooseKeys(before, selected?.id);
        else store.select(selected);
      },
    };
  }
}

/** Two places in order, held between two bounds. */
function ordered(a: number, b: number, low: number, high: number): [number, number] {
  const held = (value: number): number => Math.min(Math.max(value, low), high);
  return a < b ? [held(a), held(b)] : [held(b), held(a)];
}
