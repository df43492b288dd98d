/** Work that can wait for a quiet moment. */

export class WhenQuiet {
  private timer: ReturnType<typeof setTimeout> | undefined;
  /** When the work that is still to be done was first asked for. */
  private since: number | null = null;

  /** `run` is called `rest` milliseconds after it was asked for last, and `most` after it was asked for first. */
  constructor(
    private readonly run: () => void,
    private readonly rest: number,
    private readonly most: number,
  ) {}

  ask(): void {
    const now = performance.now();
    this.since ??= now;
    clearTimeout(this.timer);
    const work = (): void => {
      this.since = null;
      this.run();
    };
    this.timer = setTimeout(work, Math.max(0, Math.min(this.rest, this.since + this.most - now)));
  }

  /** Forget the work: it was done, or is not needed any more. */
  cancel(): void {
    clearTimeout(this.timer);
    this.since = null;
  }
}
