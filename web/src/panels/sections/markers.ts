/** Markers and the work area: named, typed, sorted, and made keytimes. */

import { deleteItem } from "../../deleting";
import { make, setText } from "../../dom";
import { parseTime } from "../../grammar";
import { addMarker, changeMarker, clearWorkArea, findMarker, keysFromMarkers, setWorkArea } from "../../markers";
import type { Marker } from "../../messages";
import { inField } from "../../units";
import { outputEnd } from "../../warp";
import { button, iconButton } from "../buttons";
import { textField } from "../fields";
import { timeScrub } from "../scrub";
import { type SortedRow, SortedRows } from "../sorted_rows";
import { documentOf, frame, row, type Section, type Side } from "./section";

export function markersSection(side: Side): Section {
  const { store, connection } = side;
  const add = iconButton(
    "plus",
    "Add marker at the playhead",
    () => {
      const [document, id] = addMarker(documentOf(store), "output", store.playback.outputTime);
      connection.edit(document, "add marker");
      store.select({ kind: "marker", id });
    },
    "Mark the playhead (M); with Shift+M the pose that is shown",
  );
  const { root, body } = frame("Markers", add);
  const rows = new SortedRows<Marker>(
    [
      { name: "name", title: "Sort by name", value: (marker) => marker.name },
      { name: "at", title: "Sort by time", value: (marker) => marker.time },
      { name: "of", title: "Sort by what they are of", value: (marker) => marker.on },
    ],
    (id) => markerRow(side, id),
    1,
  );
  const note = make("p", { class: "note" }, "Press M to mark the playhead, Shift+M to mark the pose.");
  const keys = button("Keytimes from markers", "Put a keytime at each marker, on the curve as it is", () => {
    if (!store.knots) return;
    const [document, made] = keysFromMarkers(documentOf(store), store.knots, store.rate);
    if (made > 0) connection.edit(document, "add keys at markers");
  });
  keys.classList.add("framed", "wide");
  const area = new WorkAreaRow(side);
  body.append(rows.root, note, keys, area.root);
  return {
    root,
    update() {
      const { markers } = documentOf(store);
      rows.update(markers, store.selectedId("marker"));
      note.hidden = markers.length > 0;
      keys.hidden = markers.length === 0;
      area.update();
    },
  };
}

function markerRow({ store, connection }: Side, id: string): SortedRow {
  const change = (part: Partial<Omit<Marker, "id">>, label: string): boolean => {
    connection.edit(changeMarker(documentOf(store), id, part), label);
    return true;
  };
  const name = textField("Name", "What it is: heel down, beat 3", (text) =>
    change({ name: text.slice(0, 200) }, "name marker"),
  );
  name.input.placeholder = "name";
  name.input.dataset.marker = id;
  const time = textField(
    "At",
    "When: seconds, 105f, 1:03.5, or timecode 00:01:03:12",
    (text) => change({ time: Math.max(0, parseTime(text, store.rate)) }, "move marker"),
    timeScrub(
      { store, connection },
      "move marker",
      () => findMarker(documentOf(store), id)?.time ?? 0,
      (document, at) => changeMarker(document, id, { time: at }),
    ),
  );
  const on = make(
    "select",
    { class: "field", "aria-label": "Marker of", title: "A moment of the output, or of the input" },
    make("option", { value: "output" }, "output"),
    make("option", { value: "input" }, "input"),
  );
  on.addEventListener("change", () => {
    const marker = findMarker(documentOf(store), id);
    if (marker) change({ on: on.value === "input" ? "input" : "output" }, "change marker");
  });
  for (const [field, label] of [
    [name, "Marker's name"],
    [time, "Marker's time"],
  ] as const) {
    field.input.setAttribute("aria-label", label);
    field.input.addEventListener("focus", () => store.select({ kind: "marker", id }));
  }
  const remove = iconButton("trash", "Delete this marker", () => deleteItem(store, connection, { kind: "marker", id }));
  const root = make("div", { class: "lock markrow" }, name.input, time.input, on, remove, name.trouble, time.trouble);
  return {
    root,
    update() {
      const marker = findMarker(documentOf(store), id);
      if (!marker) return;
      name.show(marker.name);
      time.show(inField(store, marker.time));
      on.value = marker.on;
      root.setAttribute("aria-current", String(store.selection?.kind === "marker" && store.selection.id === id));
    },
  };
}

/** The stretch of the output that is played and looped. */
class WorkAreaRow {
  readonly root: HTMLElement;
  update: () => void;

  constructor({ store, connection }: Side) {
    const ends = (): number => (store.knots ? outputEnd(store.knots) : 0);
    const bound = (which: "start" | "end") =>
      textField(
        which === "start" ? "In" : "Out",
        which === "start" ? "Where the work area begins, in the output (Shift+I)" : "Where it ends (Shift+O)",
        (text) => {
          if (text === "") connection.edit(clearWorkArea(documentOf(store)), "clear work area");
          else
            connection.edit(
              setWorkArea(documentOf(store), which, parseTime(text, store.rate), ends()),
              "set work area",
            );
          return true;
        },
        timeScrub(
          { store, connection },
          "set work area",
          () => documentOf(store).work_area?.[which] ?? (which === "start" ? 0 : ends()),
          (document, time) => setWorkArea(document, which, Math.min(time, ends()), ends()),
        ),
      );
    const [start, end] = [bound("start"), bound("end")];
    start.input.setAttribute("aria-label", "Work area in");
    end.input.setAttribute("aria-label", "Work area out");
    const all = button("All", "Play all of the output again (Shift+X)", () =>
      connection.edit(clearWorkArea(documentOf(store)), "clear work area"),
    );
    const to = make("span", { class: "note" }, "to");
    const pair = make("div", { class: "pair" }, start.input, to, end.input, all);
    this.root = row("Work area", pair, start.trouble, end.trouble);
    this.update = () => {
      const area = documentOf(store).work_area;
      start.show(area ? inField(store, area.start, 2) : "");
      end.show(area ? inField(store, area.end, 2) : "");
      start.input.placeholder = "all";
      end.input.placeholder = "all";
      setText(to, "to");
      all.style.visibility = area ? "visible" : "hidden";
    };
  }
}
