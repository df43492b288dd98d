"""Scoring, path search and numbers in text: the compiled kernels, and NumPy's where none could be built.

Both give the same bits.
"""

from __future__ import annotations

import hashlib
import importlib
import os
import warnings
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Protocol, cast

from retime.arrays import FloatArray, IntArray
from retime.brief import brief_repr
from retime.errors import OptionError, RetimeWarning
from retime.kernels.steps import StepPairs as StepPairs

BACKENDS = ("compiled", "numpy")
_MOST_THREADS = 256


class Backend(Protocol):
    """What a backend computes; arrays are contiguous, checked by the caller."""

    def joint_scores(
        self,
        inputs: FloatArray,
        reference: FloatArray,
        steps: StepPairs,
        velocity: float,
        acceleration: float,
        n_neighbors: int,
        *,
        each: bool = False,
    ) -> FloatArray:
        """Score triples of poses (n_input, d) against features (n_reference, 3 d): (n_input, n_pairs).

        With `each`, the distances to the nearest features instead of their mean: one more axis, the smallest first.
        """

    def nearest_poses(self, inputs: FloatArray, poses: FloatArray, n_neighbors: int) -> IntArray:
        """Find the poses (n_reference, d) nearest to each input frame (n_input, d): rows, ties to the earlier one."""

    def conditional_scores(
        self,
        inputs: FloatArray,
        reference: FloatArray,
        nearest: IntArray,
        steps: StepPairs,
        velocity: float,
        acceleration: float,
    ) -> FloatArray:
        """Score triples by the motion of given reference frames (n_input, n_neighbors); shape as above."""

    def layered_path(self, problem: PathProblem, memory_limit: int) -> tuple[IntArray, float] | None:
        """Find the best path by the layered recurrence: frames and total, or None where there is none."""

    def aligned_path(
        self,
        problem: PathProblem,
        inputs: FloatArray,
        reference: FloatArray,
        velocity: float,
        acceleration: float,
        memory_limit: int,
    ) -> tuple[IntArray, float] | None:
        """Find the best path in step with a reference: frames and total, or None where there is none.

        A triple of poses (n_input, d) whose middle is shown in position p costs its distance to row p - 1 of the
        features (n_output - 2, 3 d), and its price: the problem's scores. The last anchor's position is fixed.
        """

    def free_path(self, problem: PathProblem) -> tuple[IntArray, float] | None:
        """Find the best path of any length through the anchors' frames; of equal ones the shortest."""

    def priced_path(self, problem: PathProblem, max_bytes: int) -> PricedPath | None:
        """Find the best path by a price on the count; None where this backend has no such kernel."""

    def read_rows(self, text: bytes, rows: RowFormat) -> FloatArray | None:
        """Read lines of as many numbers each; None where there is none, or where only the careful way can read one.

        Blank lines don't count; lines end in LF, CR or CRLF. A number is ``[+-]digits[.digits][e[+-]digits]``, in
        ASCII; ``.5`` and ``5.`` count too. Each comes as the nearest double.
        """

    def write_rows(self, rows: FloatArray) -> bytes:
        """Write rows (n_rows, n_columns >= 1) of numbers below 1e9, with six decimals.

        A space stands between two numbers, a line feed after each row; a zero has no sign.
        """

    def three_turns(self, order: str, angles: FloatArray) -> FloatArray:
        """Multiply turns about three different axes, radians (n, 3) up to `LARGEST_TURN`: quaternions (n, 4), wxyz."""

    def turn_joints(self, rows: FloatArray, turned: TurnedJoints, angles: FloatArray, rotations: FloatArray) -> None:
        """Fill the angles (n_rows, n_joints, 3), radians, and the rotations (n_rows, n_joints, 4) of some joints."""

    def read_joint_rows(
        self, text: bytes, start: int, piece_bytes: int, rows: RowFormat, channels: JointChannels, into: JointArrays
    ) -> tuple[int, int] | None:
        """Read rows of channels, which blanks part, from a place of a text on, and turn and place joints by them.

        Goes on as long as there is one row a line, as `read_rows` takes them, and room for it, in pieces that end
        behind the first line feed after so many bytes. Returns how many rows came, and their bytes, of whole pieces;
        what stands in the arrays behind them is anything. None where this backend has no such kernel.
        """

    def pose_joints(
        self, joints: PosedJoints, rotations: FloatArray, translations: FloatArray, out: tuple[FloatArray, ...]
    ) -> None:
        """Place joints in space, from local rotations (n_frames, n_joints, 4) and translations (n_frames, n_joints, 3).

        Fills positions, rotations (of those shapes) and positions of end sites (n_frames, n_sites, 3).
        """

    def average_turns(self, turns: AveragedTurns, rotations: FloatArray, sampled: FloatArray) -> None:
        """Change what was sampled (n_output, n_joints, 4) by means of rotations (n_frames, n_joints, 4) over windows.

        Where a joint's window is open, it is turned, in space, as the mean pose of its group has it. A mean is that of
        quaternions which lie each on the side of the frame before, of unit length.
        """

    def extent(self, numbers: FloatArray) -> tuple[float, float]:
        """Return the least and the greatest number, of any shape; both are NaN where one is not finite."""

    def squared_lengths(self, quaternions: FloatArray) -> tuple[float, float]:
        """Return the least and the greatest squared length of quaternions (..., 4); NaN as above."""


LARGEST_TURN = 2e6
"""Radians. Larger angles are turned by NumPy (kLargestTurn in turns.hpp)."""


@dataclass(frozen=True, eq=False)
class TurnedJoints:
    """Joints whose channels are turns about three different axes, in one order.

    Attributes
    ----------
    order : str
        The letters X, Y and Z, in the order of multiplication.
    joints : int array, shape (n,)
        Which joints.
    columns : int array, shape (n, 3)
        Where their channels stand in a row: degrees.
    many : float
        Of angles beyond so many degrees whole turns are left out.
    """

    order: str
    joints: IntArray
    columns: IntArray
    many: float

    __repr__ = brief_repr


@dataclass(frozen=True, eq=False)
class JointChannels:
    """What a row of channels means for joints.

    Attributes
    ----------
    turned : tuple of TurnedJoints
        All joints, each in one of them; ``many`` is the same in all.
    columns, places : int arrays, shape (n,)
        Columns that are coordinates, and where each belongs among the (n_joints * 3) of a frame.
    offsets : float array, shape (n_joints, 3)
        The other coordinates, in every frame.
    """

    turned: tuple[TurnedJoints, ...]
    columns: IntArray
    places: IntArray
    offsets: FloatArray

    __repr__ = brief_repr


@dataclass(frozen=True, eq=False)
class JointArrays:
    """Where joints go that are read: as many frames as there is room for.

    Attributes
    ----------
    rotations : float array, shape (n_frames, n_joints, 4)
        Quaternions.
    translations : float array, shape (n_frames, n_joints, 3)
        Coordinates in the parents' spaces.
    angles : float array, shape (n_frames, n_joints, 3)
        Radians, in the order of multiplication.
    """

    rotations: FloatArray
    translations: FloatArray
    angles: FloatArray

    __repr__ = brief_repr


@dataclass(frozen=True, eq=False)
class PosedJoints:
    """What is placed in space: a skeleton's joints, each behind its parent, and its end sites.

    Attributes
    ----------
    parents : int array, shape (n_joints,)
        That of the first joint is not looked at.
    site_parents : int array, shape (n_sites,)
        Of the end sites.
    site_offsets : float array, shape (n_sites, 3)
        In their parents' spaces.
    turn : float array, shape (4,) or (0,)
        Of the space that the first joint stands in: a quarter turn about X, which brings Z to where Y is, or none.
    """

    parents: IntArray
    site_parents: IntArray
    site_offsets: FloatArray
    turn: FloatArray

    __repr__ = brief_repr


@dataclass(frozen=True, eq=False)
class AveragedTurns:
    """Joints in groups, each with poses of its own, and the windows that these are averaged over.

    Attributes
    ----------
    parents : int array, shape (n_joints,)
        Each joint's, which stands before it; -1 for none.
    groups : int array, shape (n_joints,)
        The group whose poses turn it.
    widths : int array, shape (n_groups, n_joints)
        Which half-widths a joint of a group's poses has; -1 where the group needs it not: neither turns it, nor what is
        below it.
    own : int array, shape (n_groups,)
        The half-widths that tell where a group turns anything.
    halves : float array, shape (n_halves, n_output)
        Half-widths of windows, in frames.
    centres : float array, shape (n_output,)
        Middles of windows, in frames.
    closed : float
        Half-widths up to this are none.
    shortest : float
        Length of a mean below which there is none: what was sampled stays.
    """

    parents: IntArray
    groups: IntArray
    widths: IntArray
    own: IntArray
    halves: FloatArray
    centres: FloatArray
    closed: float
    shortest: float

    __repr__ = brief_repr


def turn_axes(order: str) -> tuple[tuple[int, int, int], float]:
    """Return the axes of three different letters of X, Y, Z, and 1 where they follow each other as those do, else -1.

    Examples
    --------
    >>> turn_axes("ZXY"), turn_axes("ZYX")
    (((2, 0, 1), 1.0), ((2, 1, 0), -1.0))
    """
    i, j, k = ("XYZ".index(letter) for letter in order)
    return (i, j, k), 1.0 if (j - i) % 3 == 1 else -1.0


@dataclass(frozen=True)
class RowFormat:
    """How rows of numbers are written.

    Attributes
    ----------
    n_columns : int
        Numbers in each row; 0: as many as the first one has.
    delimiter : str
        What parts two numbers, one character, blanks around it or none; "": one blank or more.
    decimal_comma : bool
        Decimals may begin with a comma too.
    largest : float
        No number is larger, of either sign.
    line_bytes : int
        No line is longer.
    """

    n_columns: int
    delimiter: str
    decimal_comma: bool
    largest: float
    line_bytes: int


@dataclass(frozen=True, eq=False)
class PathProblem:
    """What a path search is asked for.

    Attributes
    ----------
    scores : float array, shape (n_input, n_pairs)
        ``scores[j, p]`` of frames j - a, j, j + b, where a and b are the steps of pair p; ``inf`` forbids.
    steps : StepPairs
        Which pairs.
    positions, frames : int arrays, shape (n_anchors,)
        Output positions and input frames that the path must pass, from (0, 0) to (..., n_input - 1).
    last_position_max : int
        The last anchor stands in a position from its own to this one.
    start_cost, end_cost : float arrays, shape (n_steps,)
        Added for the first and the last step; ``inf`` forbids it.
    band : int array, shape (last_position_max + 1, 2), optional
        For each position the first and the last frame at which the path may stand there; only the layered recurrence
        keeps to it.
    """

    scores: FloatArray
    steps: StepPairs
    positions: IntArray
    frames: IntArray
    last_position_max: int
    start_cost: FloatArray
    end_cost: FloatArray
    band: IntArray | None = None

    __repr__ = brief_repr


@dataclass(frozen=True, eq=False)
class PricedPath:
    """What the priced search found.

    Attributes
    ----------
    path : (int array, float), optional
        Frames and total; None where there is no path, or where it gave up.
    lower_bound : float
        No path can total less.
    gave_up : bool
        More memory than allowed: the layered recurrence has to do it.
    labels, passes, sweeps : int
        Labels of the last pass, passes with a widening gap, sweeps over all scores that looked for the price.
    sweep_seconds : float
        Spent in those sweeps.
    """

    path: tuple[IntArray, float] | None
    lower_bound: float
    gave_up: bool
    labels: int
    passes: int
    sweeps: int
    sweep_seconds: float

    __repr__ = brief_repr


def n_threads() -> int:
    """Threads to use: RETIME_THREADS, else as many as this process may run on."""
    wanted = os.environ.get("RETIME_THREADS", "").lstrip("0")
    if wanted.isascii() and wanted.isdigit():
        # More would only cost memory, and an endless number is no int.
        return min(int(wanted[:6]), _MOST_THREADS)
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@cache
def _import_error() -> str | None:
    """Try to load the compiled kernels: what went wrong, or None."""
    try:
        module = importlib.import_module("retime.kernels._kernels")
    except ImportError as error:
        return str(error)
    # In a checkout they stay as they were when newer sources come: they would be called as they can't be.
    expected = sources_digest(Path(__file__).parent)
    if expected and getattr(module, "sources", None) != expected:
        return "they are of other sources than those beside it"
    return None


def sources_digest(folder: Path) -> str:
    """Tell the sources of the compiled kernels by a digest, as CMakeLists.txt does; "" where there are none.

    Parameters
    ----------
    folder : Path
        Where they lie: in a checkout, beside this file. A wheel may have none: its parts are of one build.
    """
    found = [path for path in folder.iterdir() if path.suffix in (".cpp", ".hpp")] if folder.is_dir() else []
    hashes = sorted(hashlib.sha256(path.read_bytes()).hexdigest() for path in found)
    return hashlib.sha256("".join(hashes).encode()).hexdigest() if hashes else ""


def build_record() -> str:
    """Return what the installation recorded of the kernels.

    "built", "failed" (no compiler, or one that failed), "left out" (on purpose), "no CMake", or "unknown" where retime
    was not installed.
    """
    try:
        record = importlib.import_module("retime.kernels._built")
    except ImportError:
        return "unknown"
    return str(record.KERNELS)


def read_file(file: int, most: int) -> bytes | None:
    """Read a long file that was opened, from its begin: `most` bytes, or as many as it has; raise OSError.

    None without the compiled kernels, and where the system has no large pages to read into: as quick as any other way.
    """
    if not compiled_available():
        return None
    found: bytes | None = importlib.import_module("retime.kernels._kernels").read_file(file, most, n_threads())
    return found


def keep_freed_memory() -> None:
    """Have this process keep what it frees for what it allocates next: for a command that works on one long take.

    Does nothing without the compiled kernels, and where the system's own allocator keeps it.
    """
    if compiled_available():
        importlib.import_module("retime.kernels._kernels").keep_freed_memory()


def compiled_available() -> bool:
    """Whether the compiled kernels were built, and can be loaded."""
    return _import_error() is None


def why_not_compiled() -> str | None:
    """Say why the compiled kernels can't be had; None where they can."""
    error = _import_error()
    if error is None:
        return None
    record = build_record()
    if record == "built":
        return f"they were built, but can't be loaded ({error}): install retime again on this machine"
    if record == "failed":
        return (
            "they could not be built when retime was installed: install a C++20 compiler, then retime again. "
            "RETIME_REQUIRE_KERNELS=1 makes that installation stop at what fails, and show it"
        )
    if record == "left out":
        return "they were left out when retime was installed (RETIME_WITHOUT_KERNELS)"
    if record == "no CMake":
        return "they were not built: there was no CMake when retime was installed"
    return "they were not built: install retime where there is a C++20 compiler"


@cache
def backend(name: str | None = None, *, warn: bool = True) -> Backend:
    """Return the kernels to use.

    Parameters
    ----------
    name : {"compiled", "numpy"}, optional
        Left out: the environment variable RETIME_BACKEND, else the compiled ones where they can be had. Where they
        were meant to be there and are not, the slower ones come with a `RetimeWarning`.
    warn : bool
        False for what is not worth that warning.

    Raises
    ------
    OptionError
        No such backend, or the compiled one can't be had.
    """
    name = name or os.environ.get("RETIME_BACKEND")
    if not name:
        name = "compiled" if compiled_available() else "numpy"
        if warn and name == "numpy" and build_record() in ("built", "failed"):
            warnings.warn(
                f"retime works without its compiled kernels, many times slower: {why_not_compiled()}. "
                "RETIME_BACKEND=numpy says that this is meant",
                RetimeWarning,
                stacklevel=2,
            )
    if name not in BACKENDS:
        raise OptionError(f"the backend must be one of {', '.join(BACKENDS)}; found {name!r}")
    if name == "compiled" and (why := why_not_compiled()) is not None:
        raise OptionError(f"the compiled kernels can't be had: {why}")
    module = "retime.kernels.compiled" if name == "compiled" else "retime.kernels.numpy_backend"
    return cast(Backend, importlib.import_module(module))
