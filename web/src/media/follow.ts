/** How a player of media keeps up with the playhead. */

/** What the player is to do now. */
export interface Step {
  /** Play at this speed; null: stand. */
  readonly speed: number | null;
  /** Go to this time first; null: stay. */
  readonly seek: number | null;
}

/** Speeds that browsers play. */
const SLOWEST = 0.0625;
const FASTEST = 16;
/** A player that is so far off, in seconds, jumps; nearer ones hurry or wait, to be right so many seconds later. */
const JUMP = 0.2;
const CATCH_UP = 0.5;
/** Browsers show the frame before where a time is a rounding too early. */
export const ROUNDING = 0.001;
/** So long before the end the last picture is surely on; no picture is as short. */
const LAST = 0.004;

/**
 * While it plays: go on at the speed that the media pass with. What can't be played (holds, backward, too fast) is
 * scrubbed, frame by frame, in silence.
 *
 * @param now where the player is
 * @param wanted where it should be
 * @param speed seconds of media a second, as the warp and the playhead have it
 * @param end how long the media are
 */
export function followed(now: number, wanted: number, speed: number, end: number): Step {
  const inside = within(wanted, end);
  if (wanted < 0 || wanted > end || speed < SLOWEST || speed > FASTEST) return stand(now, inside);
  const off = now - wanted;
  if (Math.abs(off) > JUMP) return { speed, seek: wanted };
  return { speed: Math.min(Math.max(speed - off / CATCH_UP, SLOWEST), FASTEST), seek: null };
}

/** The nearest moment that has a picture: at the very end browsers show none, or one from elsewhere. */
export function within(wanted: number, end: number): number {
  return Math.max(Math.min(wanted, end - LAST), 0);
}

/** While it stands: show the very frame. */
export function stand(now: number, wanted: number): Step {
  const at = wanted + ROUNDING;
  return { speed: null, seek: Math.abs(now - at) < ROUNDING / 2 ? null : at };
}
