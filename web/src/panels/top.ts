/** The bar at the top: the project, undo, clips, files, theme, help. */

import { make, setAttribute, setText } from "../dom";
import { type IconName, icon } from "../icons";
import type { Clip } from "../messages";
import type { Store, Topic } from "../store";
import { figureColor } from "../theme";

export interface TopActions {
  undo(): void;
  redo(): void;
  open(): void;
  save(): void;
  export(): void;
  theme(): void;
  help(): void;
}

export class TopBar {
  readonly root: HTMLElement;
  private readonly name = make("b");
  private readonly saved = make("span", { role: "status" });
  private readonly undo: HTMLButtonElement;
  private readonly redo: HTMLButtonElement;
  private readonly clips = make("div", { class: "clips", role: "group", "aria-label": "Clips" });
  private readonly theme: HTMLButtonElement;
  private shown = "";

  constructor(
    private readonly store: Store,
    private readonly isDark: () => boolean,
    actions: TopActions,
  ) {
    this.undo = button("undo", "Undo", actions.undo);
    this.redo = button("redo", "Redo", actions.redo);
    this.theme = button("moon", "Theme", actions.theme);
    this.root = make(
      "header",
      { class: "top" },
      make("span", { class: "brand" }, "retime"),
      make("div", { class: "project" }, this.name, this.saved),
      this.undo,
      this.redo,
      this.clips,
      make("span", { class: "gap" }),
      button("open", "Open a clip or a project (Ctrl+O)", actions.open, "Open"),
      button("save", "Save the project (Ctrl+S)", actions.save, "Save"),
      button("export", "Export motion, warp or picture (Ctrl+E)", actions.export, "Export"),
      make("span", { class: "rule" }),
      this.theme,
      button("help", "Keyboard shortcuts (?)", actions.help),
    );
  }

  update(changed: Set<Topic>): void {
    if (!["document", "status", "clips", "theme", "view"].some((topic) => changed.has(topic as Topic))) return;
    const { state, clip } = this.store;
    setText(this.name, state?.path ? fileName(state.path) : (clip?.name ?? ""));
    setAttribute(this.name, "title", state?.path ?? null);
    const inFile = state?.saved ? "saved" : "edited";
    setText(this.saved, !state ? "" : state.path ? inFile : state.undo_label ? "not saved to a file" : "");
    label(this.undo, state?.undo_label ? `Undo ${state.undo_label} (Ctrl+Z)` : "Undo (Ctrl+Z)");
    label(this.redo, state?.redo_label ? `Redo ${state.redo_label} (Ctrl+Shift+Z)` : "Redo (Ctrl+Shift+Z)");
    this.undo.disabled = !state?.undo_label;
    this.redo.disabled = !state?.redo_label;
    const dark = this.isDark();
    label(this.theme, dark ? "Light theme" : "Dark theme");
    if (this.theme.dataset.dark !== String(dark)) {
      this.theme.dataset.dark = String(dark);
      this.theme.replaceChildren(icon(dark ? "sun" : "moon"));
    }
    this.showClips();
  }

  /** Of a group: which clip is followed, or drawn as curves. One clip alone needs no choice. */
  private showClips(): void {
    const { clips, view, document } = this.store;
    const name = JSON.stringify([
      clips.map((clip) => [clip.name, clip.holds]),
      view.clip,
      document?.clips.map((file) => file.role),
    ]);
    if (name === this.shown) return;
    this.shown = name;
    this.clips.hidden = clips.length < 2;
    this.clips.replaceChildren(
      ...clips.map((clip, i) => {
        const role = document?.clips[i]?.role === "follow" ? ", only follows the warp" : "";
        const made = make(
          "button",
          { type: "button", class: "button", "aria-pressed": String(view.clip === i), title: `${clip.name}${role}` },
          dot(clips, i),
          clip.name,
        );
        made.addEventListener("click", () => this.store.look({ clip: i }));
        return made;
      }),
    );
  }
}

/** The colour of a clip's figure; nothing for one alone, or where there is no figure. */
export function dot(clips: readonly Clip[], index: number): HTMLElement | null {
  const color = clips.length > 1 ? figureColor(clips, index) : null;
  if (!color) return null;
  const made = make("i", { class: "dot", "aria-hidden": true });
  made.style.background = `var(--${color})`;
  return made;
}

export function fileName(path: string): string {
  return path.split(/[\\/]/u).at(-1) ?? path;
}

function button(name: IconName, text: string, action: () => void, word?: string): HTMLButtonElement {
  const made = make(
    "button",
    { type: "button", class: word ? "button" : "button bare", title: text, ...(word ? {} : { "aria-label": text }) },
    icon(name),
    word,
  );
  made.addEventListener("click", action);
  return made;
}

function label(element: HTMLElement, text: string): void {
  setAttribute(element, "aria-label", text);
  setAttribute(element, "title", text);
}
