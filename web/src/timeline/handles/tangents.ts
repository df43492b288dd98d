/** The ends of the line through the chosen keytime, whose slope is the speed there. */

import { changeKey, findKey } from "../../document";
import type { Document, Key } from "../../messages";
import { inputY, tangentArm } from "../layout";
import { describe, move } from "./elements";
import type { Hand } from "./hand";
import { FASTEST, roundSpeed, SLOWEST, stepSpeed } from "./speed_range";

/** Before the keytime, or after it. */
type Side = -1 | 1;

const SIDES: readonly Side[] = [-1, 1];

export class TangentHandles {
  readonly elements: readonly HTMLElement[];

  constructor(private readonly hand: Hand) {
    this.elements = SIDES.map((side) => this.make(side));
  }

  place(): void {
    const { hand } = this;
    const { layout, scales } = hand;
    const { map } = layout;
    const key = this.chosen;
    this.elements.forEach((handle, i) => {
      if (!key) {
        move(handle, 0, 0, false);
        return;
      }
      const side = SIDES[i] as Side;
      const speed = this.speedOf(key);
      const [dx, dy] = tangentArm(layout, scales, speed);
      const x = hand.overlayX(key.output_time) + side * dx;
      const y = inputY(layout, scales, key.input_time) + side * dy;
      move(handle, x, y, x > 12 && x < map.width + 16 && y > map.y && y < map.y + map.height);
      describe(handle, speed, SLOWEST, FASTEST, `${speed.toFixed(2)} times`);
    });
  }

  private get chosen(): Key | null {
    const { document, selection, chosenKeys } = this.hand.store;
    if (chosenKeys.size > 1) return null;
    return selection?.kind === "key" && document ? findKey(document, selection.id) : null;
  }

  private speedOf(key: Key): number {
    return key.speed ?? this.hand.curveSpeed(key.output_time);
  }

  private make(side: Side): HTMLElement {
    const { hand } = this;
    const set = (id: string, speed: number): Document => changeKey(hand.document, id, { speed });
    return hand.slider(
      "handle tangent",
      side < 0 ? "Tangent before the keytime" : "Tangent after the keytime",
      () => {
        const key = this.chosen;
        if (!key) return null;
        const [armX, armY] = tangentArm(hand.layout, hand.scales, this.speedOf(key));
        return hand.gesture("set speed at key", (dx, dy) => {
          const { map } = hand.layout;
          const { output, input } = hand.scales;
          // The arm stays on its side of the keytime: there is no slope straight up, or back.
          const right = Math.max(armX + side * dx, 1);
          const down = armY + side * dy;
          const seconds = (right / map.width) * (output.to - output.from);
          const speed = ((-down / map.height) * (input.to - input.from)) / seconds;
          return set(key.id, roundSpeed(speed));
        });
      },
      (by) => {
        const key = this.chosen;
        if (key) hand.nudge(`${key.id} speed`, set(key.id, stepSpeed(this.speedOf(key), by)), "set speed at key");
      },
    );
  }
}
