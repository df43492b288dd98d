/** The dialogs, and which of them is meant by what the server answers. */

import type { Connection } from "../../connection";
import type { FilmDialog } from "../../media/film_dialog";
import type { Found, Listing, Refused } from "../../messages";
import type { TakeFiles } from "../../shell/files";
import type { Shortcut } from "../../shortcuts";
import type { Store } from "../../store";
import { HelpDialog } from "./help";
import { OpenDialog, type Wanted } from "./open";
import { type Export, WriteDialog } from "./write";

export class Dialogs {
  private readonly help: HelpDialog;
  private readonly open: OpenDialog;
  private readonly write: WriteDialog;

  constructor(
    private readonly root: HTMLElement,
    store: Store,
    connection: Connection,
    send: TakeFiles | null,
  ) {
    this.help = new HelpDialog(store);
    this.open = new OpenDialog(connection, send);
    this.write = new WriteDialog(store, connection);
    this.add(this.help.root);
    this.add(this.open.root);
    this.add(this.write.root);
  }

  /** Keeps the output as a file, and hands on its path; null where the server can't be asked for it. */
  keepOutput: ((take: (path: string) => void) => Promise<void>) | null = null;

  /** Take in the dialog that films the stage. */
  addFilm(film: FilmDialog): void {
    this.add(film.root);
    this.write.film = film;
  }

  /** Take one more dialog in. */
  add(dialog: HTMLDialogElement): void {
    this.root.append(dialog);
  }

  get isOpen(): boolean {
    return this.root.querySelector("dialog[open]") !== null;
  }

  showHelp(shortcuts: readonly Shortcut[], byHand: readonly (readonly [string, string])[]): void {
    this.help.show(shortcuts, byHand);
  }

  /** Choose a file: a document to open, or one that is wanted for something else. */
  showOpen(wanted?: Wanted): void {
    this.open.show(wanted);
  }

  showSave(): void {
    this.write.show(true);
  }

  /** Ask what to export; `what` is chosen first. */
  showExport(what?: Export): void {
    this.write.show(false, what);
  }

  list(listing: Listing): void {
    this.open.list(listing);
  }

  /** A file was refused; whether a dialog asked for it, and says so. */
  refused(refused: Refused): boolean {
    return refused.what === "open" ? this.open.refused(refused) : this.write.refused(refused);
  }

  /** A search goes on, or is over. */
  progress(): void {
    this.write.progress();
  }

  /** A file was written. */
  written(path: string): void {
    this.write.written(path);
  }

  /** The server is gone: nothing more is heard of what it was asked for. */
  lost(): void {
    this.write.stopWaiting();
    this.open.stopWaiting();
  }

  found(found: Found): void {
    this.open.found(found);
    this.write.found(found);
  }
}
