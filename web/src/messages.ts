// The messages between the page and its server. Made by tools/make_messages.py from src/retime/server/messages.py,
// which tells what each of them means; a test compares. Times are seconds.

export const VERSION = 12;

/** The bits of Why.binding, the lowest first. */
export const BINDINGS = ["key", "tangent", "hold", "lock", "flight", "even", "fastest", "slowest"] as const;

/** A clip of the document. */
export interface ClipFile {
  readonly path: string;
  readonly role: "search" | "follow";
  readonly first_frame: number | null;
  readonly last_frame: number | null;
  readonly fps: string | null;
  readonly skeleton: string | null;
  readonly up: "y" | "z" | null;
  readonly channels: string | null;
  readonly gaps: string | null;
  readonly root: string | null;
  readonly offset: string | null;
}

/** A joint (or channel) of the clip, and which of the reference's stands for it. */
export interface JointPair {
  readonly input: string;
  readonly reference: string;
}

/** What another searched clip is to move like, while the first one moves like the reference's own file. */
export interface CounterpartFile {
  readonly clip: number;
  readonly path: string;
  readonly fps: string | null;
  readonly skeleton: string | null;
  readonly up: "y" | "z" | null;
  readonly channels: string | null;
  readonly gaps: string | null;
  readonly root: string | null;
}

/** What the input is to move like. */
export interface ReferenceFile {
  readonly path: string | null;
  readonly first_frame: number | null;
  readonly last_frame: number | null;
  readonly weight: number;
  readonly mirror: boolean;
  readonly fps: string | null;
  readonly skeleton: string | null;
  readonly up: "y" | "z" | null;
  readonly channels: string | null;
  readonly gaps: string | null;
  readonly root: string | null;
  readonly joint_map: string | null;
  readonly joints: readonly JointPair[];
  readonly counterparts: readonly CounterpartFile[];
}

/** A keytime. The clip's own ends need none. */
export interface Key {
  readonly id: string;
  readonly input_time: number;
  readonly output_time: number;
  readonly speed: number | null;
}

/** A span of the input that plays at given speeds; from 0 to 1 it may be slowed down, but is not cut. */
export interface LockedTime {
  readonly id: string;
  readonly start: number;
  readonly end: number;
  readonly slowest: number;
  readonly fastest: number;
}

/** What a person says of a stretch of the input: it is a flight, or none. */
export interface FlightMark {
  readonly id: string;
  readonly start: number;
  readonly end: number;
  readonly flies: boolean;
}

/** A stretch that was retimed by hand, whose timing is carried over to the rest of the clip. */
export interface Example {
  readonly start: number;
  readonly end: number;
}

/** The options of the search that were given. */
export interface Options {
  /** 65%, 9.3 (seconds), 280f, 0:09.3 or free: the search finds it. */
  readonly length?: string;
  /** A free length is no shorter than this: 65%, 9.3 (seconds), 280f. */
  readonly min_length?: string;
  /** A free length is no longer than this: 65%, 9.3 (seconds), 280f. */
  readonly max_length?: string;
  /** What makes one free length better than another. */
  readonly free_weight?: "neutral" | "sum";
  /** 1 follows the search; 0 is the spline through the keytimes, as drawn by hand. */
  readonly influence?: number;
  /** How evenly moving parts share the hurry; pauses give way first. */
  readonly evenness?: number;
  /** Play jumps at their own speed. */
  readonly keep_flights?: number;
  /** How dear it is to leap over what happens. */
  readonly content?: number;
  /** How near to its own speed the clip begins and ends. */
  readonly ends?: number;
  /** How near the clip stays to its own timing where the reference says little. */
  readonly own_timing?: number;
  /** How much a change of speed costs: the more, the fewer changes. */
  readonly smoothness?: number;
  /** Slowest and fastest for the whole clip: 1/2..2, 50%..200%, ..2. */
  readonly speed?: string;
  /** The clip is a cycle, and stays one. */
  readonly loop?: boolean;
  /** The paper read literally, with nothing of what was added since. */
  readonly paper?: boolean;
  /** Imitate where the reference hurries and lingers, not how quick it is as a whole. */
  readonly match_tempo?: boolean;
  /** What makes a frame's speed look right. */
  readonly score?: "joint" | "conditional";
  /** The best way there is, or a good one sooner, as the paper finds it. */
  readonly search?: "priced" | "layered" | "heuristic";
  /** In which space poses are compared. */
  readonly features?: "torso" | "heading" | "signal";
  /** How many frames a second the search looks at: 30, 29.97. The output keeps the clip's own rate. */
  readonly rate?: string;
  /** How many frames the search may leap to the next one it shows: the more, the faster it may play. */
  readonly max_skip?: number;
  /** Into how many parts the search may divide a frame: 4 lets it play at a quarter of the speed. */
  readonly upsample?: number;
  /** With how many frames of the reference each frame is compared. */
  readonly n_neighbors?: number;
  /** How much the speed of the body counts beside its pose, in seconds. */
  readonly time_scale?: number;
  /** Shaking that is faster than this, in Hz, is not looked at; 0: all is. */
  readonly low_pass?: number;
  /** Over how many of its frames the search evens out the speed; 0: it does not. */
  readonly smoothing?: number;
}

/** A warp kept for comparison. */
export interface KeptWarp {
  readonly id: string;
  readonly name: string;
}

/** A video or a sound, shown and heard beside the stage; it has no part in the search. */
export interface MediaFile {
  readonly path: string;
  readonly offset: string | null;
  readonly clock: "input" | "output";
}

/** Moments to put keytimes on. */
export interface BeatsFile {
  readonly path: string | null;
  readonly on: "beats" | "onsets";
}

/** A moment that a person has marked. It changes nothing of the warp: hands and keytimes snap to it. */
export interface Marker {
  readonly id: string;
  readonly time: number;
  readonly name: string;
  readonly on: "output" | "input";
}

/** The stretch of the output that is worked on: what is played is this. It changes nothing of the warp. */
export interface WorkArea {
  readonly start: number;
  readonly end: number;
}

/** How much the search has to say at a moment; between two of them it changes evenly. */
export interface InfluencePoint {
  readonly time: number;
  readonly share: number;
}

/** All that undo brings back. */
export interface Document {
  readonly clips: readonly ClipFile[];
  readonly references: readonly ReferenceFile[];
  readonly keys: readonly Key[];
  readonly locks: readonly LockedTime[];
  readonly method: "guided" | "align" | "linear" | "spline";
  readonly repeat: number;
  readonly flights: readonly FlightMark[];
  readonly example: Example | null;
  readonly average: boolean;
  readonly options: Options;
  readonly kept: readonly KeptWarp[];
  readonly media: MediaFile | null;
  readonly beats: BeatsFile | null;
  readonly markers: readonly Marker[];
  readonly work_area: WorkArea | null;
  readonly influence: readonly InfluencePoint[];
}

// From the page to the server.

/** The first message of a page. */
export interface Hello {
  readonly type: "hello";
  readonly version: number;
}

/** A new document value. */
export interface Edit {
  readonly type: "edit";
  readonly revision: number;
  readonly gesture: string;
  readonly done: boolean;
  readonly label: string;
  readonly document: Document;
}

/** Take back the last step. */
export interface Undo {
  readonly type: "undo";
  readonly revision: number;
}

/** Do again what was taken back last. */
export interface Redo {
  readonly type: "redo";
  readonly revision: number;
}

/** Keep the warp of the document as it is, to compare others with; an edit of the document. */
export interface Keep {
  readonly type: "keep";
  readonly revision: number;
  readonly name: string;
}

/** Save the project. */
export interface Save {
  readonly type: "save";
  readonly path: string | null;
  readonly overwrite: boolean;
}

/** Open a project, or a clip as a new document. What was not saved stays in the journal of its project. */
export interface Open {
  readonly type: "open";
  readonly path: string;
}

/** Begin anew with the same clips and references; what was done to them is kept in the project's file, or aside. */
export interface Anew {
  readonly type: "anew";
}

/** Write what the document asks for to files. */
export interface Export {
  readonly type: "export";
  readonly what: "motion" | "warp" | "picture";
  readonly path: string;
  readonly clip: number;
  readonly overwrite: boolean;
}

/** Write the warp as the retime curve of another program. */
export interface ExportCurve {
  readonly type: "export_curve";
  readonly host: string;
  readonly path: string;
  readonly rate: string;
  readonly start: string;
  readonly tolerance: string;
  readonly item: string;
  readonly overwrite: boolean;
}

/** End the search that is at work; the last good curve stays. */
export interface Stop {
  readonly type: "stop";
  readonly revision: number;
}

/** Ask for the files of a folder that the page may open from and write to. */
export interface Browse {
  readonly type: "browse";
  readonly folder: string | null;
  readonly holds: "clip" | "skeleton" | "joint map" | "media" | "beats";
}

/** Ask whether a file may be used, before anything is done with it. */
export interface Find {
  readonly type: "find";
  readonly path: string;
  readonly writing: boolean;
  readonly as_clip: boolean;
}

export type PageMessage =
  | Hello
  | Edit
  | Undo
  | Redo
  | Keep
  | Save
  | Open
  | Anew
  | Export
  | ExportCurve
  | Stop
  | Browse
  | Find;

// From the server to the page.

/** The answer to `Hello`. */
export interface Welcome {
  readonly type: "welcome";
  readonly version: number;
  readonly program: string;
  readonly opens: readonly string[];
  readonly run: string;
  readonly command: string;
  readonly key: string;
}

/** The document as it is now; everything up to its revision is on disk. */
export interface State {
  readonly type: "state";
  readonly revision: number;
  readonly document: Document;
  readonly undo_label: string | null;
  readonly redo_label: string | null;
  readonly saved: boolean;
  readonly recovered: boolean;
  readonly resumed: boolean;
  readonly path: string | null;
  readonly opened: number;
}

/** An edit of an unfinished gesture is on disk, and with it all before it. */
export interface Ack {
  readonly type: "ack";
  readonly revision: number;
}

/** Another page has made a revision: what this page was about to make of the one before is lost. */
export interface Elsewhere {
  readonly type: "elsewhere";
  readonly revision: number;
}

/** A file could not be opened or written; everything is as it was. */
export interface Refused {
  readonly type: "refused";
  readonly what: "open" | "save" | "export";
  readonly path: string;
  readonly reason: string;
}

/** A curve is long in coming; sent some times a second until `Curve` or `Problem` answers. */
export interface Progress {
  readonly type: "progress";
  readonly revision: number;
  readonly doing: "reading" | "searching";
  readonly share: number | null;
}

/** The document asks for what can't be done; the last good curve stays. */
export interface Problem {
  readonly type: "problem";
  readonly revision: number;
  readonly message: string;
  readonly key: string | null;
  readonly lock: string | null;
  readonly clip: number | null;
  readonly reference: number | null;
  readonly field: string | null;
}

/** Words for the person. */
export interface Notice {
  readonly type: "notice";
  readonly kind: "info" | "warning" | "error";
  readonly text: string;
}

/** The project was saved. */
export interface Saved {
  readonly type: "saved";
  readonly path: string;
}

/** An export was written. */
export interface Exported {
  readonly type: "exported";
  readonly what: "motion" | "warp" | "picture" | "curve";
  readonly path: string;
  readonly error: string;
}

/** The files of a folder that retime can open, and the folders in it. */
export interface Listing {
  readonly type: "listing";
  readonly folder: string;
  readonly parent: string | null;
  readonly folders: readonly string[];
  readonly files: readonly string[];
}

/** The answer to `Find`. */
export interface Found {
  readonly type: "found";
  readonly path: string;
  readonly place: string;
  readonly refused: string | null;
  readonly exists: boolean;
}

/** A clip, or a reference, as it is drawn. Sent before the first `State`, and again where files change. */
export interface Clip {
  readonly type: "clip";
  readonly what: "clip" | "reference";
  readonly index: number;
  readonly count: number;
  readonly name: string;
  readonly holds: "motion" | "signal";
  readonly rate: number;
  readonly n_frames: number;
  readonly n_nodes: number;
  readonly first_frame: number;
  readonly start_time: number;
  readonly n_whole: number;
  readonly names: readonly string[];
  readonly parents: readonly number[];
  readonly positions: Float32Array;
  readonly values: Float64Array;
  readonly kinds: readonly string[];
  readonly flights: Float64Array;
  readonly feet: readonly string[];
  readonly contacts: Float64Array;
  readonly counterparts: readonly string[];
  readonly camera: Float32Array;
  readonly skin_points: Float32Array;
  readonly skin_triangles: Int32Array;
  readonly skin_bones: Float32Array;
  readonly skin_joints: Int32Array;
  readonly skin_follows: Int32Array;
  readonly skin_weights: Float32Array;
  readonly turns: Float32Array;
}

/** The warp of a revision, and the ones that an animator has today. */
export interface Curve {
  readonly type: "curve";
  readonly revision: number;
  readonly rate: number;
  readonly n_output: number;
  readonly method: string;
  readonly analysis_rate: number;
  readonly max_skip: number;
  readonly upsample: number;
  readonly evenness: number;
  readonly keep_flights: number;
  readonly total: number | null;
  readonly lower_bound: number | null;
  readonly optimal: boolean;
  readonly solve_ms: number;
  readonly key_output_times: Float64Array;
  readonly key_input_times: Float64Array;
  readonly output_times: Float64Array;
  readonly input_times: Float64Array;
  readonly linear_output_times: Float64Array;
  readonly linear_input_times: Float64Array;
  readonly spline_begins: Float64Array;
  readonly spline_ends: Float64Array;
  readonly given_up: readonly string[];
  readonly spoken_share: number | null;
  readonly unspoken: Float64Array;
  readonly example_warnings: readonly string[];
  readonly hand_output_times: Float64Array;
  readonly hand_input_times: Float64Array;
}

/** Why the curve of a revision is as it is; sent after `Curve` when no newer document waits. */
export interface Why {
  readonly type: "why";
  readonly revision: number;
  readonly n_output: number;
  readonly n_neighbors: number;
  readonly references: readonly string[];
  readonly mirrored: readonly boolean[];
  readonly sources: readonly number[];
  readonly output_times: Float64Array;
  readonly input_times: Float64Array;
  readonly speeds: Float64Array;
  readonly scores: Float64Array;
  readonly matched: Int32Array;
  readonly matched_times: Float64Array;
  readonly binding: Uint8Array;
}

/** A warp that the document keeps for comparison; sent once for each id. */
export interface Kept {
  readonly type: "kept";
  readonly id: string;
  readonly output_times: Float64Array;
  readonly input_times: Float64Array;
}

export type TextMessage =
  | Welcome
  | State
  | Ack
  | Elsewhere
  | Refused
  | Progress
  | Problem
  | Notice
  | Saved
  | Exported
  | Listing
  | Found;

/** Travels as one binary frame. */
export type ArrayMessage =
  | Clip
  | Curve
  | Why
  | Kept;

export type ServerMessage = TextMessage | ArrayMessage;

interface ArrayPlace {
  readonly name: string;
  readonly dtype: keyof typeof ARRAY_TYPES;
  readonly shape: readonly number[];
  readonly offset: number;
}

const ARRAY_TYPES = {
  "<f8": Float64Array,
  "<f4": Float32Array,
  "<i4": Int32Array,
  "|u1": Uint8Array,
} as const;

/** Read a binary frame: its arrays are views of the frame's own bytes. */
export function readArrays(frame: ArrayBuffer): ArrayMessage {
  const headerBytes = new DataView(frame).getUint32(0, true);
  const text = new TextDecoder().decode(new Uint8Array(frame, 4, headerBytes));
  const { arrays, ...message } = JSON.parse(text) as { arrays: ArrayPlace[] } & Record<string, unknown>;
  for (const { name, dtype, shape, offset } of arrays) {
    const length = shape.reduce((product, size) => product * size, 1);
    message[name] = new ARRAY_TYPES[dtype](frame, 4 + headerBytes + offset, length);
  }
  return message as unknown as ArrayMessage;
}
