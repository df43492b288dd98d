/** Work that can wait until nothing else is to be done. */

export class WhenQuiet {
  private timer: ReturnType<typeof setTimeout> | undefined;
  /** When the work was asked for first that is not done yet. */
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

  /** It was done, or need not be done any more. */
  cancel(): void {
    clearTimeout(this.timer);
    this.since = null;
  }
}
