/** Sections: the parts of the side, each under a heading of its own. */

import type { Connection } from "../../connection";
import { make } from "../../dom";
import type { Document, Problem } from "../../messages";
import type { Store } from "../../store";
import type { Dialogs } from "../dialogs/dialogs";

/** What a section is made with. */
export interface Side {
  readonly store: Store;
  readonly connection: Connection;
  readonly dialogs: Dialogs;
  readonly faults: FaultyFields;
}

export interface Section {
  readonly root: HTMLElement;
  /** Show the document as it is now; called only where there is one. */
  update(): void;
}

/** Make a section's element; `actions` stand beside the heading. */
export function frame(
  title: string,
  ...actions: HTMLElement[]
): { root: HTMLElement; heading: HTMLElement; body: HTMLElement } {
  const heading = make("h2", {}, title);
  const body = make("div");
  const header = make("header", {}, heading, make("span", { class: "pair" }, ...actions));
  return { root: make("section", { "aria-label": title }, header, body), heading, body };
}

/** A label, and something that is no single field. */
export function row(label: string, ...content: HTMLElement[]): HTMLElement {
  return make("div", { class: "row" }, make("span", { class: "label", title: label }, label), ...content);
}

/** The document that sections show and change. */
export function documentOf(store: Store): Document {
  if (!store.document) throw new Error("sections are shown once there is a document");
  return store.document;
}

/** The fields whose value may be at fault, by their names in the document. */
export class FaultyFields {
  private readonly fields = new Map<string, { blame(message: string | null): void }>();

  /** Note what can say that it is at fault. */
  named(name: string, field: { blame(message: string | null): void }): void {
    this.fields.set(name, field);
  }

  /** Say beside the field at fault what is wrong with it. */
  show(problem: Problem | null): void {
    for (const [name, field] of this.fields) field.blame(problem?.field === name ? problem.message : null);
  }
}
