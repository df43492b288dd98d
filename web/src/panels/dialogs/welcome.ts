/** Where nothing was named to edit: the sample lies open, and what was opened last can be again. */

import type { Connection } from "../../connection";
import { make } from "../../dom";
import { icon } from "../../icons";
import { closeButton, form, makeDialog } from "./dialog";

export interface Welcome {
  readonly show: boolean;
  readonly recent: readonly { readonly path: string; readonly name: string }[];
}

export class WelcomeDialog {
  readonly root = makeDialog("Welcome");

  constructor(
    private readonly connection: Connection,
    private readonly showOpen: () => void,
  ) {}

  show({ recent }: Welcome): void {
    const title = make("h3", { tabindex: -1 }, "Welcome to retime");
    const words = make(
      "p",
      { class: "note" },
      "Give a motion the timing that you want: name a few moments, and the rest finds its own. A sample lies open to try it on.",
    );
    const list = make("ul", { class: "files recent", "aria-label": "Opened last" });
    for (const { path, name } of recent) {
      const folder = path.slice(0, path.length - name.length).replace(/[\\/]$/u, "");
      const open = make(
        "button",
        { type: "button", class: "button", title: path },
        icon("file"),
        name,
        make("span", { class: "note" }, folder),
      );
      open.addEventListener("click", () => {
        this.root.close();
        this.connection.open(path);
      });
      list.append(make("li", {}, open));
    }
    const last = recent.length > 0 ? [make("h4", {}, "Opened last"), list] : [];
    const another = make(
      "button",
      { type: "button", class: "button framed" },
      icon("open"),
      "Open a clip or a project…",
    );
    another.addEventListener("click", () => {
      this.root.close();
      this.showOpen();
    });
    const sample = closeButton(this.root, "Try the sample");
    sample.classList.replace("framed", "main");
    this.root.replaceChildren(form(title, [words, ...last], [another, make("span", { class: "gap" }), sample]));
    this.root.showModal();
    title.focus();
  }
}

/** What the server says to begin with; null where it says nothing. */
export async function askForWelcome(): Promise<Welcome | null> {
  const answer = await fetch("/welcome");
  return answer.ok ? ((await answer.json()) as Welcome) : null;
}
