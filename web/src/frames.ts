/** One frame of the browser after the other, while there is something to draw. */

import type { Player } from "./player";
import type { Store, Topic } from "./store";
import type { Theme } from "./theme";

export class Frames {
  private asked = false;

  /** `draw` is called with what changed since the last frame; `drawn` after a frame that drew, with when it began. */
  constructor(
    private readonly store: Store,
    private readonly theme: Theme,
    private readonly player: Player,
    private readonly draw: (changed: Set<Topic>) => void,
    private readonly drawn: (began: number) => void = () => undefined,
  ) {}

  /** Have the next frame drawn. */
  ask(): void {
    if (this.asked) return;
    this.asked = true;
    requestAnimationFrame((now) => this.next(now));
  }

  private next(now: number): void {
    const { store, theme, player } = this;
    const began = performance.now();
    if (!theme.styled) theme.refresh();
    if (theme.styled) {
      player.goOn(now);
      if (store.hasChanged("curve")) player.stayInside();
    }
    // What changes from here on waits for the next frame.
    this.asked = false;
    if (!theme.styled) return this.ask();
    const changed = store.take();
    if (changed.size > 0) {
      this.draw(changed);
      this.drawn(began);
    }
    if (player.isPlaying) this.ask();
  }
}
