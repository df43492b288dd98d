/** The editor, put together on an element: the page in a browser tab, or a widget in a notebook. */

import { addClip } from "./document";
import { make } from "./dom";
import { recall, remember } from "./memory";
import type { Document } from "./messages";
import { Dialogs } from "./panels/dialogs";
import { Inspector } from "./panels/inspector";
import { StageBar } from "./panels/stage_bar";
import { TopBar } from "./panels/top";
import { Transport } from "./panels/transport";
import { WhyPanel } from "./panels/why_panel";
import { advance, type ClockName, leading, seek, shuttle, step } from "./playback";
import { WhenQuiet } from "./quiet";
import { addReference } from "./references";
import { clamp } from "./scale";
import { Session } from "./session";
import { listen, type Shortcut } from "./shortcuts";
import { Stage } from "./stage/stage";
import { Store, type Topic } from "./store";
import { Theme } from "./theme";
import { Timeline } from "./timeline/timeline";
import { outputEnd, outputStart } from "./warp";

export interface AppOptions {
  /** Sends a file that was dropped or picked to the server; left out, where files can't be sent. */
  readonly upload?: (file: File) => Promise<string>;
  /** Shortcuts are heard on the whole window, or only on the editor's element. */
  readonly shortcutsFrom?: "window" | "element";
}

const HINT_SEEN = "retime.hint";

/** While something is dragged, the panels follow when the hand has rested for some milliseconds, or after so many. */
const PANELS_REST = 80;
const PANELS_MOST = 1000;

export class App {
  readonly store: Store;
  readonly session: Session;
  private readonly theme: Theme;
  private readonly stage: Stage;
  private readonly timeline: Timeline;
  private readonly top: TopBar;
  private readonly transport: Transport;
  private readonly stageBar: StageBar;
  private readonly inspector: Inspector;
  private readonly why: WhyPanel;
  private readonly dialogs: Dialogs;
  private readonly shortcuts: readonly Shortcut[];
  private readonly notices = make("div", { class: "notices", "aria-live": "polite" });
  private readonly veil = make("div", { class: "veil", role: "status" });
  private readonly stageRoot = make("div", { class: "stage" });
  private readonly hint: HTMLElement;
  private readonly ends = new AbortController();
  private awake = false;
  private before = 0;
  /** What the panels have not shown yet. */
  private readonly unshown = new Set<Topic>();
  private readonly panelsLater = new WhenQuiet(() => this.showPanels(), PANELS_REST, PANELS_MOST);

  constructor(
    private readonly root: HTMLElement,
    options: AppOptions = {},
  ) {
    root.classList.add("retime");
    root.tabIndex = -1;
    this.store = new Store(() => this.wake());
    this.theme = new Theme(root, () => this.store.touch("theme"));
    this.session = new Session(
      this.store,
      {
        notice: (kind, text) => this.say(kind, text),
        listing: (listing) => this.dialogs.list(listing),
        found: (found) => this.dialogs.found(found),
        connected: () => this.connected(),
        recovered: () =>
          this.say("warning", "The last session ended before this was saved. Everything that was done is back."),
        lost: () =>
          this.cover(
            "The server has stopped answering. What you did is kept: start retime edit again, and it goes on from there.",
          ),
        outdated: () => this.cover("This page is of another version than its server. Load it again."),
        renewed: () => this.renewed(),
      },
      (callback) => requestAnimationFrame(callback),
    );
    const { upload } = options;
    const send = upload
      ? (files: readonly File[], then = (path: string): void => this.session.open(path)): void =>
          void this.openFiles(files, upload, then)
      : null;
    this.dialogs = new Dialogs(root, this.store, this.session, send);
    this.timeline = new Timeline(this.store, this.session, this.theme, (time) => this.scrub(time));
    this.stage = new Stage(this.stageRoot, this.store, this.theme);
    this.stageBar = new StageBar(this.store, this.stageRoot, () => this.stage.frame());
    this.transport = new Transport(this.store, {
      play: () => this.play(),
      toStart: () => this.toEdge("start"),
      toEnd: () => this.toEdge("end"),
      step: (frames) => this.step(frames),
      loop: () => this.patch({ loop: !this.store.playback.loop }),
      clock: (clock) => this.clock(clock),
      link: () => this.link(),
      snap: () => this.store.look({ snap: !this.store.view.snap }),
      fit: () => this.timeline.fit(),
    });
    this.top = new TopBar(this.store, () => this.theme.dark, {
      undo: () => this.session.undo(),
      redo: () => this.session.redo(),
      open: () => this.dialogs.showOpen(),
      save: () => this.save(),
      export: () => this.dialogs.showExport(),
      theme: () => this.theme.choose(this.theme.dark ? "light" : "dark"),
      help: () => this.help(),
    });
    this.inspector = new Inspector(this.store, this.session, this.dialogs);
    this.why = new WhyPanel(this.store);
    this.shortcuts = this.makeShortcuts();
    this.hint = this.makeHint();
    this.inspector.root.prepend(this.hint);
    if (!this.stage.works) {
      this.stageRoot.append(
        make("p", { class: "caption" }, "This browser has no WebGL: the stage stays empty, all else works."),
      );
    }
    const splitter = this.makeSplitter();
    root.append(
      this.top.root,
      make(
        "main",
        { class: "work" },
        make("div", { class: "unseen" }, make("h1", {}, "retime editor")),
        this.stageRoot,
        this.transport.root,
        splitter,
        this.timeline.root,
      ),
      make("aside", { class: "side", "aria-label": "Properties" }, this.inspector.root, this.why.root),
      this.notices,
      this.veil,
    );
    this.cover("Opening…");
    this.listen(options, send);
    this.store.touch("size", "theme", "view");
  }

  /** Take the editor off the page. */
  close(): void {
    this.ends.abort();
  }

  /** What a dropped file is for: on the references or the clips it is one more of them, elsewhere it is opened. */
  private dropAction(target: EventTarget | null): ((path: string) => void) | undefined {
    const name = target instanceof Element ? target.closest("section")?.getAttribute("aria-label") : null;
    const edit = (change: (document: Document) => Document, label: string): void => {
      if (this.store.document) this.session.edit(change(this.store.document), label);
    };
    if (name === "References") return (path) => edit((document) => addReference(document, path), "add reference");
    if (name === "Clips") return (path) => edit((document) => addClip(document, path), "add clip");
    return undefined;
  }

  private listen(
    options: AppOptions,
    send: ((files: readonly File[], then?: (path: string) => void) => void) | null,
  ): void {
    const { signal } = this.ends;
    new ResizeObserver(() => this.store.touch("size")).observe(this.root);
    const size = new ResizeObserver(() => this.store.touch("size"));
    size.observe(this.timeline.root);
    size.observe(this.stageRoot);
    const target = options.shortcutsFrom === "element" ? this.root : window;
    const end = listen(target, this.shortcuts, () => this.dialogs.isOpen || !this.store.document);
    signal.addEventListener("abort", () => {
      end();
      size.disconnect();
    });
    // A button clicked by hand gives the keys back: space plays, it does not press the button again.
    this.root.addEventListener("click", (event) => {
      const button = event.target instanceof Element ? event.target.closest("button") : null;
      if (button && event.detail > 0 && !button.classList.contains("handle") && !button.closest("dialog"))
        button.blur();
    });
    if (send) {
      let depth = 0;
      const over = (by: number): void => {
        depth = Math.max(0, depth + by);
        this.root.classList.toggle("dropping", depth > 0);
      };
      this.root.addEventListener("dragenter", () => over(1), { signal });
      this.root.addEventListener("dragleave", () => over(-1), { signal });
      this.root.addEventListener("dragover", (event) => event.preventDefault(), { signal });
      this.root.addEventListener(
        "drop",
        (event) => {
          event.preventDefault();
          depth = 0;
          this.root.classList.remove("dropping");
          send([...(event.dataTransfer?.files ?? [])], this.dropAction(event.target));
        },
        { signal },
      );
    }
    window.addEventListener(
      "beforeunload",
      (event) => {
        if (this.session.busy) event.preventDefault();
      },
      { signal },
    );
  }

  /** Send files to the server, and open the one that is a clip or a project: an AMC may bring its ASF along. */
  private async openFiles(
    files: readonly File[],
    upload: (file: File) => Promise<string>,
    then: (path: string) => void,
  ): Promise<void> {
    const isSkeleton = (file: File): boolean => file.name.toLowerCase().endsWith(".asf");
    try {
      for (const file of [...files].sort((a, b) => Number(isSkeleton(b)) - Number(isSkeleton(a)))) {
        const path = await upload(file);
        if (isSkeleton(file)) this.say("info", `${file.name} is here; now drop the AMC that moves it.`);
        else return then(path);
      }
    } catch (error) {
      this.say("error", error instanceof Error ? error.message : String(error));
    }
  }

  private wake(): void {
    if (this.awake) return;
    this.awake = true;
    requestAnimationFrame((now) => this.tick(now));
  }

  private tick(now: number): void {
    this.awake = false;
    const { store } = this;
    if (!this.theme.styled) {
      this.theme.refresh();
      if (!this.theme.styled) return this.wake();
    }
    const knots = store.knots;
    if (store.playback.rate !== 0 && knots) {
      // After a pause of the page (another tab, say) time has not passed for the playhead.
      const seconds = this.before > 0 ? Math.min((now - this.before) / 1000, 0.25) : 0;
      this.before = now;
      store.playback = advance(store.playback, knots, store.inputEnd, seconds);
      store.touch("playhead");
    } else this.before = 0;
    const changed = store.take();
    if (changed.size > 0) this.update(changed);
    if (store.playback.rate !== 0) this.wake();
  }

  private update(changed: Set<Topic>): void {
    const { store } = this;
    if (changed.has("curve") && store.knots) {
      this.veil.hidden = this.session.isConnected;
      // The output may have become shorter than where the playhead stood.
      const { playback } = store;
      if (playback.rate === 0) {
        const end = outputEnd(store.knots);
        store.playback = seek(
          { ...playback, clock: "output" },
          store.knots,
          store.inputEnd,
          clamp(playback.outputTime, 0, end),
        );
        store.playback = { ...store.playback, clock: playback.clock };
      }
      changed.add("playhead");
    }
    if (store.problem && !store.clip) this.coverWithProblem(store.problem.message);
    this.timeline.update(changed);
    if (changed.has("curve")) this.tellMeasure();
    this.stage.update(changed);
    for (const topic of changed) this.unshown.add(topic);
    if (!store.dragging) this.showPanels();
    // Who drags looks at the curve: it is painted first, and the numbers follow when there is time.
    else this.panelsLater.ask();
  }

  private showPanels(): void {
    this.panelsLater.cancel();
    const changed = new Set(this.unshown);
    this.unshown.clear();
    for (const panel of [this.transport, this.top, this.stageBar, this.inspector, this.why]) panel.update(changed);
  }

  /** How long people waited for this curve, from their hand to the screen; for the measurement in the tests. */
  private tellMeasure(): void {
    const moves = this.session.takeMoves();
    if (moves.length === 0) return;
    const channel = new MessageChannel();
    // A message that is sent in a frame arrives after that frame was painted.
    channel.port1.onmessage = () => {
      const now = performance.now();
      this.root.dispatchEvent(new CustomEvent("retime:curve", { detail: moves.map((moved) => now - moved) }));
    };
    channel.port2.postMessage(null);
  }

  private connected(): void {
    if (this.store.knots) this.veil.hidden = true;
    if (recall(HINT_SEEN) === null) this.hint.hidden = false;
  }

  private renewed(): void {
    this.cover("Opening…");
    this.store.select(null);
    this.store.hover = null;
    this.store.playback = { ...this.store.playback, rate: 0, outputTime: 0, inputTime: 0 };
    this.store.look({ companion: "input", showB: false, clip: 0, reference: 0 });
    this.timeline.fit();
  }

  private cover(text: string): void {
    delete this.veil.dataset.is;
    this.veil.replaceChildren(make("p", {}, text));
    this.veil.hidden = false;
  }

  /** A document whose clips can't be read has nothing to show; what mends it, at the top and at the side, is at hand. */
  private coverWithProblem(text: string): void {
    this.cover(text);
    this.veil.dataset.is = "problem";
  }

  private say(kind: "info" | "warning" | "error", text: string): void {
    const close = make("button", { type: "button", class: "button bare", "aria-label": "Close" }, "✕");
    const notice = make(
      "div",
      { class: "notice", "data-kind": kind, role: kind === "info" ? "status" : "alert" },
      make("p", {}, text),
      close,
    );
    const gone = (): void => notice.remove();
    close.addEventListener("click", gone);
    // Bad news stays until it was read.
    if (kind === "info") setTimeout(gone, 6000);
    this.notices.append(notice);
    while (this.notices.childElementCount > 4) this.notices.firstElementChild?.remove();
  }

  private patch(change: Partial<Store["playback"]>): void {
    this.store.playback = { ...this.store.playback, ...change };
    this.store.touch("playhead");
  }

  private play(): void {
    const { store } = this;
    const knots = store.knots;
    if (!knots) return;
    if (store.playback.rate !== 0) return this.patch({ rate: 0 });
    const [time, start, end] = leading(store.playback, knots, store.inputEnd);
    if (time >= end - 1e-9) store.playback = seek(store.playback, knots, store.inputEnd, start);
    this.patch({ rate: 1 });
  }

  private shuttle(direction: -1 | 1): void {
    this.patch({ rate: shuttle(this.store.playback.rate, direction) });
  }

  private seek(time: number): void {
    const { store } = this;
    if (!store.knots) return;
    store.playback = { ...seek(store.playback, store.knots, store.inputEnd, time), rate: 0 };
    store.touch("playhead");
  }

  /** The timeline is in output time, whichever clock leads. */
  private scrub(outputTime: number): void {
    const { store } = this;
    if (!store.knots) return;
    const { clock } = store.playback;
    store.playback = {
      ...seek({ ...store.playback, clock: "output" }, store.knots, store.inputEnd, outputTime),
      clock,
      rate: 0,
    };
    store.touch("playhead");
  }

  private toEdge(edge: "start" | "end"): void {
    const { store } = this;
    if (!store.knots) return;
    const [, start, end] = leading(store.playback, store.knots, store.inputEnd);
    this.seek(edge === "start" ? start : end);
  }

  private step(frames: number): void {
    const { store } = this;
    if (!store.knots) return;
    store.playback = step(store.playback, store.knots, store.inputEnd, store.rate, frames);
    store.touch("playhead");
  }

  private clock(clock: ClockName): void {
    this.patch({ clock });
  }

  private link(): void {
    const { store } = this;
    this.patch({ linked: !store.playback.linked });
    if (store.playback.rate === 0) this.scrub(store.playback.outputTime);
  }

  /** To the next keytime or the last one before, the ends included. */
  private toKey(direction: -1 | 1): void {
    const { store } = this;
    if (!store.knots || !store.document) return;
    const now = store.playback.outputTime;
    const times = [
      outputStart(store.knots),
      ...store.document.keys.map((key) => key.output_time),
      outputEnd(store.knots),
    ].sort((a, b) => a - b);
    const next = direction > 0 ? times.find((time) => time > now + 1e-6) : times.findLast((time) => time < now - 1e-6);
    if (next === undefined) return;
    this.scrub(next);
    const key = store.document.keys.find((one) => one.output_time === next);
    store.select(key ? { kind: "key", id: key.id } : null);
  }

  private save(): void {
    if (this.store.state?.path) this.session.save(null, true);
    else this.dialogs.showSave();
  }

  private deleteSelected(): void {
    const { store, session } = this;
    const { selection, document } = store;
    if (!selection || !document) return;
    if (selection.kind === "key")
      session.edit({ ...document, keys: document.keys.filter((key) => key.id !== selection.id) }, "delete key");
    if (selection.kind === "lock")
      session.edit({ ...document, locks: document.locks.filter((lock) => lock.id !== selection.id) }, "delete lock");
    store.select(null);
  }

  private help(): void {
    this.dialogs.showHelp(this.shortcuts, [
      ["Double-click the map", "Add a keytime"],
      ["Shift while dragging", "Move a keytime along one axis"],
      ["Alt while dragging", "The other of snapping and not"],
      ["Drag the input times", "Lock a span"],
      ["Scroll, Shift+scroll", "Zoom, move along"],
      ["Arrows on a keytime", "Move it by a frame, with Shift by ten"],
      ["Double-click a speed", "Let it be free again"],
      ["Esc while dragging", "As if nothing had happened"],
    ]);
  }

  private makeShortcuts(): Shortcut[] {
    const { store, session } = this;
    return [
      { keys: ["Space"], does: "Play, pause", action: () => this.play() },
      { keys: ["J"], does: "Play backward; again, faster", action: () => this.shuttle(-1) },
      { keys: ["K"], does: "Stop", action: () => this.patch({ rate: 0 }) },
      { keys: ["L"], does: "Play; again, faster", action: () => this.shuttle(1) },
      { keys: ["ArrowLeft"], does: "A frame back", action: () => this.step(-1) },
      { keys: ["ArrowRight"], does: "A frame on", action: () => this.step(1) },
      { keys: ["Shift+ArrowLeft"], does: "Ten frames back", action: () => this.step(-10) },
      { keys: ["Shift+ArrowRight"], does: "Ten frames on", action: () => this.step(10) },
      { keys: ["ArrowUp"], does: "To the next keytime", action: () => this.toKey(1) },
      { keys: ["ArrowDown"], does: "To the keytime before", action: () => this.toKey(-1) },
      { keys: ["Home"], does: "To the beginning", action: () => this.toEdge("start") },
      { keys: ["End"], does: "To the end", action: () => this.toEdge("end") },
      { keys: ["I"], does: "Keytime at the playhead", action: () => this.timeline.addKeyAt(store.playback.outputTime) },
      { keys: ["Delete", "Backspace"], does: "Delete what is selected", action: () => this.deleteSelected() },
      { keys: ["Ctrl+Z"], does: "Undo", action: () => session.undo() },
      { keys: ["Ctrl+Shift+Z", "Ctrl+Y"], does: "Redo", action: () => session.redo() },
      { keys: ["B"], does: "A or B: this warp, or the compared one", action: () => this.swap() },
      {
        keys: ["C"],
        does: "The other clock",
        action: () => this.clock(store.playback.clock === "output" ? "input" : "output"),
      },
      {
        keys: ["V"],
        does: "Side by side, or overlaid",
        action: () => store.look({ layout: store.view.layout === "side" ? "over" : "side" }),
      },
      { keys: ["T"], does: "Trails", action: () => store.look({ trails: !store.view.trails }) },
      { keys: ["O"], does: "Onion skins", action: () => store.look({ onion: !store.view.onion }) },
      { keys: ["+", "="], does: "Zoom in", action: () => this.timeline.zoomBy(0.7) },
      { keys: ["-"], does: "Zoom out", action: () => this.timeline.zoomBy(1 / 0.7) },
      { keys: ["F"], does: "Show all of the output", action: () => this.timeline.fit() },
      { keys: ["Ctrl+S"], does: "Save", action: () => this.save() },
      { keys: ["Ctrl+Shift+S"], does: "Save under another name", action: () => this.dialogs.showSave() },
      { keys: ["Ctrl+O"], does: "Open", action: () => this.dialogs.showOpen() },
      { keys: ["Ctrl+E"], does: "Export", action: () => this.dialogs.showExport() },
      { keys: ["?"], does: "This list", action: () => this.help() },
    ];
  }

  private swap(): void {
    if (this.store.companionKnots) this.store.look({ showB: !this.store.view.showB });
    else this.say("info", "Choose what to compare with first: at the right, Compare with.");
  }

  private makeHint(): HTMLElement {
    const done = make("button", { type: "button", class: "button framed" }, "Got it");
    const all = make("button", { type: "button", class: "button" }, "All shortcuts");
    const hint = make(
      "section",
      { class: "hint", "aria-label": "First steps", hidden: true },
      make("header", {}, make("h2", {}, "First steps")),
      make(
        "ol",
        {},
        make("li", {}, "Pull the round end of the curve to make the clip shorter or longer."),
        make("li", {}, "Double-click the curve to put a keytime, and drag it: the rest finds its own timing."),
        make("li", {}, "Press Space to play. Point at any frame to see why it plays as it does."),
      ),
      make("footer", {}, all, done),
    );
    done.addEventListener("click", () => {
      hint.hidden = true;
      remember(HINT_SEEN, "seen");
    });
    all.addEventListener("click", () => this.help());
    return hint;
  }

  private makeSplitter(): HTMLElement {
    const splitter = make("div", {
      class: "splitter",
      role: "separator",
      tabindex: 0,
      "aria-label": "Height of the timeline",
      "aria-orientation": "horizontal",
      "aria-valuemin": 180,
      "aria-valuemax": 700,
      "aria-valuenow": 330,
    });
    const stored = Number(recall("retime.timeline"));
    const set = (height: number): void => {
      const held = clamp(height, 180, Math.max(180, this.root.clientHeight - 220));
      this.root.style.setProperty("--timeline-height", `${Math.round(held)}px`);
      splitter.setAttribute("aria-valuenow", String(Math.round(held)));
      remember("retime.timeline", String(Math.round(held)));
      this.store.touch("size");
    };
    if (stored >= 180) queueMicrotask(() => set(stored));
    splitter.addEventListener("pointerdown", (down) => {
      splitter.setPointerCapture(down.pointerId);
      const start = this.timeline.root.clientHeight;
      const over = new AbortController();
      const { signal } = over;
      splitter.addEventListener("pointermove", (event) => set(start - (event.clientY - down.clientY)), { signal });
      splitter.addEventListener("pointerup", () => over.abort(), { signal });
      splitter.addEventListener("pointercancel", () => over.abort(), { signal });
    });
    splitter.addEventListener("keydown", (event) => {
      const by = { ArrowUp: 16, ArrowDown: -16 }[event.key];
      if (by === undefined) return;
      event.preventDefault();
      set(this.timeline.root.clientHeight + by);
    });
    return splitter;
  }
}
