/** Notices over the page: good news goes by itself, bad news stays until it was read. */

import { make } from "../dom";

export type NoticeKind = "info" | "warning" | "error";

const MOST = 4;
/** How long good news stays, milliseconds. */
const SHOWN = 6000;

/** What can be done about it. */
export interface Remedy {
  readonly word: string;
  readonly action: () => void;
}

export class Notices {
  readonly root = make("div", { class: "notices", "aria-live": "polite" });

  /** What they spoke of is gone. */
  clear(): void {
    this.root.replaceChildren();
  }

  /** Say something; where something can be done about it, that stays too until it was read. */
  say(kind: NoticeKind, text: string, remedy?: Remedy): void {
    const close = make("button", { type: "button", class: "button bare", "aria-label": "Close" }, "✕");
    const role = kind === "info" ? "status" : "alert";
    const notice = make("div", { class: "notice", "data-kind": kind, role }, make("p", {}, text), close);
    const gone = (): void => notice.remove();
    close.addEventListener("click", gone);
    if (remedy) {
      const button = make("button", { type: "button", class: "button framed" }, remedy.word);
      button.addEventListener("click", () => {
        gone();
        remedy.action();
      });
      close.before(button);
    } else if (kind === "info") setTimeout(gone, SHOWN);
    this.root.append(notice);
    while (this.root.childElementCount > MOST) this.root.firstElementChild?.remove();
  }
}
