/** Files from elsewhere, dropped on the page or picked: sent to the server, and then opened or added. */

import type { Connection } from "../connection";
import { addClip } from "../document";
import type { Browse, Document } from "../messages";
import { addReference } from "../references";
import type { Store } from "../store";
import type { NoticeKind } from "./notices";

/** Sends a file to the server; says where it is there. */
export type Upload = (file: File) => Promise<string>;

/** What a file is for: what it has to hold, and who takes its path. */
export interface Taker {
  readonly holds: Browse["holds"];
  take(path: string): void;
}

/** Takes files, and hands on the path of the one that is a clip or a project; without a taker it is opened. */
export type TakeFiles = (files: readonly File[], taker?: Taker) => void;

/** Make what sends files. */
export function fileSender(
  upload: Upload,
  say: (kind: NoticeKind, text: string) => void,
  /** What is done with a file that nobody takes. */
  open: (path: string) => void,
  /** Has a clip read, before it is taken. */
  check: (path: string, take: (place: string) => void) => void,
): TakeFiles {
  const send = async (files: readonly File[], take: (path: string) => void): Promise<void> => {
    try {
      // An AMC may bring its ASF along, which has to be there first.
      for (const file of [...files].sort((a, b) => Number(isSkeleton(b)) - Number(isSkeleton(a)))) {
        const path = await upload(file);
        if (isSkeleton(file)) say("info", `${file.name} is here; now drop the AMC that moves it.`);
        else return take(path);
      }
    } catch (error) {
      say("error", error instanceof Error ? error.message : String(error));
    }
  };
  return (files, taker) =>
    void send(files, (path) => {
      if (!taker) open(path);
      else if (taker.holds !== "clip") taker.take(path);
      else check(path, (place) => taker.take(place));
    });
}

function isSkeleton(file: File): boolean {
  return file.name.toLowerCase().endsWith(".asf");
}

/** Take files that are dropped: on the references or the clips one more of them, elsewhere they are opened. */
export function listenForDrops(
  root: HTMLElement,
  store: Store,
  connection: Connection,
  send: TakeFiles,
  dropped: (event: DragEvent) => void,
  signal: AbortSignal,
): void {
  const edit = (change: (document: Document) => Document, label: string): void => {
    if (store.document) connection.edit(change(store.document), label);
  };
  const takers: Record<string, Taker> = {
    References: {
      holds: "clip",
      take: (path) => edit((document) => addReference(document, path), "add reference"),
    },
    Clips: { holds: "clip", take: (path) => edit((document) => addClip(document, path), "add clip") },
  };
  // Every element that the pointer enters says so, before the one that it leaves does.
  let depth = 0;
  const over = (by: number): void => {
    depth = Math.max(0, depth + by);
    root.classList.toggle("dropping", depth > 0);
  };
  root.addEventListener("dragenter", () => over(1), { signal });
  root.addEventListener("dragleave", () => over(-1), { signal });
  root.addEventListener("dragover", (event) => event.preventDefault(), { signal });
  root.addEventListener(
    "drop",
    (event) => {
      event.preventDefault();
      over(-depth);
      dropped(event);
      const section = event.target instanceof Element ? event.target.closest("section") : null;
      send([...(event.dataTransfer?.files ?? [])], takers[section?.getAttribute("aria-label") ?? ""]);
    },
    { signal },
  );
}
