/** Fetches what the document names beside the stage: the sound for its waveform, and beats. */

import type { Document } from "../messages";
import type { Store, Topic } from "../store";
import type { Beats } from "./beside";
import { peaksOf } from "./peaks";

/** Bytes of a file whose sound is decoded in the page, and samples a second that are enough to draw it. */
const MOST_BYTES = 256 << 20;
const DRAWN_RATE = 22_050;

export class MediaLoader {
  private media: string | null = null;
  private beats: string | null = null;
  /** What is fetched for a document that names something else by now is dropped. */
  private mediaEnds = new AbortController();
  private beatsEnds = new AbortController();

  /** `ready` is called with the address of media that can be fetched, or null where there are none any more. */
  constructor(
    private readonly store: Store,
    private readonly ready: (address: string | null) => void,
  ) {}

  update(changed: Set<Topic>): void {
    if (!changed.has("status")) return;
    // Only what the server has confirmed: it gives what its own document names.
    const document = this.store.state?.document;
    if (!document) return;
    const media = document.media?.path ?? null;
    if (media !== this.media) {
      this.media = media;
      void this.loadMedia(media);
    }
    const beats = beatsKey(document);
    if (beats !== this.beats) {
      this.beats = beats;
      void this.loadBeats(beats);
    }
  }

  private async loadMedia(path: string | null): Promise<void> {
    this.mediaEnds.abort();
    this.mediaEnds = new AbortController();
    const { signal } = this.mediaEnds;
    const { store } = this;
    store.setBeside({ peaks: null, mediaTrouble: null });
    this.ready(null);
    if (path === null) return;
    try {
      const address = `/media?of=${encodeURIComponent(path)}`;
      const first = await fetch(address, { headers: { Range: "bytes=0-0" }, signal });
      if (!first.ok) throw new Error(await first.text());
      this.ready(address);
      const size = Number(/\/(\d+)$/u.exec(first.headers.get("content-range") ?? "")?.[1] ?? 0);
      if (size > MOST_BYTES) return;
      const data = await (await fetch(address, { signal })).arrayBuffer();
      const sound = await decoded(data);
      if (signal.aborted || !sound) return;
      const channels = Array.from({ length: sound.numberOfChannels }, (_, i) => sound.getChannelData(i));
      store.setBeside({ peaks: peaksOf(channels, sound.sampleRate) });
    } catch (error) {
      if (!signal.aborted) store.setBeside({ mediaTrouble: wordsOf(error) });
    }
  }

  private async loadBeats(key: string | null): Promise<void> {
    this.beatsEnds.abort();
    this.beatsEnds = new AbortController();
    const { signal } = this.beatsEnds;
    const { store } = this;
    store.setBeside({ beats: null, beatsTrouble: null, listening: key !== null });
    if (key === null) return;
    try {
      const answer = await fetch("/beats", { signal });
      if (!answer.ok) throw new Error(await answer.text());
      const beats = (await answer.json()) as Beats;
      if (!signal.aborted) store.setBeside({ beats, listening: false });
    } catch (error) {
      if (!signal.aborted) store.setBeside({ beatsTrouble: wordsOf(error), listening: false });
    }
  }
}

/** What beats depend on: of the media's own sound, on which media those are. */
function beatsKey({ beats, media }: Document): string | null {
  return beats && JSON.stringify([beats, beats.path === null ? media?.path : null]);
}

/** The sound of a file; null where it has none, or none that this browser decodes. */
async function decoded(data: ArrayBuffer): Promise<AudioBuffer | null> {
  try {
    return await new OfflineAudioContext(1, 1, DRAWN_RATE).decodeAudioData(data);
  } catch (error) {
    if (error instanceof DOMException) return null;
    throw error;
  }
}

function wordsOf(error: unknown): string {
  return error instanceof Error ? error.message : String(error);
}
