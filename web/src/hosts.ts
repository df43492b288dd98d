// The programs that a warp can be written for, as the page shows them. Made by tools/make_hosts.py from
// src/retime/hosts/registry.py; a test compares.

export interface Host {
  readonly name: string;
  readonly title: string;
  /** Endings of its files, the usual one first. */
  readonly suffixes: readonly string[];
  /** The number that it gives a shot's first frame; null: it counts from the beginning of its clip. */
  readonly firstFrame: number | null;
  /** Whether it does with fewer keys where an error is allowed. */
  readonly thins: boolean;
  /** What can be named in it; empty: nothing. */
  readonly item: string;
}

export const HOSTS: readonly Host[] = [
  {
    name: "nuke",
    title: "Nuke, a TimeWarp node",
    suffixes: [".nk"],
    firstFrame: 1,
    thins: false,
    item: "the node",
  },
  {
    name: "maya",
    title: "Maya, the scene's time warp, or that of named curves",
    suffixes: [".ma", ".py"],
    firstFrame: 1,
    thins: true,
    item: "animation curves, with commas between",
  },
  {
    name: "after-effects",
    title: "After Effects, Time Remap of a layer",
    suffixes: [".jsx"],
    firstFrame: null,
    thins: true,
    item: "the layer",
  },
  {
    name: "fcpxml",
    title: "Final Cut Pro and Resolve, a clip with a time map",
    suffixes: [".fcpxml"],
    firstFrame: null,
    thins: true,
    item: "the clip's file",
  },
  {
    name: "otio",
    title: "OpenTimelineIO, a clip cut in pieces of one speed each",
    suffixes: [".otio"],
    firstFrame: 0,
    thins: true,
    item: "the clip's file",
  },
  {
    name: "premiere",
    title: "Premiere Pro, a clip with Time Remapping (Final Cut Pro 7 XML)",
    suffixes: [".xml"],
    firstFrame: null,
    thins: true,
    item: "the clip's file",
  },
  {
    name: "lottie",
    title: "Lottie, a precomposition with a time remap",
    suffixes: [".json"],
    firstFrame: null,
    thins: true,
    item: "the precomposition",
  },
  {
    name: "houdini",
    title: "Houdini, a channel for the Warp CHOP",
    suffixes: [".chan"],
    firstFrame: null,
    thins: false,
    item: "",
  },
  {
    name: "unreal",
    title: "Unreal Engine, the keys of a Time Warp track",
    suffixes: [".py"],
    firstFrame: 0,
    thins: true,
    item: "",
  },
  {
    name: "framecurve",
    title: "framecurve, a table of frames that many programs read",
    suffixes: [".txt", ".framecurve"],
    firstFrame: 1,
    thins: true,
    item: "",
  },
  {
    name: "usd-clips",
    title: "OpenUSD, a layer with value clips",
    suffixes: [".usda"],
    firstFrame: 0,
    thins: true,
    item: "the layer and the prim, as walk.usd</Char>",
  },
  {
    name: "ffmpeg",
    title: "ffmpeg, a filter with setpts",
    suffixes: [".txt"],
    firstFrame: null,
    thins: true,
    item: "",
  },
  {
    name: "mlt",
    title: "MLT (Shotcut, Kdenlive), a clip with the link timeremap",
    suffixes: [".mlt"],
    firstFrame: null,
    thins: true,
    item: "the clip's file",
  },
  {
    name: "csv",
    title: "A table: output time, input time, in seconds",
    suffixes: [".csv"],
    firstFrame: null,
    thins: true,
    item: "",
  },
  {
    name: "frames",
    title: "A list: the input frame of each output frame",
    suffixes: [".txt"],
    firstFrame: 0,
    thins: false,
    item: "",
  },
];
