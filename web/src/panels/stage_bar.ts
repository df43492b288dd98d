/** What lies over the stage: how it is looked at, and who is who. */

import { make, setAttribute, setText } from "../dom";
import { cameraOf } from "../stage/cameras";
import { hasSkin } from "../stage/skinned";
import type { Looked, Store, Topic } from "../store";
import { said } from "../units";
import type { ViewSettings } from "../view_settings";
import { nearestMatch } from "../why";
import { ChannelList } from "./channels";

type Switch = "follow" | "ground" | "trails" | "onion" | "ghost" | "mesh" | "through";

export class StageBar {
  readonly root: HTMLElement;
  private readonly layouts: Record<ViewSettings["layout"], HTMLButtonElement>;
  private readonly switches: Record<Switch, HTMLButtonElement>;
  private readonly channels: ChannelList;
  private readonly left = caption("input");
  private readonly right = caption("output");
  private readonly match = caption("reference");
  private readonly divider = make("div", { class: "divider", "aria-hidden": true });

  constructor(
    private readonly store: Store,
    parent: HTMLElement,
    frame: () => void,
  ) {
    const layout = (name: ViewSettings["layout"], text: string, title: string): HTMLButtonElement => {
      const made = make("button", { type: "button", class: "button", title }, text);
      made.addEventListener("click", () => store.look({ layout: name }));
      return made;
    };
    this.layouts = {
      side: layout("side", "Side by side", "Input on the left, output on the right (V)"),
      over: layout("over", "Overlaid", "Input and output in one place (V)"),
    };
    const make_switch = (name: Switch, text: string, title: string): HTMLButtonElement => {
      const made = make("button", { type: "button", class: "button", title }, text);
      made.addEventListener("click", () => {
        store.look({ [name]: !store.view[name] });
        if (name === "follow") frame();
      });
      return made;
    };
    this.switches = {
      follow: make_switch("follow", "Follow", "The camera goes with the figure"),
      ground: make_switch("ground", "Ground", "Grid and shadow"),
      trails: make_switch("trails", "Trails", "Where hands, feet and head go: a dot each thirtieth of a second (T)"),
      onion: make_switch(
        "onion",
        "Onion skins",
        "Bodies at even output times: before in one tint, after in another (O)",
      ),
      mesh: make_switch("mesh", "Mesh", "The character's own mesh, or its bare joints"),
      ghost: make_switch("ghost", "Match", "The pose that the frame was matched with, over the output's (G)"),
      through: make_switch("through", "Through camera", "See both sides through the group's camera"),
    };
    const reset = make("button", { type: "button", class: "button", title: "Look from where it began" }, "Reset view");
    reset.addEventListener("click", frame);
    this.channels = new ChannelList(store);
    this.root = make(
      "div",
      { class: "bar", role: "toolbar", "aria-label": "Stage" },
      make("span", { class: "group", role: "group", "aria-label": "Layout" }, this.layouts.side, this.layouts.over),
      this.channels.root,
      make("span", { class: "gap" }),
      make(
        "span",
        { class: "group", role: "group", "aria-label": "Shown" },
        this.switches.through,
        this.switches.follow,
        this.switches.ground,
        this.switches.trails,
        this.switches.onion,
        this.switches.ghost,
        this.switches.mesh,
        reset,
      ),
    );
    parent.append(this.divider, this.root, this.left, this.right, this.match);
  }

  update(changed: Set<Topic>): void {
    if (
      !["view", "playhead", "hover", "why", "curve", "clips", "document"].some((topic) => changed.has(topic as Topic))
    )
      return;
    const { view, why, references } = this.store;
    const { by, outputTime: looked, inputTime } = this.store.looked;
    for (const name of ["side", "over"] as const)
      setAttribute(this.layouts[name], "aria-pressed", String(view.layout === name));
    for (const name of ["follow", "ground", "trails", "onion", "ghost", "mesh", "through"] as const) {
      setAttribute(this.switches[name], "aria-pressed", String(view[name]));
    }
    this.switches.mesh.hidden = !this.store.clips.some(hasSkin);
    this.switches.through.hidden = cameraOf(this.store.clips, view.clip) === null;
    this.channels.update();
    const side = view.layout === "side";
    this.divider.hidden = !side;
    const isInput = view.companion === "input";
    const otherTime = `${said(this.store, isInput ? inputTime : looked)}${WHERE[by]}`;
    this.left.dataset.is = isInput ? "input" : "other";
    fill(this.left, view.showB ? "This warp" : this.store.companionName, otherTime);
    const where = WHERE[by];
    fill(
      this.right,
      view.showB ? `Output, ${this.store.companionName}` : "Output",
      `${said(this.store, looked)}${where}`,
    );
    this.left.style.left = "8px";
    this.right.style.left = side ? "calc(50% + 8px)" : "auto";
    if (!side) {
      this.right.style.left = `${this.left.offsetLeft + this.left.offsetWidth + 6}px`;
    }
    const match = why && (view.ghost || by === "pointer") && !this.store.dragging ? nearestMatch(why, looked) : null;
    this.match.hidden = match === null;
    if (match) {
      const name = match.source < 0 ? "itself" : (references[match.source]?.name ?? match.name);
      fill(this.match, "Matched pose", `${name} at ${said(this.store, this.store.wholeTime(match))}`);
      this.match.style.right = "8px";
    }
  }
}

/** Why the stage shows another moment than the playhead's. */
const WHERE: Record<Looked["by"], string> = { key: " (the keytime)", pointer: " (under the pointer)", playhead: "" };

function caption(is: string): HTMLElement {
  return make("div", { class: "caption", "data-is": is }, make("b"), " ", make("span"));
}

function fill(element: HTMLElement, name: string, text: string): void {
  setText(element.children[0] as Element, name);
  setText(element.children[1] as Element, text);
}
