from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from retime.arrays import FloatArray, IntArray

def tell(heard: Callable[[float], None], /) -> None: ...
def joint_scores(
    input: FloatArray,
    reference: FloatArray,
    steps: IntArray,
    velocity: float,
    acceleration: float,
    n_neighbors: int,
    scale: float,
    n_threads: int,
    each: bool,
    out: FloatArray,
    /,
) -> None: ...
def bounded_scores(
    input: FloatArray,
    reference: FloatArray,
    steps: IntArray,
    velocity: float,
    acceleration: float,
    n_neighbors: int,
    low_input: FloatArray,
    low_reference: FloatArray,
    scale: float,
    order: IntArray,
    following: NDArray[np.int32],
    n_threads: int,
    each: bool,
    out: FloatArray,
    /,
) -> None: ...
def conditional_scores(
    input: FloatArray,
    reference: FloatArray,
    steps: IntArray,
    velocity: float,
    acceleration: float,
    n_neighbors: int,
    nearest: IntArray,
    n_threads: int,
    out: FloatArray,
    /,
) -> None: ...
def nearest_poses(
    input: FloatArray,
    poses: FloatArray,
    n_neighbors: int,
    origin: FloatArray,
    scale: float,
    blur: float,
    n_threads: int,
    out: IntArray,
    /,
) -> None: ...
def layered_path(
    scores: FloatArray,
    steps: IntArray,
    positions: IntArray,
    frames: IntArray,
    last_position_max: int,
    start_cost: FloatArray,
    end_cost: FloatArray,
    band: IntArray,
    memory_limit: int,
    /,
) -> tuple[IntArray, float] | None: ...
def aligned_path(
    input: FloatArray,
    reference: FloatArray,
    steps: IntArray,
    velocity: float,
    acceleration: float,
    prices: FloatArray,
    positions: IntArray,
    frames: IntArray,
    start_cost: FloatArray,
    end_cost: FloatArray,
    n_threads: int,
    memory_limit: int,
    table_limit: int,
    /,
) -> tuple[IntArray, float] | None: ...
def free_path(
    scores: FloatArray,
    steps: IntArray,
    positions: IntArray,
    frames: IntArray,
    start_cost: FloatArray,
    end_cost: FloatArray,
    /,
) -> tuple[IntArray, float] | None: ...
def priced_path(
    scores: FloatArray,
    steps: IntArray,
    positions: IntArray,
    frames: IntArray,
    last_position_max: int,
    start_cost: FloatArray,
    end_cost: FloatArray,
    max_bytes: int,
    /,
) -> tuple[tuple[IntArray, float] | None, float, bool, int, int, int, float]: ...
def read_rows(
    text: bytes,
    n_columns: int,
    delimiter: str,
    decimal_comma: bool,
    largest: float,
    line_bytes: int,
    n_threads: int,
    out: FloatArray,
    /,
) -> tuple[int, int, int]: ...
def read_joint_rows(
    text: bytes,
    start: int,
    piece_bytes: int,
    n_columns: int,
    decimal_comma: bool,
    largest: float,
    line_bytes: int,
    turned: list[tuple[IntArray, IntArray, tuple[int, int, int], float]],
    many: float,
    columns: IntArray,
    places: IntArray,
    offsets: FloatArray,
    n_threads: int,
    angles: FloatArray,
    quaternions: FloatArray,
    translations: FloatArray,
    /,
) -> tuple[int, int]: ...
def read_file(file: int, most: int, n_threads: int, /) -> bytes | None: ...
def write_rows(rows: FloatArray, /) -> bytes: ...
def three_turns(angles: FloatArray, axes: tuple[int, int, int], sign: float, quaternions: FloatArray, /) -> None: ...
def turn_joints(
    rows: FloatArray,
    joints: IntArray,
    columns: IntArray,
    axes: tuple[int, int, int],
    sign: float,
    many: float,
    n_threads: int,
    angles: FloatArray,
    quaternions: FloatArray,
    /,
) -> None: ...
def pose_joints(
    parents: IntArray,
    site_parents: IntArray,
    site_offsets: FloatArray,
    turn: FloatArray,
    rotations: FloatArray,
    translations: FloatArray,
    n_threads: int,
    positions: FloatArray,
    global_rotations: FloatArray,
    end_positions: FloatArray,
    /,
) -> None: ...
def average_turns(
    parents: IntArray,
    groups: IntArray,
    widths: IntArray,
    own: IntArray,
    halves: FloatArray,
    centres: FloatArray,
    closed: float,
    least: float,
    rotations: FloatArray,
    n_threads: int,
    sampled: FloatArray,
    /,
) -> None: ...
def keep_freed_memory() -> None: ...
def extent(numbers: FloatArray, n_threads: int, /) -> tuple[float, float]: ...
def squared_lengths(quaternions: FloatArray, n_threads: int, /) -> tuple[float, float]: ...
