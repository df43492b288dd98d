/** Lines of many points, drawn through as few as look the same. */

/** What a line is drawn on. */
export interface Pen {
  lineTo(x: number, y: number): void;
}

/** Pixels: less than what smoothed edges show. */
const TOLERANCE = 0.15;
/** Points closer than this stand above each other. */
const UPRIGHT = 1e-6;

/**
 * Draws a line from point to point, left to right, without the points that the rest of it passes by a hair.
 *
 * To draw a line of a thousand pieces by the processor takes milliseconds, however short they are. From the last point
 * drawn, the slopes are kept that pass all points since closely enough; a point outside them begins another piece.
 */
export class ThinLine {
  private n = 0;
  /** The last point drawn, the last one given, and the slopes between the first and what the points since allow. */
  private fromX = 0;
  private fromY = 0;
  private lastX = 0;
  private lastY = 0;
  private least = -Infinity;
  private most = Infinity;

  constructor(private readonly pen: Pen) {}

  to(x: number, y: number): void {
    if (this.n++ === 0) this.draw(x, y);
    else {
      const wide = x - this.fromX;
      if (wide < UPRIGHT) {
        if (Math.abs(y - this.fromY) > TOLERANCE) this.draw(x, y);
      } else {
        const slope = (y - this.fromY) / wide;
        if (slope < this.least || slope > this.most) {
          this.draw(this.lastX, this.lastY);
          this.widen(x, y);
        } else this.narrow(y, wide);
      }
    }
    this.lastX = x;
    this.lastY = y;
  }

  /** Draw the last point. */
  end(): void {
    if (this.n > 1) this.pen.lineTo(this.lastX, this.lastY);
  }

  private draw(x: number, y: number): void {
    this.pen.lineTo(x, y);
    this.fromX = x;
    this.fromY = y;
    this.least = -Infinity;
    this.most = Infinity;
  }

  /** Go on to a point from one that was just drawn. */
  private widen(x: number, y: number): void {
    const wide = x - this.fromX;
    if (wide < UPRIGHT) this.draw(x, y);
    else this.narrow(y, wide);
  }

  private narrow(y: number, wide: number): void {
    this.least = Math.max(this.least, (y - TOLERANCE - this.fromY) / wide);
    this.most = Math.min(this.most, (y + TOLERANCE - this.fromY) / wide);
  }
}
