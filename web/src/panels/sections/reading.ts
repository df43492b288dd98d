/** How a file is read: its axis that is up, its root, its rate, the skeleton of an AMC, a table's channels and gaps. */

import { make, setText } from "../../dom";
import { parseRate, parseTime } from "../../grammar";
import type { Dialogs } from "../dialogs/dialogs";
import { choice, textField } from "../fields";
import { fileName } from "../top";

interface Reading {
  readonly path: string | null;
  readonly fps: string | null;
  readonly up: "y" | "z" | null;
  readonly skeleton: string | null;
  readonly channels: string | null;
  readonly gaps: string | null;
  readonly root: string | null;
  /** Of clips alone. */
  readonly offset?: string | null;
}

export interface ReadingFields {
  readonly root: HTMLDetailsElement;
  update(): void;
}

/** Fields for one file; `whose` goes before their names for those who can't see where they are. */
export function readingFields(
  dialogs: Dialogs,
  whose: string,
  file: () => Reading,
  change: (change: Partial<Pick<Reading, "fps" | "up" | "root" | "skeleton" | "channels" | "gaps" | "offset">>) => void,
  faulty: () => boolean,
  replace?: (path: string) => void,
  /** The rate of the first clip, of which another one may begin some time after. */
  rateOfFirst?: () => number,
): ReadingFields {
  const place = make("button", { type: "button", class: "button framed wide" });
  place.addEventListener("click", () =>
    dialogs.showOpen({ title: "Where the clip is now", holds: "clip", take: (path) => replace?.(path) }),
  );
  const placeRow = make("div", { class: "row", hidden: !replace }, make("span", { class: "label" }, "File"), place);
  const up = choice<"" | "y" | "z">("Up", "The vertical axis of the file", (value) =>
    change({ up: value === "" ? null : value }),
  );
  up.select.setAttribute("aria-label", `${whose}: axis that is up`);
  const fps = textField("Rate, Hz", "Frames a second: 30, 29.97 or 30000/1001. Empty: as the file says", (text) => {
    change({ fps: text === "" ? null : parseRate(text) });
    return true;
  });
  fps.input.placeholder = "as the file says";
  fps.input.setAttribute("aria-label", `${whose}: frames a second`);
  const body = textField("Root", "The joint that carries the body. Empty: it is found", (text) => {
    change({ root: text === "" ? null : text });
    return true;
  });
  body.input.placeholder = "found";
  body.input.setAttribute("aria-label", `${whose}: joint that carries the body`);
  const skeleton = make("button", {
    type: "button",
    class: "button framed wide",
    title: "The ASF that says how its joints are joined",
  });
  skeleton.addEventListener("click", () =>
    dialogs.showOpen({
      title: "Choose the skeleton (ASF)",
      holds: "skeleton",
      take: (path) => change({ skeleton: path }),
    }),
  );
  const skeletonRow = make("div", { class: "row" }, make("span", { class: "label" }, "Skeleton"), skeleton);
  const channels = textField(
    "Channels",
    "What channels of a table hold: pan=angle:deg, *_id=label. Empty: what names and values say",
    (text) => {
      change({ channels: text === "" ? null : text });
      return true;
    },
  );
  channels.input.placeholder = "as names and values say";
  channels.input.setAttribute("aria-label", `${whose}: what channels hold`);
  const gaps = choice("Gaps", "Values that a table lacks", (value) => change({ gaps: value === "" ? null : value }));
  gaps.select.setAttribute("aria-label", `${whose}: gaps`);
  const begins = textField(
    "Begins",
    "How long after the first clip: 0.5s, -12f. Empty: as times in both files say, or together",
    (text) => {
      if (text !== "") parseTime(text.replace(/^[+-]/u, ""), rateOfFirst?.() ?? 30);
      change({ offset: text === "" ? null : text });
      return true;
    },
  );
  begins.input.placeholder = "by the files' times";
  begins.input.setAttribute("aria-label", `${whose}: how long after the first clip it begins`);
  begins.row.hidden = !rateOfFirst;
  const said = make("span", { class: "note" });
  const root = make(
    "details",
    { class: "reading" },
    make("summary", {}, "How it is read", said),
    placeRow,
    begins.row,
    up.row,
    fps.row,
    body.row,
    skeletonRow,
    channels.row,
    gaps.row,
  );
  return {
    root,
    update() {
      const { path, fps: rate, up: axis, skeleton: asf, root: joint, channels: kinds, gaps: holes, offset } = file();
      setText(place, fileName(path ?? ""));
      place.title = `${path ?? ""}: choose another place, where the file was moved`;
      up.show(
        [
          { value: "", text: "As the file says" },
          { value: "y", text: "Y" },
          { value: "z", text: "Z" },
        ],
        axis ?? "",
      );
      fps.show(rate ?? "");
      begins.show(offset ?? "");
      body.show(joint ?? "");
      const isAmc = /\.amc(\.gz|\.bz2)?$/iu.test(path ?? "");
      skeletonRow.hidden = !isAmc && asf === null;
      setText(skeleton, asf === null ? "Found beside it" : fileName(asf));
      const isTable = /\.(csv|tsv|npy|npz|parquet|mot|sto|trc|c3d)(\.gz|\.bz2)?$/iu.test(path ?? "");
      channels.row.hidden = !isTable && kinds === null;
      channels.show(kinds ?? "");
      gaps.row.hidden = !isTable && holes === null;
      gaps.show(
        [
          { value: "", text: "None: refuse the file" },
          { value: "bridge", text: "Bridge up to 1 s" },
          ...(holes?.startsWith("bridge:") ? [{ value: holes, text: `Bridge up to ${holes.slice(7)} s` }] : []),
          { value: "keep", text: "Keep as gaps" },
        ],
        holes ?? "",
      );
      up.row.hidden = isTable && axis === null;
      body.row.hidden = isTable && joint === null;
      setText(
        said,
        [
          axis ? `${axis.toUpperCase()} up` : "",
          joint ? `root ${joint}` : "",
          rate ? `${rate} Hz` : "",
          offset ? `begins at ${offset}` : "",
          asf ? fileName(asf) : "",
          kinds ?? "",
          holes ?? "",
        ]
          .filter(Boolean)
          .join(", "),
      );
      // What is wrong with a file may be mended here.
      if (faulty()) root.open = true;
    },
  };
}
