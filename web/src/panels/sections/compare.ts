/** Compare with: what stands beside the output, the versions that were kept, and which warp the output plays. */

import { make } from "../../dom";
import type { Companion } from "../../view_settings";
import { button, iconButton } from "../buttons";
import { choice, textField } from "../fields";
import { documentOf, frame, row, type Section, type Side } from "./section";

export function compareSection({ store, connection }: Side): Section {
  const keep = button(
    "Keep",
    "Keep this warp, to compare later ones with",
    () => {
      const names = new Set(documentOf(store).kept.map((one) => one.name));
      let n = 1;
      while (names.has(`Version ${n}`)) n++;
      connection.keep(`Version ${n}`);
    },
    "plus",
  );
  const { root, body } = frame("Compare with", keep);
  const other = choice<string>("Beside it", "What stands beside the output on the stage", (value) =>
    store.look({ companion: companionOf(value), showB: false }),
  );
  const name = textField("Name", "What to call the version", (text) => {
    const { companion } = store.view;
    if (typeof companion === "string" || text === "") return false;
    const kept = documentOf(store).kept.map((one) => (one.id === companion.kept ? { ...one, name: text } : one));
    connection.edit({ ...documentOf(store), kept }, "rename version");
    return true;
  });
  name.input.setAttribute("aria-label", "Name of the version");
  const drop = iconButton("trash", "Forget this version", () => {
    const { companion } = store.view;
    if (typeof companion === "string") return;
    const kept = documentOf(store).kept.filter((one) => one.id !== companion.kept);
    connection.edit({ ...documentOf(store), kept }, "forget version");
    store.look({ companion: "input", showB: false });
  });
  const nameRow = row("Name", make("span", { class: "pair" }, name.input, drop));
  const a = button("A  this warp", "Play this warp (B)", () => store.look({ showB: false }));
  const b = button("B", "Play what it is compared with (B)", () => store.look({ showB: true }));
  const swap = make("div", { class: "segments", role: "group", "aria-label": "Which warp the output plays" }, a, b);
  const swapRow = row("Play", swap);
  body.append(other.row, nameRow, swapRow);
  return {
    root,
    update() {
      const { companion } = store.view;
      const { kept } = documentOf(store);
      if (typeof companion !== "string" && !kept.some((one) => one.id === companion.kept)) {
        store.look({ companion: "input", showB: false });
        return;
      }
      other.show(
        [
          { value: "input", text: "Input" },
          { value: "linear", text: "Linear warp" },
          { value: "spline", text: "Spline warp" },
          ...kept.map((one) => ({ value: `kept:${one.id}`, text: one.name })),
        ],
        typeof companion === "string" ? companion : `kept:${companion.kept}`,
      );
      nameRow.hidden = typeof companion === "string";
      name.show(store.companionName);
      swapRow.hidden = companion === "input";
      b.textContent = `B  ${store.companionName}`;
      a.setAttribute("aria-pressed", String(!store.view.showB));
      b.setAttribute("aria-pressed", String(store.view.showB));
    },
  };
}

/** What the value of an option of "Beside it" stands for. */
function companionOf(value: string): Companion {
  if (value.startsWith("kept:")) return { kept: value.slice(5) };
  return value === "linear" || value === "spline" ? value : "input";
}
