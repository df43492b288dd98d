/** Clips that belong together: of lengths that differ, and where all of them are written. */

import { changeClip } from "./document";
import type { Clip, Document } from "./messages";

/** Where each clip of a group is written: its name in the place of the star, and its own ending. */
export function groupPaths(pattern: string, sources: readonly string[]): string[] {
  const taken = new Set<string>();
  return sources.map((source) => {
    const [, stem = "clip", ending = ""] = /([^\\/]*?)(\.[^.\\/]+)?$/u.exec(source) ?? [];
    let path = "";
    for (let n = 1; path === "" || taken.has(path); n++) {
      path = `${pattern.replace("*", () => (n === 1 ? stem : `${stem}-${n}`))}${ending}`;
    }
    taken.add(path);
    return path;
  });
}

/** Time of a clip's last frame, seconds. */
export function endOf({ n_frames, rate }: Clip): number {
  return (n_frames - 1) / rate;
}

/** The clips that end so much later than the first one, seconds; those that end with it are left out. */
export function apart(clips: readonly Clip[]): { readonly index: number; readonly seconds: number }[] {
  const [first] = clips;
  if (!first) return [];
  return clips.slice(1).flatMap((clip, i) => {
    const seconds = endOf(clip) - endOf(first);
    const long = Math.abs(clip.n_frames / clip.rate - first.n_frames / first.rate);
    // As the server has it: files of other rates that last as long, or end together, are as long.
    const least = 0.5 / Math.min(clip.rate, first.rate);
    return Math.min(Math.abs(seconds), long) > least * (1 + 1e-9) ? [{ index: i + 1, seconds }] : [];
  });
}

/** Put a clip so that it ends with the first one. */
export function endTogether(document: Document, clips: readonly Clip[], index: number): Document {
  const [first, clip] = [clips[0], clips[index]];
  if (!first || !clip) return document;
  return changeClip(document, index, { offset: `${Number((endOf(first) - endOf(clip)).toFixed(6))}s` });
}

/** Use of every clip only what the shortest has; clips that were put elsewhere are left alone. */
export function trimTogether(document: Document, clips: readonly Clip[]): Document {
  const end = Math.min(...clips.map(endOf));
  return clips.reduce((trimmed, clip, i) => {
    const last = Math.round(end * clip.rate);
    if (last >= clip.n_frames - 1 || document.clips[i]?.offset != null) return trimmed;
    return changeClip(trimmed, i, { last_frame: clip.first_frame + last });
  }, document);
}
