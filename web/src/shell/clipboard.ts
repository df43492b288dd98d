/**
 * Copying and pasting keytimes. They travel as text, a line each as the command line takes them (`5=3.5@1/2`): between
 * tabs, into a mail, out of a table.
 */

import type { Connection } from "../connection";
import { GrammarError } from "../grammar";
import type { Player } from "../player";
import { takesText } from "../shortcuts";
import type { Store } from "../store";
import { deleteKeys, keysText, pasteKeys, readKeys } from "../together";
import { outputEnd } from "../warp";
import type { NoticeKind } from "./notices";

export class Clipboard {
  /** What was copied here last: where the browser gives no clipboard, and for pasting at the keytimes' own times. */
  private copied = "";

  constructor(
    private readonly store: Store,
    private readonly connection: Connection,
    private readonly player: Player,
    private readonly say: (kind: NoticeKind, text: string) => void,
  ) {}

  /**
   * Take the browser's own copy, cut and paste, wherever no text is taken; `asleep` says when there is nothing to. Where
   * the editor is all of the page, it need not have the focus.
   */
  listen(root: HTMLElement, isWholePage: boolean, asleep: () => boolean, signal: AbortSignal): void {
    const target = root.ownerDocument;
    const isOurs = (event: Event): boolean => {
      const focused = target.activeElement;
      const isHere = root.contains(focused) || (isWholePage && (focused === null || focused === target.body));
      if (asleep() || event.defaultPrevented || !isHere || takesText(focused)) return false;
      // Marked text, as that of a notice, is copied as such.
      return (target.getSelection()?.toString() ?? "") === "";
    };
    for (const kind of ["copy", "cut"] as const) {
      target.addEventListener(
        kind,
        (event) => {
          if (!isOurs(event) || !this.copy()) return;
          event.clipboardData?.setData("text/plain", this.copied);
          event.preventDefault();
          if (kind === "cut") this.cut();
        },
        { signal },
      );
    }
    target.addEventListener(
      "paste",
      (event) => {
        if (!isOurs(event)) return;
        event.preventDefault();
        this.paste(event.clipboardData?.getData("text/plain") || this.copied, true);
      },
      { signal },
    );
  }

  /** Put what was copied last at its own times: into another version of the same take. */
  pasteInPlace(): void {
    this.paste(this.copied, false);
  }

  /** Copy the chosen keytimes; whether there were any. */
  private copy(): boolean {
    const { document, chosenKeys } = this.store;
    if (!document || chosenKeys.size === 0) return false;
    this.copied = keysText(document, chosenKeys);
    return true;
  }

  private cut(): void {
    const { store, connection } = this;
    if (!store.document) return;
    connection.edit(deleteKeys(store.document, store.chosenKeys), "cut keys");
    store.select(null);
  }

  /** Paste keytimes, the first at the playhead and at the pose shown there, or all at their own times. */
  private paste(text: string, atPlayhead: boolean): void {
    const { store, connection, player } = this;
    const { document, knots } = store;
    if (!document || !knots || text.trim() === "") return;
    const room = { inputEnd: store.inputEnd, rate: store.rate, outputEnd: outputEnd(knots) };
    const { outputTime } = store.playback;
    const at = atPlayhead ? { outputTime, inputTime: store.shownInput(outputTime) } : null;
    try {
      const keys = readKeys(text, store.rate);
      const [next, ids] = pasteKeys(document, keys, at, room);
      const left = keys.length - ids.size;
      if (ids.size > 0) {
        player.stop();
        connection.edit(next, "paste keys");
        store.chooseKeys(ids);
      }
      if (left > 0) this.say("info", `${left} of ${keys.length} keytimes would lie outside, and were left out.`);
    } catch (error) {
      if (!(error instanceof GrammarError)) throw error;
      this.say("warning", `What was copied is no keytime: ${error.message}`);
    }
  }
}
