/** What each key does: one table, which the list of shortcuts shows too. */

import type { Connection } from "../connection";
import { deleteSelected } from "../deleting";
import { clearWorkArea, setWorkArea } from "../markers";
import type { Dialogs } from "../panels/dialogs/dialogs";
import type { Player } from "../player";
import type { Shortcut } from "../shortcuts";
import type { Store } from "../store";
import type { Timeline } from "../timeline/timeline";
import { nextUnits } from "../units";
import { outputEnd } from "../warp";

type Plain = Omit<Shortcut, "group">;

function grouped(group: string, shortcuts: readonly Plain[]): Shortcut[] {
  return shortcuts.map((one) => ({ ...one, group }));
}

export interface Actions {
  save(): void;
  help(): void;
  /** Play the other of two warps that are compared. */
  swap(): void;
  /** Put the keytimes that were copied last at their own times. */
  pasteInPlace(): void;
}

/** What the hand does, for the list of shortcuts. */
export const BY_HAND: readonly (readonly [string, string])[] = [
  ["Double-click the map", "Add a keytime"],
  ["Right button, anywhere", "What can be done there"],
  ["Drag on the map", "Choose the keytimes in a box; with Shift, more of them"],
  ["Shift+click a keytime", "Choose it too, or not any more"],
  ["Shift while dragging", "Move a keytime along one axis"],
  ["Alt while dragging", "Turn snapping off, or on"],
  ["Drag the input times", "Lock a span"],
  ["Drag along the feet", "Mark a flight"],
  ["Scroll, Shift+scroll", "Zoom, move along"],
  ["Tab to a keytime, arrows", "Move it by a frame, with Shift by ten"],
  ["Double-click a speed", "Set it free again"],
  ["Double-click the ruler", "Put a marker"],
  ["Drag across a field", "Change its value; with Shift, ten times as fast"],
  ["Esc while dragging", "Cancel the drag"],
  ["Ctrl+C, Ctrl+X, Ctrl+V", "Copy, cut, paste keytimes at the playhead"],
];

function chooseAll(store: Store): void {
  store.chooseKeys(
    store.document?.keys.map((key) => key.id) ?? [],
    store.selection?.kind === "key" ? store.selection.id : null,
  );
}

export function shortcutTable(
  store: Store,
  connection: Connection,
  player: Player,
  timeline: Timeline,
  dialogs: Dialogs,
  actions: Actions,
): readonly Shortcut[] {
  const playing: Plain[] = [
    { keys: ["Space"], does: "Play, pause", action: () => player.toggle() },
    { keys: ["J"], does: "Play backward; again, faster", action: () => player.shuttle(-1) },
    { keys: ["K"], does: "Stop", action: () => player.stop() },
    { keys: ["L"], does: "Play; again, faster", action: () => player.shuttle(1) },
    { keys: ["ArrowLeft"], does: "A frame back", action: () => player.step(-1) },
    { keys: ["ArrowRight"], does: "A frame on", action: () => player.step(1) },
    { keys: ["Shift+ArrowLeft"], does: "Ten frames back", action: () => player.step(-10) },
    { keys: ["Shift+ArrowRight"], does: "Ten frames on", action: () => player.step(10) },
    { keys: ["ArrowUp"], does: "To the next keytime", action: () => player.toKey(1) },
    { keys: ["ArrowDown"], does: "To the keytime before", action: () => player.toKey(-1) },
    { keys: ["Ctrl+ArrowRight"], does: "To the next marker", action: () => player.toMarker(1) },
    { keys: ["Ctrl+ArrowLeft"], does: "To the marker before", action: () => player.toMarker(-1) },
    { keys: ["Home"], does: "To the beginning", action: () => player.toEdge("start") },
    { keys: ["End"], does: "To the end", action: () => player.toEdge("end") },
  ];
  const bound = (side: "start" | "end"): void => {
    const { document, knots, playback } = store;
    if (document && knots)
      connection.edit(setWorkArea(document, side, playback.outputTime, outputEnd(knots)), "set work area");
  };
  const editing: Plain[] = [
    { keys: ["I"], does: "Keytime at the playhead", action: () => timeline.addKeyAt(store.playback.outputTime) },
    {
      keys: ["Delete", "Backspace"],
      does: "Delete what is selected",
      action: () => deleteSelected(store, connection),
    },
    { keys: ["Ctrl+A"], does: "Choose all keytimes", action: () => chooseAll(store) },
    { keys: ["Alt+ArrowLeft"], does: "What is chosen a frame earlier", action: () => timeline.nudge(-1, 0) },
    { keys: ["Alt+ArrowRight"], does: "What is chosen a frame later", action: () => timeline.nudge(1, 0) },
    { keys: ["Alt+ArrowUp"], does: "What is chosen shows a later frame", action: () => timeline.nudge(0, 1) },
    { keys: ["Alt+ArrowDown"], does: "What is chosen shows an earlier frame", action: () => timeline.nudge(0, -1) },
    { keys: ["Alt+Shift+ArrowLeft"], does: "Ten frames earlier", action: () => timeline.nudge(-10, 0) },
    { keys: ["Alt+Shift+ArrowRight"], does: "Ten frames later", action: () => timeline.nudge(10, 0) },
    {
      keys: ["R"],
      does: "Ripple: what follows a moved keytime moves along",
      action: () => store.look({ ripple: !store.view.ripple }),
    },
    {
      keys: ["Ctrl+Shift+V"],
      does: "Paste keytimes at their own times (Ctrl+V: at the playhead)",
      action: () => actions.pasteInPlace(),
    },
    { keys: ["Escape"], does: "Stop the search", action: () => connection.stop() },
    { keys: ["M"], does: "Marker at the playhead", action: () => timeline.mark("output", store.playback.outputTime) },
    {
      keys: ["Shift+M"],
      does: "Marker on the pose that is shown",
      action: () => timeline.mark("input", store.shownInput(store.playback.outputTime)),
    },
    { keys: ["Shift+I"], does: "Work area begins at the playhead", action: () => bound("start") },
    { keys: ["Shift+O"], does: "Work area ends at the playhead", action: () => bound("end") },
    {
      keys: ["Shift+X"],
      does: "Work on all of the output again",
      action: () => {
        if (store.document?.work_area) connection.edit(clearWorkArea(store.document), "clear work area");
      },
    },
    { keys: ["Ctrl+Z"], does: "Undo", action: () => connection.undo() },
    { keys: ["Ctrl+Shift+Z", "Ctrl+Y"], does: "Redo", action: () => connection.redo() },
  ];
  const looking: Plain[] = [
    { keys: ["B"], does: "A or B: this warp, or the compared one", action: () => actions.swap() },
    { keys: ["C"], does: "Play by the other clock", action: () => player.otherClock() },
    {
      keys: ["V"],
      does: "Side by side, or overlaid",
      action: () => store.look({ layout: store.view.layout === "side" ? "over" : "side" }),
    },
    { keys: ["T"], does: "Trails", action: () => store.look({ trails: !store.view.trails }) },
    { keys: ["O"], does: "Onion skins", action: () => store.look({ onion: !store.view.onion }) },
    { keys: ["G"], does: "The matched pose", action: () => store.look({ ghost: !store.view.ghost }) },
    { keys: ["+", "="], does: "Zoom in", action: () => timeline.zoomBy(0.7) },
    { keys: ["-"], does: "Zoom out", action: () => timeline.zoomBy(1 / 0.7) },
    { keys: ["U"], does: "Seconds, frames, timecode", action: () => store.look({ units: nextUnits(store) }) },
    { keys: ["F"], does: "Show all of the output", action: () => timeline.fit() },
  ];
  const files: Plain[] = [
    { keys: ["Ctrl+S"], does: "Save", action: () => actions.save() },
    { keys: ["Ctrl+Shift+S"], does: "Save under another name", action: () => dialogs.showSave() },
    { keys: ["Ctrl+O"], does: "Open", action: () => dialogs.showOpen() },
    { keys: ["Ctrl+E"], does: "Export", action: () => dialogs.showExport() },
    { keys: ["?"], does: "This list", action: () => actions.help() },
  ];
  return [
    ...grouped("Playing", playing),
    ...grouped("Editing", editing),
    ...grouped("Looking", looking),
    ...grouped("Files and help", files),
  ];
}
