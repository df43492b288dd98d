/** What of the document is looked at, and how; most of it the browser remembers. */

import { recall, remember } from "./memory";
import type { Navigation } from "./stage/navigation";
import type { Units } from "./units";

/** What is compared with the output. */
export type Companion = "input" | "linear" | "spline" | { readonly kept: string };

export interface ViewSettings {
  readonly layout: "side" | "over";
  readonly companion: Companion;
  /** The output figure plays the companion's warp instead. */
  readonly showB: boolean;
  readonly follow: boolean;
  readonly ground: boolean;
  readonly trails: boolean;
  readonly onion: boolean;
  /** The character's own mesh is shown, where its file has one. */
  readonly mesh: boolean;
  /** The pose that the frame was matched with is laid over the output's at the playhead too, not only under the pointer. */
  readonly ghost: boolean;
  readonly snap: boolean;
  /** What follows a keytime that is moved is moved along. */
  readonly ripple: boolean;
  /** Keytimes that are dragged near a beat land on it. */
  readonly snapBeats: boolean;
  /** The sound beside the stage is heard while it plays. */
  readonly heard: boolean;
  readonly units: Units;
  /** Which program's mouse buttons turn the stage. */
  readonly navigation: Navigation;
  /** Which clip of a group the camera follows, or which signal is drawn. */
  readonly clip: number;
  /** The stage is seen through the group's camera. */
  readonly through: boolean;
  /** The row where influence is painted over time is shown, though it is the same everywhere. */
  readonly paintsInfluence: boolean;
  /** Which reference is looked at. */
  readonly reference: number;
}

export const PLAIN_VIEW: ViewSettings = {
  layout: "side",
  companion: "input",
  showB: false,
  follow: true,
  ground: true,
  trails: false,
  onion: false,
  ghost: false,
  mesh: true,
  snap: true,
  ripple: false,
  snapBeats: true,
  heard: true,
  units: "seconds",
  navigation: "retime",
  clip: 0,
  through: false,
  paintsInfluence: false,
  reference: 0,
};

const STORED = "retime.view";

/** The settings of the last time. */
export function recallView(): ViewSettings {
  try {
    const found: unknown = JSON.parse(recall(STORED) ?? "{}");
    return { ...PLAIN_VIEW, ...(typeof found === "object" ? found : {}) };
  } catch {
    // What is stored was written by another program, or cut.
    return PLAIN_VIEW;
  }
}

/** Remember how it is looked at; what belongs to one document alone is not for the next. */
export function rememberView(view: ViewSettings): void {
  const { layout, follow, ground, trails, onion, ghost, mesh, snap, snapBeats, heard, units, navigation } = view;
  const kept = { layout, follow, ground, trails, onion, ghost, mesh, snap, snapBeats, heard, units, navigation };
  remember(STORED, JSON.stringify(kept));
}
