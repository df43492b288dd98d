/** Video and sound: what stands beside the stage, whose time it keeps, and beats to put keytimes on. */

import { make, setText } from "../../dom";
import { parseTime } from "../../grammar";
import { offsetOf } from "../../media/beside";
import { setBeats, setMedia } from "../../media/edits";
import type { BeatsFile, Document } from "../../messages";
import { button, iconButton } from "../buttons";
import { check, choice, textField } from "../fields";
import { offsetScrub } from "../scrub";
import { fileName } from "../top";
import { documentOf, frame, row, type Section, type Side } from "./section";

type Source = "none" | "beats" | "onsets" | "file" | "other";

export function mediaSection({ store, connection, dialogs }: Side): Section {
  const edit = (document: Document, label: string): void => connection.edit(document, label);
  const choose = (): void =>
    dialogs.showOpen({
      title: "Choose a video or a sound",
      holds: "media",
      take: (path) => edit(setMedia(documentOf(store), { path }), "choose media"),
    });
  const add = button("Add…", "Show a video, or play a sound, beside the stage", choose, "plus");
  const { root, body } = frame("Video and sound", add);

  const name = button("", "Choose another file", choose);
  name.classList.add("framed", "wide");
  const drop = iconButton("trash", "Take it away", () => edit(setMedia(documentOf(store), null), "remove media"));
  const file = row("File", make("span", { class: "pair" }, name, drop));
  const trouble = make("p", { class: "refused", role: "alert", hidden: true });

  const clock = choice<"input" | "output">(
    "Goes with",
    "A take that was filmed with the motion goes with the input, through the warp; a song that is danced to keeps the output's time",
    (value) => edit(setMedia(documentOf(store), { clock: value }), "choose clock of media"),
  );
  const offset = textField(
    "Begins at",
    "How long after the first frame it begins: 0.5s, -12f",
    (text) => {
      if (text !== "") parseTime(text, store.rate);
      edit(setMedia(documentOf(store), { offset: text === "" ? null : text }), "set offset of media");
      return true;
    },
    offsetScrub(
      { store, connection },
      "set offset of media",
      ({ media }) => (media ? offsetOf(media, store.rate) : 0),
      (before, written) => setMedia(before, { offset: written }),
    ),
  );
  offset.input.placeholder = "0";
  const heard = check("Heard while it plays", "Play the sound too", (on) => store.look({ heard: on }));

  const source = choice<Source>("Beats", "Moments to put keytimes on", (value) => {
    const chosen: Record<Exclude<Source, "other">, BeatsFile | null> = {
      none: null,
      beats: { path: null, on: "beats" },
      onsets: { path: null, on: "onsets" },
      file: documentOf(store).beats,
    };
    if (value !== "other") edit(setBeats(documentOf(store), chosen[value]), "choose beats");
    else {
      // Until a file is chosen, what held goes on.
      update();
      dialogs.showOpen({
        title: "Choose beats",
        holds: "beats",
        take: (path) => edit(setBeats(documentOf(store), { path, on: "beats" }), "choose beats"),
      });
    }
  });
  const snap = check(
    "Keytimes snap to beats",
    "A keytime that is dragged near a beat lands on it; not with Alt",
    (on) => store.look({ snapBeats: on }),
  );
  const found = make("p", { class: "note", role: "status" });
  const refused = make("p", { class: "refused", role: "alert", hidden: true });
  const details = make("div", {}, file, trouble, clock.row, offset.row, heard.row);
  const elsewhere = make(
    "p",
    { class: "note", hidden: true },
    "A notebook shows none: save the project, and open it by retime edit.",
  );
  body.append(elsewhere, details, source.row, found, refused, snap.row);

  const update = (): void => {
    const document = documentOf(store);
    const { media, beats } = document;
    // A notebook's page has no way to the file.
    const served = dialogs.keepOutput !== null;
    elsewhere.hidden = served;
    for (const part of [source.row, add]) part.hidden = !served;
    const { beside, view } = store;
    details.hidden = media === null || !served;
    if (media !== null) add.hidden = true;
    if (media) {
      setText(name, fileName(media.path));
      name.title = media.path;
      clock.show(
        [
          { value: "input", text: "The input, by the warp" },
          { value: "output", text: "The output" },
        ],
        media.clock,
      );
      offset.show(media.offset ?? "");
    }
    say(trouble, beside.mediaTrouble);
    heard.show(view.heard);
    const options: { value: Source; text: string }[] = [{ value: "none", text: "None" }];
    if (media)
      options.push({ value: "beats", text: "Of this sound" }, { value: "onsets", text: "Onsets of this sound" });
    if (beats?.path != null) options.push({ value: "file", text: fileName(beats.path) });
    options.push({ value: "other", text: "From a file…" });
    source.show(options, beats === null ? "none" : beats.path === null ? beats.on : "file");
    const count = beside.beats?.times.length ?? 0;
    found.hidden = !beside.listening && beside.beats === null;
    setText(found, beside.listening ? "Listening…" : `${count} ${count === 1 ? "beat" : "beats"} found`);
    say(refused, beside.beatsTrouble);
    snap.row.hidden = beats === null;
    snap.show(view.snapBeats);
  };
  return { root, update };
}

function say(element: HTMLElement, words: string | null): void {
  setText(element, words ?? "");
  element.hidden = words === null;
}
