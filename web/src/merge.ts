/** What one window did, done again on what another window made meanwhile. */

import type { Document } from "./messages";

interface Named {
  readonly id: string;
}

/**
 * The difference from `base` to `mine`, applied to `theirs`: key by key, lock by lock, option by option. Where both
 * changed the same thing, it is as in `mine`.
 */
export function rebased(base: Document, mine: Document, theirs: Document): Document {
  const merged: Record<string, unknown> = {};
  const before = base as unknown as Record<string, unknown>;
  const now = theirs as unknown as Record<string, unknown>;
  for (const [name, value] of Object.entries(mine)) merged[name] = part(before[name], value, now[name]);
  return merged as unknown as Document;
}

function part(base: unknown, mine: unknown, theirs: unknown): unknown {
  if (same(base, mine)) return theirs;
  if ([base, mine, theirs].every(isListOfNamed)) return list(base as Named[], mine as Named[], theirs as Named[]);
  if ([base, mine, theirs].every(isPlain)) return fields(base as object, mine as object, theirs as object);
  return mine;
}

function list(base: readonly Named[], mine: readonly Named[], theirs: readonly Named[]): Named[] {
  const find = (all: readonly Named[], id: string): Named | undefined => all.find((one) => one.id === id);
  const changed = mine.filter((one) => !same(find(base, one.id), one));
  const removed = new Set(base.filter((one) => !find(mine, one.id)).map((one) => one.id));
  const kept = theirs.filter((one) => !removed.has(one.id)).map((one) => find(changed, one.id) ?? one);
  return [...kept, ...changed.filter((one) => !find(kept, one.id))];
}

function fields(base: object, mine: object, theirs: object): object {
  const before = base as Record<string, unknown>;
  const made = { ...theirs } as Record<string, unknown>;
  const own = mine as Record<string, unknown>;
  for (const name of new Set([...Object.keys(base), ...Object.keys(mine)])) {
    if (same(before[name], own[name])) continue;
    if (name in own) made[name] = own[name];
    else delete made[name];
  }
  return made;
}

function isPlain(value: unknown): boolean {
  return typeof value === "object" && value !== null && !Array.isArray(value);
}

function isListOfNamed(value: unknown): boolean {
  return Array.isArray(value) && value.every((one) => isPlain(one) && typeof (one as Named).id === "string");
}

/** Both come of the same program, so their fields are in the same order. */
function same(a: unknown, b: unknown): boolean {
  return a === b || JSON.stringify(a) === JSON.stringify(b);
}
