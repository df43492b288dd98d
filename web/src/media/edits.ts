/** Edits of what stands beside the stage. */

import type { BeatsFile, Document, MediaFile } from "../messages";

const PLAIN: MediaFile = { path: "", offset: null, clock: "input" };

/** Change the media, or take them away; beats of their sound go with them. */
export function setMedia(document: Document, change: Partial<MediaFile> | null): Document {
  if (change === null) {
    const beats = document.beats?.path == null ? null : document.beats;
    return { ...document, media: null, beats };
  }
  return { ...document, media: { ...(document.media ?? PLAIN), ...change } };
}

export function setBeats(document: Document, beats: BeatsFile | null): Document {
  return { ...document, beats };
}
