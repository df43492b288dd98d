/** The talk with the server: changes go out one at a time, answers land in the store. */

import { type AtNextFrame, Gate } from "./gate";
import { recallInTab, rememberInTab } from "./memory";
import { rebased } from "./merge";
import {
  type ArrayMessage,
  type Browse,
  type Document,
  type ExportCurve,
  type Found,
  type Listing,
  type PageMessage,
  type Refused,
  readArrays,
  type State,
  type TextMessage,
  VERSION,
  type Welcome,
} from "./messages";
import type { Store } from "./store";

/** One way to the server, however it travels. */
export interface Link {
  send(text: string): void;
}

export interface LinkEvents {
  opened(link: Link): void;
  text(text: string): void;
  bytes(frame: ArrayBuffer): void;
  closed(): void;
}

type Command =
  | { readonly type: "edit"; readonly gesture: string; done: boolean; label: string; document: Document }
  | { readonly type: "undo" }
  | { readonly type: "redo" }
  | { readonly type: "keep"; name: string };

/** An edit that did not come into the document: what it was made of, and what it made of that. */
interface LostEdit {
  readonly base: Document;
  readonly document: Document;
  readonly label: string;
}

/** Of which run and document a person was told in this tab how it came about. */
const TOLD = "retime.told";

export interface ConnectionEvents {
  notice(kind: "info" | "warning" | "error", text: string): void;
  listing(listing: Listing): void;
  found(found: Found): void;
  connected(): void;
  /** What is open was recovered from a run of the editor that ended before it was saved. */
  recovered(): void;
  /** What is open is the project that the clips were saved in. */
  resumed(path: string): void;
  /** An edit is not in the document, for another window was faster or the server died; it can be done again. */
  outrun(label: string, again: () => void): void;
  refused(refused: Refused): void;
  written(path: string): void;
  /** The server does not answer any more; what starts it again, where a command does. */
  lost(command: string): void;
  /** The page speaks another version than the server. */
  outdated(): void;
  /** A new document was opened: what belonged to the old one is over. */
  renewed(): void;
}

// The server saves an edit within milliseconds. If it has said nothing of one for this long, it has refused it.
const DOUBT_MS = 1500;

export class Connection implements LinkEvents {
  private link: Link | null = null;
  private readonly gate: Gate<Command>;
  /** The revision of the document that the page sent or received last. */
  private revision = 0;
  /** The change that has no answer yet: neither that it is saved nor its curve. */
  private inFlight: { readonly revision: number; readonly sent: number } | null = null;
  private doubt: ReturnType<typeof setTimeout> | undefined;
  private gestures = 0;
  /** When the hand moved, for curves that have not come yet and for those that have: for the tests' measurement. */
  private unansweredMoves: { revision: number; moves: readonly number[] }[] = [];
  private answeredMoves: number[] = [];
  /** What the server said of itself last. */
  private server: Welcome | null = null;
  private outdated = false;
  /** The document before the changes that have no answer yet, and the last of those. */
  private base: Document | null = null;
  private latest: { readonly document: Document; readonly label: string } | null = null;
  private lost: LostEdit | null = null;
  /** Whether the page waits to be told what another window made; and the gesture that was going on then. */
  private stale = false;
  private brokenGesture: string | null = null;
  private openGesture: string | null = null;

  constructor(
    private readonly store: Store,
    private readonly events: ConnectionEvents,
    atNextFrame: AtNextFrame,
  ) {
    this.gate = new Gate((change) => this.sendCommand(change.value, change.moves), atNextFrame);
  }

  get isConnected(): boolean {
    return this.link !== null;
  }

  /** Whether the server speaks another version: only a page that is loaded anew can talk with it. */
  get isOutdated(): boolean {
    return this.outdated;
  }

  /** Whether there are changes that the server has not answered. */
  get busy(): boolean {
    return this.gate.busy;
  }

  /** Make a name for a gesture that no other gesture has. */
  newGesture(): string {
    return `g${Date.now().toString(36)}-${++this.gestures}`;
  }

  /** Change the document. Edits of a gesture that is not `done` are parts of one undo step. */
  edit(document: Document, label: string, gesture = this.newGesture(), done = true, moved = performance.now()): void {
    const before = this.store.document;
    if (!before) return;
    if (!this.gate.busy || !this.base) this.base = before;
    if (this.stale || this.brokenGesture === gesture) {
      // It was made of a document that holds no more: sent, it would undo what another window did. What holds is shown.
      this.lost = { base: this.lost?.base ?? this.base, document, label };
      this.brokenGesture = done ? null : gesture;
      this.offerAgain();
      return;
    }
    this.store.setDocument(document);
    this.latest = { document, label };
    this.openGesture = done ? null : gesture;
    this.gate.offer({ type: "edit", gesture, done, label, document }, gesture, moved);
  }

  // What is on its way may make the step: its label comes with the answer, and who is quick has pressed the keys by then.
  undo(): void {
    if (this.store.state?.undo_label || this.gate.busy)
      this.gate.offer({ type: "undo" }, this.newGesture(), performance.now());
  }

  redo(): void {
    if (this.store.state?.redo_label || this.gate.busy)
      this.gate.offer({ type: "redo" }, this.newGesture(), performance.now());
  }

  keep(name: string): void {
    this.gate.offer({ type: "keep", name }, this.newGesture(), performance.now());
  }

  save(path: string | null, overwrite: boolean): void {
    this.say({ type: "save", path, overwrite });
  }

  open(path: string): void {
    this.say({ type: "open", path });
  }

  export(what: "motion" | "warp" | "picture", path: string, clip: number, overwrite: boolean): void {
    this.say({ type: "export", what, path, clip, overwrite });
  }

  exportCurve(curve: Omit<ExportCurve, "type">): void {
    this.say({ type: "export_curve", ...curve });
  }

  browse(folder: string | null, holds: Browse["holds"]): void {
    this.say({ type: "browse", folder, holds });
  }

  /** End the search that is at work, if one is that takes long. */
  stop(): void {
    const { progress } = this.store;
    if (progress) this.say({ type: "stop", revision: progress.revision });
  }

  /** Ask whether a file may be used; `asClip`: whether it can be read, as one more clip or reference. */
  find(path: string, { writing = false, asClip = false } = {}): void {
    this.say({ type: "find", path, writing, as_clip: asClip });
  }

  /** Moves whose curve has come since the last call. */
  takeMoves(): number[] {
    const moves = this.answeredMoves;
    this.answeredMoves = [];
    return moves;
  }

  /** With which this page can prove that it belongs to this editor; empty before it was told. */
  get key(): string {
    return this.server?.key ?? "";
  }

  /** Begin anew with the same clips. */
  beginAnew(): void {
    this.say({ type: "anew" });
  }

  opened(link: Link): void {
    this.link = link;
    this.forget();
    this.stale = false;
    this.brokenGesture = null;
    this.store.setState(null);
    this.revision = 0;
    this.say({ type: "hello", version: VERSION });
  }

  closed(): void {
    this.link = null;
    this.keepUnanswered();
    this.forget();
    this.store.setProgress(null);
    // It has told the page to go, and goes on: nothing has to be started again.
    if (!this.outdated) this.events.lost(this.server?.command ?? "");
  }

  text(text: string): void {
    const message = JSON.parse(text) as TextMessage;
    switch (message.type) {
      case "welcome":
        this.server = message;
        this.outdated = message.version !== VERSION;
        if (this.outdated) this.events.outdated();
        else this.events.connected();
        break;
      case "state":
        this.stated(message);
        break;
      case "ack":
        this.answer(message.revision);
        break;
      case "elsewhere":
        this.madeElsewhere(message.revision);
        break;
      case "refused":
        this.events.refused(message);
        break;
      case "progress":
        this.store.setProgress(message);
        break;
      case "problem":
        this.store.setProblem(message);
        this.settle(message.revision);
        break;
      case "notice":
        this.events.notice(message.kind, message.text);
        break;
      case "saved":
        this.events.notice("info", `Saved ${message.path}`);
        this.events.written(message.path);
        break;
      case "exported":
        this.events.notice("info", `Wrote ${message.path}${message.error && `: off by ${message.error}`}`);
        this.events.written(message.path);
        break;
      case "listing":
        this.events.listing(message);
        break;
      case "found":
        this.events.found(message);
        break;
    }
  }

  bytes(frame: ArrayBuffer): void {
    const message: ArrayMessage = readArrays(frame);
    const { store } = this;
    switch (message.type) {
      case "clip":
        store.setClip(message);
        break;
      case "curve":
        store.setCurve(message);
        this.settle(message.revision);
        break;
      case "why":
        store.setWhy(message);
        break;
      case "kept":
        store.setKept(message.id, { outputTimes: message.output_times, inputTimes: message.input_times });
        break;
    }
  }

  /** The server says how the document stands, at the revision that the page has sent last or at another. */
  private stated(message: State): void {
    const before = this.store.state;
    this.store.setState(message);
    // Another window was faster, or another document was opened: what the page was about to send is out of date.
    if (message.revision > this.revision) this.forget();
    if (message.revision < this.revision) {
      // The server told this before it had the page's last change. Perhaps it has refused that one: wait, and see.
      const sent = this.inFlight;
      clearTimeout(this.doubt);
      if (sent) {
        const refused = (): void => {
          if (this.inFlight === sent) this.takeBack();
        };
        this.doubt = setTimeout(refused, sent.sent + DOUBT_MS - performance.now());
      }
      return;
    }
    this.revision = message.revision;
    this.stale = false;
    if (before && before.opened !== message.opened) {
      this.store.clear();
      this.events.renewed();
    }
    this.tellOrigin(message);
    // While later changes wait, the page shows those: the document of an earlier answer would jump back.
    if (!this.gate.waits) this.store.setDocument(message.document);
    this.answer(message.revision);
    this.offerAgain();
  }

  /** Say once in this tab where the document comes from, where it was not just opened. */
  private tellOrigin({ recovered, resumed, path, opened }: State): void {
    const which = `${this.server?.run ?? ""} ${opened}`;
    if (!(recovered || resumed) || recallInTab(TOLD) === which) return;
    rememberInTab(TOLD, which);
    if (recovered) this.events.recovered();
    else this.events.resumed(path ?? "");
  }

  /** Another window has made a revision: what this page has sent, or was about to send, is out of date. */
  private madeElsewhere(revision: number): void {
    this.keepUnanswered();
    this.brokenGesture = this.openGesture;
    this.forget();
    this.revision = revision;
    this.stale = true;
  }

  /** Remember what has no answer: the server may not have it. */
  private keepUnanswered(): void {
    const { base, latest } = this;
    if (this.gate.busy && base && latest) this.lost = { base: this.lost?.base ?? base, ...latest };
  }

  /** Once it is known what holds, and no gesture goes on, offer to do again what was lost. */
  private offerAgain(): void {
    const { lost } = this;
    const now = this.store.document;
    if (!lost || this.stale || this.brokenGesture !== null || !now) return;
    this.lost = null;
    // It may have been written before the server died.
    if (JSON.stringify(rebased(lost.base, lost.document, now)) === JSON.stringify(now)) return;
    this.events.outrun(lost.label, () => {
      const { document } = this.store;
      if (document) this.edit(rebased(lost.base, lost.document, document), lost.label);
    });
  }

  private forget(): void {
    this.gate.reset();
    this.latest = null;
    this.openGesture = null;
    clearTimeout(this.doubt);
    this.inFlight = null;
    this.unansweredMoves = [];
  }

  private settle(revision: number): void {
    this.answeredMoves.push(
      ...this.unansweredMoves.filter((one) => one.revision <= revision).flatMap((one) => one.moves),
    );
    this.unansweredMoves = this.unansweredMoves.filter((one) => one.revision > revision);
    this.answer(revision);
  }

  /**
   * Let the next change go. It need not wait for the curve of the last one: of the documents that wait for it, the
   * solver takes the newest.
   */
  private answer(revision: number): void {
    if (!this.inFlight || revision < this.inFlight.revision) return;
    this.inFlight = null;
    this.gate.answered();
  }

  private sendCommand(command: Command, moves: readonly number[]): boolean {
    if (!this.link) return false;
    const revision = ++this.revision;
    this.unansweredMoves.push({ revision, moves });
    this.inFlight = { revision, sent: performance.now() };
    this.say({ ...command, revision });
    return true;
  }

  /** The server refused a change: what it told last is what holds. */
  private takeBack(): void {
    this.forget();
    const { state } = this.store;
    if (!state) return;
    this.revision = state.revision;
    this.store.setDocument(state.document);
  }

  private say(message: PageMessage): void {
    if (this.link) this.link.send(JSON.stringify(message));
    else if (!this.outdated) this.events.notice("error", "The server does not answer: this could not be sent.");
  }
}
