/** The speeds that a hand can set. */

import { clamp } from "../../scale";

export const SLOWEST = 1 / 24;
export const FASTEST = 10;

/** Speeds that a hand sets have two digits after the point, or three below 1. */
export function roundSpeed(speed: number): number {
  const held = clamp(speed, SLOWEST, FASTEST);
  return held >= 1 ? Math.round(held * 100) / 100 : Math.round(held * 1000) / 1000;
}

/** A speed some steps of the keyboard away: eight steps double it. */
export function stepSpeed(speed: number, by: number): number {
  return roundSpeed(speed * 2 ** (by / 8));
}
