/** The editor, put together on an element: the page in a browser tab, or a widget in a notebook. */

import { Connection } from "./connection";
import { make } from "./dom";
import { Frames } from "./frames";
import { tellFrame, tellLatency } from "./latency";
import { setMedia } from "./media/edits";
import { isMedia } from "./media/endings";
import { FilmDialog } from "./media/film_dialog";
import { MediaLoader } from "./media/loader";
import { MediaPanel } from "./media/panel";
import type { Refused } from "./messages";
import { Dialogs } from "./panels/dialogs/dialogs";
import { askForWelcome, WelcomeDialog } from "./panels/dialogs/welcome";
import { Inspector } from "./panels/inspector";
import { StageBar } from "./panels/stage_bar";
import { fileName, TopBar } from "./panels/top";
import { Transport } from "./panels/transport";
import { WhyPanel } from "./panels/why_panel";
import { Player } from "./player";
import { WhenQuiet } from "./quiet";
import { ClipCheck } from "./shell/clip_check";
import { Clipboard } from "./shell/clipboard";
import { DropNote } from "./shell/drop_note";
import { fileSender, listenForDrops, type TakeFiles, type Upload } from "./shell/files";
import { giveKeysBack } from "./shell/give_keys_back";
import { Hint } from "./shell/hint";
import { BY_HAND, shortcutTable } from "./shell/keyboard";
import { listenForMenus } from "./shell/menus";
import { Notices, type Remedy } from "./shell/notices";
import { ProgressBar, progressWords } from "./shell/progress";
import { makeSplitter } from "./shell/splitter";
import { Veil } from "./shell/veil";
import { listen, type Shortcut } from "./shortcuts";
import { Stage } from "./stage/stage";
import { Store, type Topic } from "./store";
import { Theme } from "./theme";
import { Timeline } from "./timeline/timeline";
import { unitsOf } from "./units";

export interface AppOptions {
  /** Sends a file that was dropped or picked to the server; left out, where files can't be sent. */
  readonly upload?: Upload;
  /** Shortcuts are heard on the whole window, or only on the editor's element. */
  readonly shortcutsFrom?: "window" | "element";
}

/** While something is dragged, the panels follow when the hand has rested for some milliseconds, or after so many. */
const PANELS_REST = 80;
const PANELS_MOST = 1000;
/**
 * Milliseconds between what the panels show while it plays. Nobody reads numbers that change more often, and to lay out
 * and paint them anew takes the browser more than the page's own work for a picture.
 */
const PANELS_PLAYED = 50;

export class App {
  readonly connection: Connection;
  private readonly store: Store;
  private readonly player: Player;
  private readonly theme: Theme;
  private readonly frames: Frames;
  private readonly stageRoot = make("div", { class: "stage" });
  private readonly stage: Stage;
  private readonly timeline: Timeline;
  /** What follows the timeline and the stage when there is time. */
  private readonly panels: { update(changed: Set<Topic>): void }[];
  private readonly dialogs: Dialogs;
  private readonly clipboard: Clipboard;
  private readonly shortcuts: readonly Shortcut[];
  private readonly notices = new Notices();
  private readonly veil = new Veil();
  private readonly progress: ProgressBar;
  private readonly dropNote: DropNote;
  private readonly clipCheck: ClipCheck;
  private readonly hint = new Hint(() => this.help());
  private readonly ends = new AbortController();
  /** What the panels have not shown yet. */
  private readonly unshown = new Set<Topic>();
  /** When they showed it last, as `performance.now()` counts. */
  private panelsShown = -Infinity;
  private readonly panelsLater = new WhenQuiet(() => this.showPanels(), PANELS_REST, PANELS_MOST);

  constructor(
    private readonly root: HTMLElement,
    options: AppOptions = {},
  ) {
    root.classList.add("retime");
    root.tabIndex = -1;
    this.store = new Store(() => this.frames.ask());
    this.player = new Player(this.store);
    this.theme = new Theme(root);
    const drawn = (began: number): void => tellFrame(root, began);
    this.frames = new Frames(this.store, this.theme, this.player, (changed) => this.draw(changed), drawn);
    this.theme.listen(() => this.store.recolored());
    this.dropNote = new DropNote(root);
    this.connection = this.makeConnection();
    this.clipCheck = new ClipCheck(this.connection);
    const send = options.upload
      ? fileSender(
          options.upload,
          (kind, text) => {
            if (kind !== "error" || !this.dropNote.refuse(text)) this.notices.say(kind, text);
          },
          (path) => this.openFile(path),
          (path, take) => this.checkClip(path, take),
        )
      : null;
    this.dialogs = new Dialogs(root, this.store, this.connection, send);
    this.timeline = new Timeline(this.store, this.connection, this.theme, (time) => this.player.scrub(time));
    this.progress = new ProgressBar(this.store, () => this.connection.stop());
    this.timeline.root.append(this.progress.root);
    this.stage = new Stage(this.stageRoot, this.store, this.theme);
    const media = new MediaPanel(this.store);
    const stageBar = new StageBar(this.store, this.stageRoot, () => this.stage.frame());
    const transport = this.makeTransport();
    const top = this.makeTopBar();
    const why = new WhyPanel(this.store);
    const inspector = new Inspector(this.store, this.connection, this.dialogs);
    inspector.root.prepend(this.hint.root);
    this.panels = [transport, top, stageBar, inspector, why, media];
    this.clipboard = new Clipboard(this.store, this.connection, this.player, (kind, text) =>
      this.notices.say(kind, text),
    );
    // What is not sent to the server by HTTP is not fetched from it either.
    if (options.upload) {
      this.panels.push(new MediaLoader(this.store, (address) => media.show(address)));
      this.offerWelcome();
      this.dialogs.keepOutput = (take) => this.keepOutput(take);
      this.dialogs.addFilm(new FilmDialog(this.store, this.stage, this.theme));
    }
    this.shortcuts = shortcutTable(this.store, this.connection, this.player, this.timeline, this.dialogs, {
      save: () => this.save(),
      help: () => this.help(),
      swap: () => this.swap(),
      pasteInPlace: () => this.clipboard.pasteInPlace(),
    });
    if (!this.stage.works) {
      const words = "This browser has no WebGL: the stage stays empty, all else works.";
      this.stageRoot.append(make("p", { class: "caption" }, words));
    }
    root.append(
      top.root,
      make(
        "main",
        { class: "work" },
        make("div", { class: "unseen" }, make("h1", {}, "retime editor")),
        make("div", { class: "besides" }, this.stageRoot, media.root),
        transport.root,
        makeSplitter(root, this.timeline.root, () => this.store.resized()),
        this.timeline.root,
      ),
      make("aside", { class: "side", "aria-label": "Properties" }, inspector.root, why.root),
      this.notices.root,
      this.dropNote.root,
      this.veil.root,
    );
    this.veil.cover("Opening…");
    this.listen(options, send);
    this.store.begin();
  }

  /** Take the editor off the page. */
  close(): void {
    this.ends.abort();
  }

  private makeConnection(): Connection {
    const { notices, veil } = this;
    return new Connection(
      this.store,
      {
        notice: (kind, text) => notices.say(kind, text),
        listing: (listing) => this.dialogs.list(listing),
        found: (found) => {
          if (!this.clipCheck.found(found)) this.dialogs.found(found);
        },
        connected: () => {
          if (this.store.knots) veil.lift();
          this.hint.offer();
        },
        recovered: () =>
          notices.say(
            "warning",
            "The last session ended before this was saved. Everything that was done is back.",
            this.beginAnew,
          ),
        resumed: (path) =>
          notices.say("warning", `This is ${fileName(path)}, where these clips were saved.`, this.beginAnew),
        outrun: (label, action) =>
          notices.say("warning", `“${label}” was not done: the document has changed meanwhile.`, {
            word: "Do it again",
            action,
          }),
        refused: (refused) => this.refused(refused),
        written: (path) => this.dialogs.written(path),
        lost: (command) => {
          veil.coverWithCommand(
            "The server has stopped answering. What you did is kept: start it again, and this page goes on from there.",
            command,
          );
          this.dialogs.lost();
          this.clipCheck.lost();
          this.dropNote.taken();
        },
        outdated: () => {
          // A dialog would lie over it, and nothing that is asked in one can be done.
          for (const dialog of this.root.querySelectorAll("dialog")) dialog.close();
          veil.coverWithRemedy("This page is of another version than its server. What you did is kept.", {
            word: "Load it again",
            action: () => location.reload(),
          });
          this.dialogs.lost();
        },
        renewed: () => this.renewed(),
      },
      (callback) => requestAnimationFrame(callback),
    );
  }

  private makeTransport(): Transport {
    const { store, player } = this;
    return new Transport(store, {
      play: () => player.toggle(),
      toStart: () => player.toEdge("start"),
      toEnd: () => player.toEdge("end"),
      step: (frames) => player.step(frames),
      loop: () => player.toggleLoop(),
      clock: (clock) => player.lead(clock),
      link: () => player.toggleLink(),
      snap: () => store.look({ snap: !store.view.snap }),
      fit: () => this.timeline.fit(),
      scrub: (axis, time) => (axis === "output" ? player.scrub(time) : player.scrubInput(time)),
      units: (units) => store.look({ units }),
    });
  }

  private makeTopBar(): TopBar {
    const { store, connection, dialogs, theme } = this;
    return new TopBar(store, () => theme.dark, {
      undo: () => connection.undo(),
      redo: () => connection.redo(),
      open: () => dialogs.showOpen(),
      save: () => this.save(),
      export: () => dialogs.showExport(),
      theme: () => theme.choose(theme.dark ? "light" : "dark"),
      help: () => this.help(),
    });
  }

  private listen(options: AppOptions, send: TakeFiles | null): void {
    const { root, store } = this;
    const { signal } = this.ends;
    const size = new ResizeObserver(() => store.resized());
    for (const element of [root, this.timeline.root, this.stageRoot]) size.observe(element);
    const target = options.shortcutsFrom === "element" ? root : window;
    const asleep = (): boolean => this.dialogs.isOpen || !store.document;
    const end = listen(target, this.shortcuts, asleep);
    this.clipboard.listen(root, target === window, asleep, signal);
    signal.addEventListener("abort", () => {
      end();
      size.disconnect();
    });
    giveKeysBack(root);
    const endMenus = listenForMenus(root, {
      store,
      connection: this.connection,
      player: this.player,
      timeline: this.timeline,
      stage: this.stage,
      dialogs: this.dialogs,
      save: () => this.save(),
      help: () => this.help(),
    });
    signal.addEventListener("abort", endMenus);
    if (send) listenForDrops(root, store, this.connection, send, (event) => this.dropNote.dropped(event), signal);
    window.addEventListener(
      "beforeunload",
      (event) => {
        if (this.connection.busy) event.preventDefault();
      },
      { signal },
    );
  }

  private draw(changed: Set<Topic>): void {
    const { store } = this;
    if (changed.has("curve") && store.knots && this.connection.isConnected) this.veil.lift();
    this.progress.update(changed);
    if (changed.has("status")) this.dialogs.progress();
    if (changed.has("status") && store.progress) this.veil.tell(`${progressWords(store)} (Esc stops it)`);
    if (store.problem && !store.clip) this.veil.coverWithProblem(store.problem.message);
    this.root.dataset.units = unitsOf(store);
    this.timeline.update(changed);
    this.root.style.setProperty("--timeline-rows", `${this.timeline.rowsHeight}px`);
    if (changed.has("curve")) tellLatency(this.root, this.connection.takeMoves());
    this.stage.update(changed);
    for (const topic of changed) this.unshown.add(topic);
    // Whoever drags looks at the curve: that is painted first, and the panels follow when there is time.
    if (store.dragging) this.panelsLater.ask();
    else if (!this.playsOn(changed)) this.showPanels();
  }

  /** Whether it plays, and the panels have shown a moment short enough ago. */
  private playsOn(changed: ReadonlySet<Topic>): boolean {
    const isOld = performance.now() - this.panelsShown >= PANELS_PLAYED;
    return this.player.isPlaying && !isOld && [...changed].every((topic) => topic === "playhead");
  }

  private showPanels(): void {
    this.panelsShown = performance.now();
    this.panelsLater.cancel();
    const changed = new Set(this.unshown);
    this.unshown.clear();
    for (const panel of this.panels) panel.update(changed);
  }

  private get beginAnew(): Remedy {
    return { word: "Begin anew", action: () => this.connection.beginAnew() };
  }

  /** A file was refused: that is said in the dialog that asks for it, beside the drop, or over the page. */
  private refused(refused: Refused): void {
    const { what, path, reason } = refused;
    if (this.dialogs.refused(refused)) return;
    // Where it lies now that it was dropped is nothing that who dropped it knows.
    if (what === "open" && this.dropNote.refuse(reason.replaceAll(path, fileName(path)))) return;
    const words = { open: "Not opened", save: "Not saved", export: "Not exported" }[what];
    this.notices.say(
      "error",
      reason.includes(path) || path === "" ? `${words}: ${reason}` : `${words}: ${path}: ${reason}`,
    );
  }

  /** Another document was opened. */
  private renewed(): void {
    const { store } = this;
    this.dropNote.taken();
    this.veil.cover("Opening…");
    this.notices.clear();
    store.select(null);
    store.point(null);
    this.player.rewind();
    store.look({ companion: "input", showB: false, clip: 0, reference: 0, through: false, paintsInfluence: false });
    this.timeline.fit();
  }

  /** Have the output kept as a file; where that can't be, say why. */
  private async keepOutput(take: (path: string) => void): Promise<void> {
    try {
      const answer = await fetch("/output", { method: "POST" });
      if (!answer.ok) throw new Error(await answer.text());
      take(((await answer.json()) as { path: string }).path);
    } catch (error) {
      this.notices.say("error", error instanceof Error ? error.message : String(error));
    }
  }

  /** Where nothing was named to edit, begin with what could be. */
  private offerWelcome(): void {
    const dialog = new WelcomeDialog(this.connection, () => this.dialogs.showOpen());
    this.dialogs.add(dialog.root);
    void askForWelcome().then((welcome) => {
      if (welcome?.show && !this.connection.isOutdated) dialog.show(welcome);
    });
  }

  /** Open a clip or a project; a video or a sound is put beside the one that is open. */
  private openFile(path: string): void {
    const { document } = this.store;
    if (document && isMedia(path)) {
      this.dropNote.taken();
      this.connection.edit(setMedia(document, { path }), "choose media");
    } else this.connection.open(path);
  }

  /** Have a clip read before the document names it; where it can't be, say why where it was dropped, or over the page. */
  private checkClip(path: string, take: (place: string) => void): void {
    const name = fileName(path);
    this.dropNote.tell(`Reading ${name}…`);
    this.clipCheck.ask(
      path,
      (place) => {
        this.dropNote.taken();
        take(place);
      },
      (reason) => {
        const words = reason.replaceAll(path, name);
        if (!this.dropNote.refuse(words)) this.notices.say("error", `Not added: ${words}`);
      },
    );
  }

  private save(): void {
    if (this.store.state?.path) this.connection.save(null, true);
    else this.dialogs.showSave();
  }

  private help(): void {
    this.dialogs.showHelp(this.shortcuts, BY_HAND);
  }

  private swap(): void {
    if (this.store.companionKnots) this.store.look({ showB: !this.store.view.showB });
    else this.notices.say("info", "Choose what to compare with first: at the right, Compare with.");
  }
}
