"""Every message between the editor's page and its server, declared once.

`tools/make_messages.py` makes the page's types from this file; `retime.server.message_coding` says how they travel.
Times are seconds from the first frame used of a clip or of the output.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray

from retime.brief import brief_repr
from retime.project.document import Document

VERSION = 12
"""Of the messages. A page of another version is told so, and does nothing."""

Float64s = Annotated[NDArray[np.float64], "<f8"]
Float32s = Annotated[NDArray[np.float32], "<f4"]
Int32s = Annotated[NDArray[np.int32], "<i4"]
Bytes = Annotated[NDArray[np.uint8], "|u1"]


# From the page to the server.


@dataclass(frozen=True)
class Hello:
    """The first message of a page.

    Attributes
    ----------
    version : int
        Of the messages that it speaks.
    """

    version: int


@dataclass(frozen=True)
class Edit:
    """A new document value.

    Every message that changes the document names the revision that it makes: one more than the last that the page
    made or was told of. Where that is not the next one (another window was faster), the change is refused: `Elsewhere`
    says so, and `State` what holds.

    Attributes
    ----------
    revision : int
        The revision that this makes.
    gesture : str
        Edits of one gesture (a drag) are one undo step.
    done : bool
        The gesture's last edit. Others are answered by `Ack` and `Curve` alone.
    label : str
        What was done, for the undo menu: "move key".
    document : Document
        The whole of it.
    """

    revision: int
    gesture: str
    done: bool
    label: str
    document: Document


@dataclass(frozen=True)
class Undo:
    """Take back the last step.

    Attributes
    ----------
    revision : int
        The revision that this makes.
    """

    revision: int


@dataclass(frozen=True)
class Redo:
    """Do again what was taken back last.

    Attributes
    ----------
    revision : int
        The revision that this makes.
    """

    revision: int


@dataclass(frozen=True)
class Keep:
    """Keep the warp of the document as it is, to compare others with; an edit of the document.

    Attributes
    ----------
    revision : int
        The revision that this makes.
    name : str
        What to call it.
    """

    revision: int
    name: str


@dataclass(frozen=True)
class Save:
    """Save the project.

    Attributes
    ----------
    path : str, optional
        Where; left out, where it was opened from or saved last.
    overwrite : bool
        Replace another file that is there.
    """

    path: str | None
    overwrite: bool


@dataclass(frozen=True)
class Open:
    """Open a project, or a clip as a new document. What was not saved stays in the journal of its project.

    Attributes
    ----------
    path : str
        The file.
    """

    path: str


@dataclass(frozen=True)
class Anew:
    """Begin anew with the same clips and references; what was done to them is kept in the project's file, or aside."""


@dataclass(frozen=True)
class Export:
    """Write what the document asks for to files.

    Attributes
    ----------
    what : {"motion", "warp", "picture"}
        The retimed clip, its warp as JSON, or a plot.
    path : str
        Where; the name's ending says in which format.
    clip : int
        Which clip of the document, for a motion.
    overwrite : bool
        Replace a file that is there; an input is never replaced.
    """

    what: Literal["motion", "warp", "picture"]
    path: str
    clip: int
    overwrite: bool


@dataclass(frozen=True)
class ExportCurve:
    """Write the warp as the retime curve of another program.

    Attributes
    ----------
    host : str
        Which, as `retime.hosts.registry.HOSTS` names it.
    path : str
        Where.
    rate : str
        Frames a second of the shot, as a person wrote it; empty: that of the first clip.
    start : str
        The number of the shot's first frame, as a person wrote it; empty: the program's custom.
    tolerance : str
        Seconds that it may be off to do with fewer keys, as a person wrote them; empty: 0.001.
    item : str
        What it is for; empty where nobody said.
    overwrite : bool
        Replace a file that is there; an input is never replaced.
    """

    host: str
    path: str
    rate: str
    start: str
    tolerance: str
    item: str
    overwrite: bool


@dataclass(frozen=True)
class Stop:
    """End the search that is at work; the last good curve stays.

    Attributes
    ----------
    revision : int
        Of the newest document that nobody waits for any more.
    """

    revision: int


@dataclass(frozen=True)
class Browse:
    """Ask for the files of a folder that the page may open from and write to.

    Attributes
    ----------
    folder : str, optional
        Left out, the folder that the server was started in.
    holds : {"clip", "skeleton", "joint map", "media", "beats"}
        What is looked for: a clip or a project, an ASF, a joint map, a video or a sound, a table of beats or a sound.
    """

    folder: str | None
    holds: Literal["clip", "skeleton", "joint map", "media", "beats"]


@dataclass(frozen=True)
class Find:
    """Ask whether a file may be used, before anything is done with it.

    Attributes
    ----------
    path : str
        As a person wrote it.
    writing : bool
        Whether it is to be written.
    as_clip : bool
        Whether it is to be one more clip or reference: then it is read, and refused where it can't be.
    """

    path: str
    writing: bool
    as_clip: bool = False


# From the server to the page.


@dataclass(frozen=True)
class Welcome:
    """The answer to `Hello`.

    Attributes
    ----------
    version : int
        Of the messages. Where it is not the page's, nothing follows: the page is to be loaded again.
    program : str
        The version of retime.
    opens : list of str
        File name endings of clips, lower case, with the dot.
    run : str
        Which run of the server this is: another one has another.
    command : str
        What starts this editor again; empty where no command did.
    key : str
        With which the page can prove to a later run that it belongs to it (`retime.server.returning`); empty where it
        can't come back.
    """

    version: int
    program: str
    opens: tuple[str, ...]
    run: str
    command: str
    key: str


@dataclass(frozen=True)
class State:
    """The document as it is now; everything up to its revision is on disk.

    Attributes
    ----------
    revision : int
        Of the document.
    document : Document
        The whole of it.
    undo_label, redo_label : str, optional
        What undo and redo would do; none where there is nothing.
    saved : bool
        Whether the project file holds this.
    recovered : bool
        Whether it was recovered from the journal of a session that ended before it was saved.
    resumed : bool
        Whether it is the project that the clips were saved in, opened in their place.
    path : str, optional
        The project file, if there is one.
    opened : int
        How many documents were opened before this one: where it changes, this is another document.
    """

    revision: int
    document: Document
    undo_label: str | None
    redo_label: str | None
    saved: bool
    recovered: bool
    resumed: bool
    path: str | None
    opened: int


@dataclass(frozen=True)
class Ack:
    """An edit of an unfinished gesture is on disk, and with it all before it.

    Attributes
    ----------
    revision : int
        Of the document.
    """

    revision: int


@dataclass(frozen=True)
class Elsewhere:
    """Another page has made a revision: what this page was about to make of the one before is lost.

    Attributes
    ----------
    revision : int
        Which.
    """

    revision: int


@dataclass(frozen=True)
class Refused:
    """A file could not be opened or written; everything is as it was.

    Attributes
    ----------
    what : {"open", "save", "export"}
        What was asked for.
    path : str
        The file, as it was asked for.
    reason : str
        Why not.
    """

    what: Literal["open", "save", "export"]
    path: str
    reason: str


@dataclass(frozen=True)
class Progress:
    """A curve is long in coming; sent some times a second until `Curve` or `Problem` answers.

    Attributes
    ----------
    revision : int
        Of the document that is at work.
    doing : {"reading", "searching"}
        What is done.
    share : float, optional
        How much of it is done, from 0 to 1; none where nobody knows.
    """

    revision: int
    doing: Literal["reading", "searching"]
    share: float | None


@dataclass(frozen=True)
class Problem:
    """The document asks for what can't be done; the last good curve stays.

    Attributes
    ----------
    revision : int
        Of the document.
    message : str
        What is wrong, and what would help.
    key, lock : str, optional
        The id of the key or lock at fault, where it is one.
    clip, reference : int, optional
        The place in the document of the clip or reference at fault, where it is one.
    field : str, optional
        The name in the document of the value at fault, where it is one: ``options.rate``.
    """

    revision: int
    message: str
    key: str | None
    lock: str | None
    clip: int | None
    reference: int | None
    field: str | None


@dataclass(frozen=True)
class Notice:
    """Words for the person.

    Attributes
    ----------
    kind : {"info", "warning", "error"}
        How they sound.
    text : str
        The words.
    """

    kind: Literal["info", "warning", "error"]
    text: str


@dataclass(frozen=True)
class Saved:
    """The project was saved.

    Attributes
    ----------
    path : str
        Where.
    """

    path: str


@dataclass(frozen=True)
class Exported:
    """An export was written.

    Attributes
    ----------
    what : {"motion", "warp", "picture", "curve"}
        What was.
    path : str
        Where.
    error : str
        Of a curve, how far it is from the warp, in words; else empty.
    """

    what: Literal["motion", "warp", "picture", "curve"]
    path: str
    error: str


@dataclass(frozen=True)
class Listing:
    """The files of a folder that retime can open, and the folders in it.

    Attributes
    ----------
    folder : str
        The folder.
    parent : str, optional
        The folder that it is in, where the page may go there.
    folders, files : list of str
        Names.
    """

    folder: str
    parent: str | None
    folders: tuple[str, ...]
    files: tuple[str, ...]


@dataclass(frozen=True)
class Found:
    """The answer to `Find`.

    Attributes
    ----------
    path : str
        As it was asked for.
    place : str
        The file that it means, links followed; empty where it is refused.
    refused : str, optional
        Why it can't be used, and what would help.
    exists : bool
        Whether it is there already.
    """

    path: str
    place: str
    refused: str | None
    exists: bool


@dataclass(frozen=True, eq=False)
class Clip:
    """A clip, or a reference, as it is drawn. Sent before the first `State`, and again where files change.

    Attributes
    ----------
    what : {"clip", "reference"}
        Which list of the document it is in.
    index : int
        Its place there.
    count : int
        How many there are: what lies beyond is gone.
    name : str
        What to call it.
    holds : {"motion", "signal"}
        What it is.
    rate : float
        Frames a second.
    n_frames, n_nodes : int
        Shape of `positions`; `n_nodes` is 0 for a signal.
    first_frame : int
        The number that the file gives its first frame used.
    start_time : float
        When its frames begin in the whole that they are cut out of, seconds: in its file; of a reference that is the
        first clip itself, in what is used of that.
    n_whole : int
        Frames of that whole.
    names : list of str
        Of the nodes (joints, then end sites), or of the channels.
    parents : list of int
        Of the nodes; -1 for the root.
    positions : float32 array, shape (n_frames, n_nodes, 3)
        Metres (where the file says no unit, as for a person of 1.7 m), Y up; empty for a signal.
    values : float64 array, shape (n_frames, number of channels)
        The channels of a signal; empty for a motion.
    kinds : list of str
        What each channel of a signal holds, as `retime.motion.channels.ChannelKind` writes it.
    flights : float64 array, shape (n, 2)
        Beginning and end of each flight that was found, seconds.
    feet : list of str
        Names of the feet.
    contacts : float64 array, shape (n, 3)
        When they stand: which foot, from when to when, seconds.
    counterparts : list of str
        Of a reference: for each joint (or channel) of the first clip the reference's that stands for it, empty where
        none does. Of a clip empty.
    camera : float32 array, shape (n_frames, 8)
        Of a clip that is a camera: where it is (metres), how it is turned (wxyz; it looks along its own -Z), and what
        it sees from the lower edge to the upper (degrees). Of others empty.
    skin_points : float32 array, shape (n_points, 3)
        The corners of the character's own mesh, in its own space; empty where the file has none.
    skin_triangles : int32 array, shape (n_triangles, 3)
        Three corners each.
    skin_bones : float32 array, shape (n_bones, 3, 4)
        From the mesh's space to that of a joint, metres.
    skin_joints : int32 array, shape (n_bones,)
        The joint of each, among the nodes.
    skin_follows : int32 array, shape (n_points, 4)
        Which bones a corner follows.
    skin_weights : float32 array, shape (n_points, 4)
        How much.
    turns : float32 array, shape (n_frames, n_joints, 4)
        Global turns of the joints, quaternions w, x, y, z; empty where there is no mesh.
    """

    what: Literal["clip", "reference"]
    index: int
    count: int
    name: str
    holds: Literal["motion", "signal"]
    rate: float
    n_frames: int
    n_nodes: int
    first_frame: int
    start_time: float
    n_whole: int
    names: tuple[str, ...]
    parents: tuple[int, ...]
    positions: Float32s
    values: Float64s
    kinds: tuple[str, ...]
    flights: Float64s
    feet: tuple[str, ...]
    contacts: Float64s
    counterparts: tuple[str, ...]
    camera: Float32s
    skin_points: Float32s
    skin_triangles: Int32s
    skin_bones: Float32s
    skin_joints: Int32s
    skin_follows: Int32s
    skin_weights: Float32s
    turns: Float32s

    __repr__ = brief_repr


@dataclass(frozen=True, eq=False)
class Curve:
    """The warp of a revision, and the ones that an animator has today.

    A warp is linear between its knots: at output time t the output shows the input as it is at the interpolated input
    time.

    Attributes
    ----------
    revision : int
        The document that it answers.
    rate : float
        Frames a second of the output.
    n_output : int
        Its frames.
    method : str
        How it was found.
    analysis_rate : float
        Frames a second that the search looks at.
    max_skip, upsample : int
        As the search used them; 0 where there was none.
    evenness, keep_flights : float
        The same: what holds where nobody says it depends on the clip.
    total, lower_bound : float, optional
        What the search paid, and what no path undercuts.
    optimal : bool
        Whether the path is proved to be the best.
    solve_ms : float
        Time that the solver took.
    key_output_times, key_input_times : float64 arrays, shape (n_keys,)
        The keytimes that it meets, ends included.
    output_times, input_times : float64 arrays, shape (n_knots,)
        The warp's knots.
    linear_output_times, linear_input_times : float64 arrays
        Knots of the straight lines through the keytimes.
    spline_begins, spline_ends : float64 arrays, shape (n_keys - 1,)
        The slopes with which the spline through the keytimes begins and ends each span. Its knots, as many as those of
        the warp, the page works out: while a keytime is dragged half of what is sent would be them.
    given_up : list of str
        What of locks, tangents and limits could be kept only to within a rounding, in sentences.
    spoken_share : float, optional
        Where an example is carried over: how much of the clip it speaks for, from 0 to 1.
    unspoken : float64 array, shape (n, 2)
        Stretches of the input for which it does not, seconds.
    example_warnings : list of str
        What a person should know before trusting it, in sentences.
    hand_output_times, hand_input_times : float64 arrays
        Knots of the example as the method plays it; empty where none is carried over.
    """

    revision: int
    rate: float
    n_output: int
    method: str
    analysis_rate: float
    max_skip: int
    upsample: int
    evenness: float
    keep_flights: float
    total: float | None
    lower_bound: float | None
    optimal: bool
    solve_ms: float
    key_output_times: Float64s
    key_input_times: Float64s
    output_times: Float64s
    input_times: Float64s
    linear_output_times: Float64s
    linear_input_times: Float64s
    spline_begins: Float64s
    spline_ends: Float64s
    given_up: tuple[str, ...]
    spoken_share: float | None
    unspoken: Float64s
    example_warnings: tuple[str, ...]
    hand_output_times: Float64s
    hand_input_times: Float64s

    __repr__ = brief_repr


BINDINGS = ("key", "tangent", "hold", "lock", "flight", "even", "fastest", "slowest")
"""The bits of `Why.binding`, the lowest first."""


@dataclass(frozen=True, eq=False)
class Why:
    """Why the curve of a revision is as it is; sent after `Curve` when no newer document waits.

    One row for each output frame at the analysis rate.

    Attributes
    ----------
    revision : int
        The document that it answers.
    n_output, n_neighbors : int
        Rows, and matched reference frames in each.
    references : list of str
        Names of the references; `matched` counts in them.
    mirrored : list of bool
        Whether each is a mirror image.
    sources : list of int
        For each the place in the document's references; -1 for the input itself.
    output_times, input_times, speeds : float64 arrays, shape (n_output,)
        Of the frame before smoothing.
    scores : float64 array, shape (n_output,)
        Mean distance to the matched reference frames; nan at the ends.
    matched : int32 array, shape (n_output, n_neighbors)
        Which reference each match is from, the nearest first; -1 at the ends.
    matched_times : float64 array, shape (n_output, n_neighbors)
        Its time there, seconds; nan at the ends.
    binding : uint8 array, shape (n_output,)
        What bound the frame, a bit for each word of `BINDINGS`.
    """

    revision: int
    n_output: int
    n_neighbors: int
    references: tuple[str, ...]
    mirrored: tuple[bool, ...]
    sources: tuple[int, ...]
    output_times: Float64s
    input_times: Float64s
    speeds: Float64s
    scores: Float64s
    matched: Int32s
    matched_times: Float64s
    binding: Bytes

    __repr__ = brief_repr


@dataclass(frozen=True, eq=False)
class Kept:
    """A warp that the document keeps for comparison; sent once for each id.

    Attributes
    ----------
    id : str
        As in the document.
    output_times, input_times : float64 arrays, shape (n_knots,)
        Its knots.
    """

    id: str
    output_times: Float64s
    input_times: Float64s

    __repr__ = brief_repr


FROM_PAGE = (Hello, Edit, Undo, Redo, Keep, Save, Open, Anew, Export, ExportCurve, Stop, Browse, Find)
FROM_SERVER = (Welcome, State, Ack, Elsewhere, Refused, Progress, Problem, Notice, Saved, Exported, Listing, Found)
FROM_SERVER_WITH_ARRAYS = (Clip, Curve, Why, Kept)

PageMessage = Hello | Edit | Undo | Redo | Keep | Save | Open | Anew | Export | ExportCurve | Stop | Browse | Find
TextMessage = (
    Welcome | State | Ack | Elsewhere | Refused | Progress | Problem | Notice | Saved | Exported | Listing | Found
)
ServerMessage = TextMessage | Clip | Curve | Why | Kept
