/** What the right mouse button offers, wherever it is pressed. */

import type { Connection } from "../connection";
import { deleteItem, deleteSelected } from "../deleting";
import { changeKey, changeLock, findKey, findLock, setOption } from "../document";
import { findFlight } from "../flights";
import { clearWorkArea, findMarker, setWorkArea } from "../markers";
import { setMedia } from "../media/edits";
import type { Dialogs } from "../panels/dialogs/dialogs";
import type { Player } from "../player";
import { snapped } from "../scale";
import { cameraOf } from "../stage/cameras";
import { NAVIGATIONS } from "../stage/navigation";
import { hasSkin } from "../stage/skinned";
import type { Stage } from "../stage/stage";
import type { Store } from "../store";
import type { Timeline } from "../timeline/timeline";
import { changeKeys } from "../together";
import { said } from "../units";
import { outputEnd } from "../warp";
import { Menu, type MenuGroups, type MenuItem } from "./menu";

export interface Places {
  readonly store: Store;
  readonly connection: Connection;
  readonly player: Player;
  readonly timeline: Timeline;
  readonly stage: Stage;
  readonly dialogs: Dialogs;
  readonly save: () => void;
  readonly help: () => void;
}

/** A hand that clicks trembles. */
const SLACK = 4;

/** Listen for the right button (and the menu key); returns what ends it. */
export function listenForMenus(root: HTMLElement, places: Places): () => void {
  const menu = new Menu();
  root.append(menu.root);
  const ends = new AbortController();
  const { signal } = ends;
  /** Where the right button went down on the stage: a drag there turns the view, a click asks for the menu. */
  let down: { x: number; y: number } | null = null;
  const open = (event: MouseEvent): void => {
    const target = event.target instanceof Element ? event.target : root;
    const groups = places.store.document ? groupsFor(target, event.clientX, places) : null;
    if (groups) menu.open(event.clientX, event.clientY, groups);
  };
  root.addEventListener(
    "pointerdown",
    (event) => {
      if (menu.isOpen && !menu.root.contains(event.target as Node)) menu.close();
      const isStage = event.target instanceof Element && event.target.matches(".stage canvas");
      down = event.button === 2 && isStage ? { x: event.clientX, y: event.clientY } : null;
    },
    { signal, capture: true },
  );
  root.addEventListener(
    "contextmenu",
    (event) => {
      // Where something is typed or read the browser's own menu copies and pastes.
      if (event.target instanceof Element && event.target.closest("input, textarea, dialog, .notice, .refused")) return;
      event.preventDefault();
      if (!down) open(event);
    },
    { signal },
  );
  window.addEventListener(
    "pointerup",
    (event) => {
      const began = down;
      down = null;
      if (!began || event.button !== 2 || event.altKey) return;
      if (Math.hypot(event.clientX - began.x, event.clientY - began.y) < SLACK) open(event);
    },
    { signal },
  );
  window.addEventListener("blur", () => menu.close(), { signal });
  return () => ends.abort();
}

/** What is offered at an element; the thing that was pointed at is chosen first. */
function groupsFor(target: Element, x: number, places: Places): MenuGroups {
  const handle = target.closest<HTMLElement>(".handle");
  if (handle) handle.focus({ preventScroll: true });
  const own = handle ? handleItems(places) : null;
  if (own) return [...own, mapItems(x, places), common(places)];
  if (target.closest(".timeline")) return [mapItems(x, places), timelineItems(places), common(places)];
  if (target.closest(".media")) return [mediaItems(places), common(places)];
  if (target.closest(".stage")) return [...stageItems(places), common(places)];
  const section = target.closest("section");
  return [section ? sectionItems(section) : [], common(places)];
}

function handleItems({ store, connection, player }: Places): MenuGroups | null {
  const { document, selection } = store;
  if (!document || !selection) return null;
  const edit = (next: typeof document, label: string): void => connection.edit(next, label);
  const remove = (text: string): MenuItem => ({
    text,
    keys: "Del",
    action: () => deleteItem(store, connection, selection),
  });
  if (selection.kind === "marker") return markerItems(selection.id, remove("Delete the marker"), { store, player });
  const { chosenKeys } = store;
  if (selection.kind === "key" && chosenKeys.size > 1) {
    const set = (speed: number | null, label: string) => () => edit(changeKeys(document, chosenKeys, { speed }), label);
    return [
      [
        {
          text: `Delete ${chosenKeys.size} keytimes`,
          keys: "Del",
          action: () => deleteSelected(store, connection),
        },
      ],
      [
        { text: "Play at its own speed there (1×)", action: set(1, "set speed at keys") },
        { text: "Leave the speed free", action: set(null, "free speed at keys") },
      ],
    ];
  }
  if (selection.kind === "key") {
    const key = findKey(document, selection.id);
    if (!key) return null;
    const set = (speed: number | null, label: string) => () => edit(changeKey(document, key.id, { speed }), label);
    return [
      [
        remove("Delete the keytime"),
        { text: "Go to it", action: () => player.scrub(key.output_time) },
        {
          text: "Bring it to the playhead",
          action: () => edit(changeKey(document, key.id, { output_time: store.playback.outputTime }), "move key"),
        },
      ],
      [
        { text: "Play at its own speed there (1×)", action: set(1, "set speed") },
        { text: "Hold there (0×)", action: set(0, "set speed") },
        { text: "Leave the speed free", disabled: key.speed === null, action: set(null, "set speed free") },
      ],
    ];
  }
  if (selection.kind === "lock") {
    const lock = findLock(document, selection.id);
    if (!lock) return null;
    const set = (slowest: number, fastest: number) => () =>
      edit(changeLock(document, lock.id, { slowest, fastest }), "change lock");
    const is = (slowest: number, fastest: number): boolean => lock.slowest === slowest && lock.fastest === fastest;
    return [
      [remove("Delete the lock")],
      [
        { text: "Own speed (1×)", checked: is(1, 1), action: set(1, 1) },
        { text: "Slowed down, never cut", checked: is(0, 1), action: set(0, 1) },
        { text: "Half speed to twice", checked: is(0.5, 2), action: set(0.5, 2) },
      ],
    ];
  }
  if (selection.kind === "flight") {
    const flight = findFlight(store.flights, selection.id);
    if (!flight) return null;
    return [[remove(flight.marked ? "Take the mark back" : "This is no flight")]];
  }
  return [
    [
      { text: "As long as the input", action: () => edit(setOption(document, "length", null), "set length") },
      {
        text: "Let the search choose the length",
        action: () => edit(setOption(document, "length", "free"), "set length"),
      },
    ],
  ];
}

function markerItems(
  id: string,
  remove: MenuItem,
  { store, player }: Pick<Places, "store" | "player">,
): MenuGroups | null {
  const marker = store.document && findMarker(store.document, id);
  if (!marker) return null;
  const go = (): void => {
    if (marker.on === "output") player.scrub(marker.time);
    else player.scrubInput(marker.time);
  };
  return [[remove, { text: "Go to it", action: go }]];
}

function mapItems(x: number, { store, connection, timeline, player }: Places): MenuItem[] {
  const under = timeline.timeAtPixel(x);
  const { document, knots, view } = store;
  if (under === null || !document || !knots) return [];
  const time = view.snap ? snapped(under, store.rate) : under;
  const bound = (side: "start" | "end") => () =>
    connection.edit(setWorkArea(document, side, time, outputEnd(knots)), "set work area");
  return [
    { text: `Keytime at ${said(store, time)}`, action: () => timeline.addKeyAt(time) },
    { text: "Marker here", keys: "M", action: () => timeline.mark("output", time) },
    { text: "Playhead here", action: () => player.scrub(time) },
    { text: "Work area begins here", keys: "Shift+I", action: bound("start") },
    { text: "Work area ends here", keys: "Shift+O", action: bound("end") },
    ...(document.work_area
      ? [
          {
            text: "Work on all of the output",
            keys: "Shift+X",
            action: () => connection.edit(clearWorkArea(document), "clear work area"),
          },
        ]
      : []),
  ];
}

function timelineItems({ store, timeline }: Places): MenuItem[] {
  return [
    { text: "Show all of the output", keys: "F", action: () => timeline.fit() },
    { text: "Snap to frames", checked: store.view.snap, action: () => store.look({ snap: !store.view.snap }) },
    {
      text: "Ripple: what follows moves along",
      keys: "R",
      checked: store.view.ripple,
      action: () => store.look({ ripple: !store.view.ripple }),
    },
  ];
}

function stageItems({ store, stage, dialogs }: Places): MenuGroups {
  const { view } = store;
  const flip = (
    name: "follow" | "ground" | "trails" | "onion" | "ghost" | "mesh" | "through",
    text: string,
    keys?: string,
  ): MenuItem => ({
    text,
    ...(keys === undefined ? {} : { keys }),
    checked: view[name],
    action: () => store.look({ [name]: !view[name] }),
  });
  return [
    [
      {
        text: "Side by side",
        keys: "V",
        checked: view.layout === "side",
        action: () => store.look({ layout: "side" }),
      },
      { text: "Overlaid", keys: "V", checked: view.layout === "over", action: () => store.look({ layout: "over" }) },
      { text: "Reset the view", action: () => stage.frame() },
      ...(cameraOf(store.clips, view.clip) ? [flip("through", "Through the camera")] : []),
    ],
    [
      flip("follow", "Follow the figure"),
      flip("ground", "Ground"),
      flip("trails", "Trails", "T"),
      flip("onion", "Onion skins", "O"),
      flip("ghost", "The matched pose", "G"),
      ...(store.clips.some(hasSkin) ? [flip("mesh", "The character's own mesh")] : []),
    ],
    NAVIGATIONS.map(({ name, text }) => ({
      text: `Turn it as in ${text}`,
      checked: view.navigation === name,
      action: () => store.look({ navigation: name }),
    })),
    [{ text: "Film of the stage…", action: () => dialogs.showExport("film") }],
  ];
}

function mediaItems({ store, connection }: Places): MenuItem[] {
  const { document, view } = store;
  if (!document) return [];
  return [
    { text: "Heard while it plays", checked: view.heard, action: () => store.look({ heard: !view.heard }) },
    { text: "Take it away", action: () => connection.edit(setMedia(document, null), "remove media") },
  ];
}

/** What a section's own buttons do: those in its heading, that are there. */
function sectionItems(section: HTMLElement): MenuItem[] {
  return [...section.querySelectorAll<HTMLButtonElement>(":scope > header button:not([hidden])")].map((one) => ({
    text: one.title || (one.textContent ?? ""),
    disabled: one.disabled,
    action: () => one.click(),
  }));
}

function common({ store, connection, dialogs, save, help }: Places): MenuItem[] {
  const { state } = store;
  return [
    {
      text: state?.undo_label ? `Undo ${state.undo_label}` : "Undo",
      keys: "Ctrl+Z",
      disabled: !state?.undo_label,
      action: () => connection.undo(),
    },
    {
      text: state?.redo_label ? `Redo ${state.redo_label}` : "Redo",
      keys: "Ctrl+Shift+Z",
      disabled: !state?.redo_label,
      action: () => connection.redo(),
    },
    { text: "Save", keys: "Ctrl+S", action: save },
    { text: "Export…", keys: "Ctrl+E", action: () => dialogs.showExport() },
    { text: "Keyboard shortcuts", keys: "?", action: help },
  ];
}
