/** Writing a file: the project, or what comes of it. */

import type { Connection } from "../../connection";
import { make, setAttribute, setText } from "../../dom";
import { groupPaths } from "../../group";
import { HOSTS, type Host } from "../../hosts";
import { isAnimation } from "../../media/endings";
import { FILM_SIZES, type FilmDialog, type FilmSize } from "../../media/film_dialog";
import type { Found, Refused } from "../../messages";
import { progressWords } from "../../shell/progress";
import type { Store } from "../../store";
import { check, choice, textField } from "../fields";
import { fileName } from "../top";
import { closeButton, form, makeDialog, onSubmit, Refusal } from "./dialog";

export type Export = "motion" | "warp" | "curve" | "picture" | "film";

const SOUND_HINT =
  "What stands beside the stage, as it is heard through the warp, at its own pitch; films that are animations (GIF) have none";

/** Of a group: every clip. */
const ALL = "all";

export class WriteDialog {
  readonly root = makeDialog("Write");
  private readonly title = make("h3", {}, "Save project");
  private readonly what = choice<Export>("What", "What to write", () => this.suggest());
  private readonly clip = choice<string>("Clip", "Of a group: which clip", () => this.suggest());
  private readonly host = choice<string>("Program", "For which program, or in which form", () => this.suggest());
  private readonly rate = textField("Rate", "Frames a second of the shot; left empty, those of the clip", () => true);
  private readonly start = textField("First frame", "The number of the shot's first frame", () => true);
  private readonly tolerance = textField(
    "Tolerance",
    "How many seconds the curve may be off to do with fewer keys",
    () => true,
  );
  private readonly item = textField("For", "", () => this.suggest(true));
  private readonly path = textField("Path", "The name's ending says in which format", () => true);
  private readonly refusal = new Refusal();
  private readonly overwrite = check("Replace the file if it is there", "", (on) => (this.mayOverwrite = on));
  private mayOverwrite = false;
  private saving = true;
  /** The path that was suggested last: another is someone's own. */
  private suggested = "";
  /** Of all clips of a group: where they are to be written, and those places that may be. */
  private asked: readonly string[] = [];
  private readonly allowed = new Map<number, string>();
  /** What is being written; the dialog stays until all of it is. */
  private readonly waiting = new Set<string>();
  private readonly go = make("button", { type: "submit", class: "button main" }, "Write");
  /** What has no curve yet waits for its search, which can be stopped here: the page behind hears no keys. */
  private readonly search = make("span");
  private readonly searching: HTMLElement;
  private readonly size = choice<FilmSize>("Size", "Pixels of the film", () => true);
  private readonly heard = check("With its sound", SOUND_HINT, (on) => (this.withSound = on));
  private withSound = true;
  /** Films the stage; null where it can't be filmed. */
  film: FilmDialog | null = null;

  constructor(
    private readonly store: Store,
    private readonly connection: Connection,
  ) {
    const stop = make("button", { type: "button", class: "button framed" }, "Stop the search");
    stop.addEventListener("click", () => connection.stop());
    this.searching = make("div", { class: "searching", role: "status", hidden: true }, this.search, stop);
    const body = form(
      this.title,
      [
        this.what.row,
        this.clip.row,
        this.host.row,
        this.size.row,
        this.rate.row,
        this.start.row,
        this.tolerance.row,
        this.item.row,
        this.path.row,
        this.heard.row,
        this.searching,
        this.refusal.root,
        this.overwrite.row,
      ],
      [closeButton(this.root, "Cancel"), this.go],
    );
    onSubmit(body, () => this.submit());
    this.root.append(body);
  }

  /** Ask where to save the project, or where to export what. */
  show(saving: boolean, what?: Export): void {
    this.saving = saving;
    const title = saving ? "Save project" : "Export";
    setText(this.title, title);
    this.root.setAttribute("aria-label", title);
    this.what.row.hidden = saving;
    this.what.show(
      [
        { value: "motion", text: "Motion, retimed" },
        { value: "warp", text: "Warp (JSON)" },
        { value: "curve", text: "Retime curve for another program" },
        { value: "picture", text: "Picture of the warp (SVG, PNG, PDF)" },
        ...(this.film?.works ? [{ value: "film" as const, text: "Film of the stage (MP4, WebM, GIF)" }] : []),
      ],
      what ?? (this.kind || "motion"),
    );
    this.clip.show(
      [
        ...this.store.clips.map((clip, i) => ({ value: String(i), text: clip.name })),
        { value: ALL, text: `All ${this.store.clips.length} clips` },
      ],
      String(this.store.view.clip),
    );
    this.host.show(
      HOSTS.map(({ name, title }) => ({ value: name, text: title })),
      this.host.select.value || "nuke",
    );
    this.size.show(FILM_SIZES, (this.size.select.value || "1280x720") as FilmSize);
    this.mayOverwrite = false;
    this.stopWaiting();
    this.refusal.say(null);
    this.overwrite.show(false);
    this.suggest();
    this.root.showModal();
    this.path.input.focus();
    this.path.input.select();
  }

  /** The server says whether a file that was named may be written, and whether it is there already. */
  found(found: Found): void {
    if (this.isAll) return this.foundOne(found);
    const { path, place, refused: reason, exists } = found;
    if (!this.root.open || this.path.input.value.trim() !== path) return;
    const inTheWay = exists && !this.mayOverwrite && place !== this.store.state?.path;
    const there = "This file is there already: choose another name, or tick the box to replace it.";
    const refused = reason ?? (inTheWay ? there : null);
    this.refusal.say(refused);
    if (refused !== null) return;
    if (this.kind === "film" && !this.saving) this.root.close();
    else this.wait(place);
    if (this.saving) this.connection.save(place, this.mayOverwrite);
    else if (this.kind === "film") {
      const heard = this.withSound && !this.heard.row.hidden && !isAnimation(place);
      this.film?.begin(place, this.rate.input.value, this.filmSize, this.mayOverwrite, heard);
    } else if (this.kind !== "curve") this.connection.export(this.kind, place, this.which, this.mayOverwrite);
    else {
      const { name, firstFrame, thins, item } = this.chosen;
      this.connection.exportCurve({
        host: name,
        path: place,
        rate: this.rate.input.value.trim(),
        start: firstFrame === null ? "" : this.start.input.value.trim(),
        tolerance: thins ? this.tolerance.input.value.trim() : "",
        item: item === "" ? "" : this.item.input.value.trim(),
        overwrite: this.mayOverwrite,
      });
    }
  }

  /** Of all clips of a group: once each may be written, all are. */
  private foundOne({ path, place, refused, exists }: Found): void {
    const index = this.asked.indexOf(path);
    if (!this.root.open || index < 0) return;
    const there = `${path} is there already: choose another name, or tick the box to replace what is there.`;
    const reason = refused ?? (exists && !this.mayOverwrite ? there : null);
    if (reason !== null) {
      this.asked = [];
      this.refusal.say(reason);
      return;
    }
    this.allowed.set(index, place);
    if (this.allowed.size < this.asked.length) return;
    this.wait(...this.allowed.values());
    for (const [clip, file] of [...this.allowed].sort(([a], [b]) => a - b)) {
      this.connection.export("motion", file, clip, this.mayOverwrite);
    }
  }

  /** Whether all clips of a group are to be written. */
  private get isAll(): boolean {
    return !this.saving && this.kind === "motion" && this.clip.select.value === ALL;
  }

  /** The server could not write it: the dialog says why, and keeps the path; false where it did not ask. */
  refused({ path, reason }: Refused): boolean {
    if (!this.root.open || !this.waiting.has(path)) return false;
    this.stopWaiting();
    this.refusal.say(reason);
    return true;
  }

  written(path: string): void {
    if (!this.waiting.delete(path) || this.waiting.size > 0) return;
    this.stopWaiting();
    this.root.close();
  }

  /** Say how far the search is that what is to be written waits for. */
  progress(): void {
    this.searching.hidden = this.waiting.size === 0 || this.saving || this.store.progress === null;
    if (!this.searching.hidden) setText(this.search, progressWords(this.store));
  }

  /** Nothing is written any more. */
  stopWaiting(): void {
    this.waiting.clear();
    this.progress();
    this.go.disabled = false;
    setText(this.go, "Write");
  }

  private wait(...places: readonly string[]): void {
    for (const place of places) this.waiting.add(place);
    this.refusal.say(null);
    this.progress();
    this.go.disabled = true;
    setText(this.go, "Writing…");
  }

  /** The program that a curve is for. */
  private get chosen(): Host {
    const found = HOSTS.find(({ name }) => name === this.host.select.value) ?? HOSTS[0];
    if (!found) throw new Error("there is no host");
    return found;
  }

  private get kind(): Export {
    return this.what.select.value as Export;
  }

  private get filmSize(): FilmSize {
    return this.size.select.value as FilmSize;
  }

  /** The place of the clip that is exported. */
  private get which(): number {
    return this.isAll ? 0 : Number(this.clip.select.value || 0);
  }

  private submit(): void {
    const { input } = this.path;
    const path = input.value.trim();
    if (path === "") {
      input.focus();
      return;
    }
    if (this.isAll) return this.askAll(path);
    input.value = this.saving && !/\.retime$/iu.test(path) ? `${path}.retime` : path;
    this.connection.find(input.value, { writing: true });
  }

  private askAll(pattern: string): void {
    if (pattern.split("*").length !== 2) {
      this.refusal.say("Write * once where the name of each clip is to stand.");
      return;
    }
    this.refusal.say(null);
    this.allowed.clear();
    this.asked = groupPaths(pattern, this.store.document?.clips.map((clip) => clip.path) ?? []);
    for (const path of this.asked) this.connection.find(path, { writing: true });
  }

  /** Suggest a path that says what is in it, beside the clip or the project; one that someone wrote may `stay`. */
  private suggest(stay = false): boolean {
    const { state, document, clips } = this.store;
    const which = this.saving ? 0 : this.which;
    const source = document?.clips[which]?.path ?? clips[which]?.name ?? "clip";
    this.clip.row.hidden = this.saving || this.kind !== "motion" || clips.length < 2;
    const host = this.chosen;
    const curve = !this.saving && this.kind === "curve";
    const film = !this.saving && this.kind === "film";
    this.host.row.hidden = !curve;
    this.rate.row.hidden = !curve && !film;
    this.size.row.hidden = !film;
    const media = document?.media ?? null;
    this.heard.row.hidden = !film || media === null;
    if (media) setText(this.heard.words, `Sound of ${fileName(media.path)}`);
    this.heard.show(this.withSound);
    this.start.row.hidden = !curve || host.firstFrame === null;
    this.tolerance.row.hidden = !curve || !host.thins;
    this.item.row.hidden = !curve || host.item === "";
    setAttribute(this.start.input, "placeholder", host.firstFrame === null ? null : String(host.firstFrame));
    setAttribute(this.item.input, "placeholder", host.item);
    setAttribute(this.item.input, "title", `What the curve is for: ${host.item}`);
    setAttribute(this.rate.input, "placeholder", "frames a second: as the clip");
    setAttribute(this.tolerance.input, "placeholder", "0.001 s");
    // Of Maya: a scene, or a script for what is named.
    const named = host.item !== "" && this.item.input.value.trim() !== "";
    const suffix =
      (named && host.suffixes.length > 1 && host.name === "maya" ? host.suffixes[1] : null) ?? host.suffixes[0];
    const [, stem = source, ending = ""] = /^(.*?)(\.[^./\\]+)?$/u.exec(source) ?? [];
    const isOwn = this.path.input.value !== this.suggested;
    const [folder = ""] = /^.*[\\/]/u.exec(source) ?? [];
    if (this.isAll) this.suggested = `${folder}*_retimed`;
    else if (this.saving) this.suggested = state?.path ?? `${stem}.retime`;
    else {
      this.suggested = {
        motion: `${stem}_retimed${ending}`,
        warp: `${stem}_warp.json`,
        curve: `${stem}_retime${suffix}`,
        picture: `${stem}_warp.svg`,
        film: `${stem}_stage.mp4`,
      }[this.kind];
    }
    if (!(stay && isOwn)) this.path.input.value = this.suggested;
    return true;
  }
}
