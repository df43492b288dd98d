/** The side: everything that can be typed, section by section. */

import type { Connection } from "../connection";
import { make } from "../dom";
import type { Store, Topic } from "../store";
import type { Dialogs } from "./dialogs/dialogs";
import { clipsSection } from "./sections/clips";
import { compareSection } from "./sections/compare";
import { flightsSection } from "./sections/flights";
import { keytimeSection } from "./sections/keytime";
import { locksSection } from "./sections/locks";
import { markersSection } from "./sections/markers";
import { mediaSection } from "./sections/media";
import { propagateSection } from "./sections/propagate";
import { referencesSection } from "./sections/references";
import { searchSection } from "./sections/search";
import { FaultyFields, type Section } from "./sections/section";
import { timingSection } from "./sections/timing";

const TOPICS: readonly Topic[] = ["document", "curve", "selection", "clips", "view", "beside"];

export class Inspector {
  readonly root: HTMLElement;
  private readonly faults = new FaultyFields();
  private readonly sections: readonly Section[];

  constructor(
    private readonly store: Store,
    connection: Connection,
    dialogs: Dialogs,
  ) {
    const side = { store, connection, dialogs, faults: this.faults };
    this.sections = [
      keytimeSection,
      timingSection,
      locksSection,
      flightsSection,
      markersSection,
      propagateSection,
      referencesSection,
      compareSection,
      clipsSection,
      mediaSection,
      searchSection,
    ].map((makeSection) => makeSection(side));
    this.root = make("div", { class: "sections" }, ...this.sections.map((section) => section.root));
  }

  update(changed: Set<Topic>): void {
    if (!this.store.document || !TOPICS.some((topic) => changed.has(topic))) return;
    for (const section of this.sections) section.update();
    this.faults.show(this.store.problem);
  }
}
