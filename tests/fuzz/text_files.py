"""Mutants of files of text: each is read as something valid, or refused as retime refuses.

The files are of a few hundred bytes each, and together have all of a format's grammar, so that a mutant takes less than
a millisecond. They are read from memory where a reader takes bytes. Some of what is read is written, and read again.
"""

from __future__ import annotations

import bz2
import contextlib
import functools
import gzip
import json
import random
import re
import tempfile
import zlib
from collections.abc import Callable, Iterator
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from retime.arrays import FloatArray
from retime.batch.labels import ShownFrames, retimed_beside
from retime.batch.recipe import read_recipe
from retime.batch.treatment import Treatment
from retime.errors import FormatError
from retime.formats import amc, bvh, csv_table, read, write
from retime.formats.asf_reader import parse_asf
from retime.formats.joint_map import read_joint_map
from retime.formats.read_options import Limits, ReadOptions
from retime.motion import grammar, rate
from retime.motion.any_motion import AnyMotion
from retime.motion.channels import parse_channel, parse_channels
from retime.motion.gaps import GapPolicy
from retime.motion.motion import Motion
from retime.motion.signal import Signal
from retime.project.document import Document
from retime.project.file import project_bytes, read_project
from retime.project.journal import read_journal
from retime.warp.apply import apply_warp
from retime.warp.curve import Warp
from tests.formats.tables.test_dialects import DLC, MOTIVE, STO, TRC
from tests.fuzz.documents import whole_value
from tests.fuzz.trials import Trial, mutated_bytes, mutated_json, mutated_text

DATA = Path(__file__).resolve().parents[1] / "data"
PACKERS = {".gz": gzip.compress, ".bz2": bz2.compress}


def _files(folder: str) -> tuple[bytes, ...]:
    """Return the whole files of the tests' own data; what is broken has tests of its own."""
    found = (DATA / folder).glob(f"*.{folder}")
    return tuple(path.read_bytes() for path in sorted(found) if not path.name.startswith("broken"))


@contextlib.contextmanager
def _file(name: str, data: bytes) -> Iterator[Path]:
    """Make a file of that name, alone in a folder."""
    with tempfile.TemporaryDirectory(prefix="retime-fuzz-") as folder:
        path = Path(folder, name)
        path.write_bytes(data)
        yield path


def check(clip: AnyMotion) -> None:
    """Look whether a clip is one."""
    if isinstance(clip, Motion):
        n_frames, n_joints = clip.rotations.shape[:2]
        assert clip.rotations.shape == (n_frames, n_joints, 4), clip.rotations.shape
        assert clip.local_translations.shape == (n_frames, n_joints, 3), clip.local_translations.shape
        assert n_joints == len(clip.skeleton.names) == len(clip.skeleton.parents), n_joints
        assert np.isfinite(clip.local_translations).all()
        lengths = np.einsum("fjc,fjc->fj", clip.rotations, clip.rotations)
        # Where one is no number, no comparison holds.
        assert (np.abs(lengths - 1) < 1e-8).all()
    else:
        assert clip.values.shape == (clip.n_frames, len(clip.names)), clip.values.shape
        assert np.isfinite(clip.values[~clip.holes]).all()
    assert clip.n_frames >= 1
    assert clip.rate > 0


def write_and_read(clip: AnyMotion, path: Path) -> None:
    """Write a clip, and look whether it is read as the same."""
    try:
        write(clip, path)
    except FormatError:
        # Names that a format can't hold, numbers that its text can't.
        return
    skeleton = path.with_suffix(".asf")
    again = read(path, rate=clip.rate, skeleton=skeleton if skeleton.exists() else None, gaps="keep")
    assert again.n_frames == clip.n_frames, f"{clip.n_frames} frames are read as {again.n_frames}"
    if isinstance(clip, Motion):
        assert isinstance(again, Motion)
        # A file of nested joints has each before its children; the clip's own order need not be that.
        rotations = clip.rotations[:, _from_the_root(clip)]
        turned = 1 - np.abs(np.einsum("fjc,fjc->fj", rotations, again.rotations))
        assert turned.max(initial=0.0) < 1e-6, f"rotations differ: {turned.max()}"
    else:
        assert isinstance(again, Signal)
        assert np.array_equal(clip.values, again.values, equal_nan=True), "values differ"


def _from_the_root(clip: Motion) -> list[int]:
    """Return the joints in the order in which they are met from the root, each branch to its end."""
    order, waiting = [], [0]
    while waiting:
        joint = waiting.pop()
        order.append(joint)
        waiting += reversed(clip.skeleton.children(joint))
    return order


def _options(draw: random.Random, **more: Any) -> ReadOptions:
    return ReadOptions(
        rate=Fraction(30) if draw.random() < 0.4 else None,
        repair=draw.random() < 0.3,
        decimal_comma=draw.random() < 0.1,
        **more,
    )


_BVH_WORDS = tuple(
    b"HIERARCHY|ROOT|JOINT|End Site|End|Site|OFFSET|CHANNELS|MOTION|Frames:|Frame Time:|{|}|Xposition|Yposition|"
    b"Zposition|Xrotation|Yrotation|Zrotation|CHANNELS 3 Zrotation Xrotation Yrotation|OFFSET 0 0 0|ROOT b|:".split(
        b"|"
    )
)


def bvh_file(draw: random.Random) -> str:
    """Read a mutant of BVH."""
    data = mutated_text(draw, draw.choice(whole_files("bvh")), _BVH_WORDS, whole_files("bvh"))
    clip = bvh.read(Path("mutant.bvh"), data, _options(draw))
    check(clip)
    return _again(draw, clip, ".bvh")


def _again(draw: random.Random, clip: AnyMotion, suffix: str) -> str:
    """Write one of fifteen, and read it."""
    if draw.random() > 1 / 15:
        return f"{suffix} is read"
    written_again(clip, suffix)
    return f"{suffix} is written and read again"


def written_again(clip: AnyMotion, suffix: str = "") -> None:
    """Write a clip, or what has the same frames and names, in some format, and look whether it is read as the same."""
    with tempfile.TemporaryDirectory(prefix="retime-fuzz-") as folder:
        write_and_read(clip, Path(folder, f"again{suffix or ('.bvh' if isinstance(clip, Motion) else '.csv')}"))


_ASF_WORDS = tuple(
    b":version 1.10|:name x|:units|:root|:bonedata|:hierarchy|begin|end|id|direction|length|axis|XYZ|ZYX|dof|rx|ry rz|"
    b"tx|l|limits|(-inf inf)|order|TX TY TZ RX RY RZ|position|orientation|mass|angle deg|angle rad|root|bodymass|#"
    b"".split(b"|")
)


def asf_file(draw: random.Random) -> str:
    """Read a mutant of ASF; an AMC on it now and then."""
    data = mutated_text(draw, draw.choice(whole_files("asf")), _ASF_WORDS, whole_files("asf"))
    asf = parse_asf(Path("mutant.asf"), data, Limits())
    n_joints = asf.skeleton.n_joints
    assert len(asf.channels) == n_joints
    for turns in (asf.before, asf.after):
        assert turns.shape == (n_joints, 4)
        assert (np.abs(np.einsum("jc,jc->j", turns, turns) - 1) < 1e-8).all()
    assert np.isfinite(asf.skeleton.offsets).all()
    if draw.random() > 0.1:
        return ".asf is read"
    names = [name.decode("utf-8", "replace") for name in (b"root", *map(str.encode, asf.skeleton.names[1:]))]
    rows = "".join(
        f"{name} {' '.join(str(draw.randint(-90, 90)) for _ in of)}\n"
        for name, of in zip(names, asf.channels, strict=True)
        if of
    )
    with _file("mutant.asf", data) as path:
        head = b":FULLY-SPECIFIED\n:DEGREES\n1\n"
        clip = amc.read(path.with_suffix(".amc"), head + rows.encode(asf.encoding, "replace"), ReadOptions())
    check(clip)
    return ".asf carries a motion"


_AMC_WORDS = tuple(b":FULLY-SPECIFIED|:DEGREES|:RADIANS|root|1|2|3|# rate 60|#|lowerback|hand 1 2 3".split(b"|"))


def amc_file(draw: random.Random) -> str:
    """Read a mutant of AMC."""
    data = mutated_text(draw, draw.choice(whole_files("amc")), _AMC_WORDS, whole_files("amc"))
    clip = amc.read(Path("mutant.amc"), data, _options(draw, skeleton=DATA / "amc" / "arm.asf"))
    check(clip)
    return _again(draw, clip, ".amc")


_CLOCKS = (
    b"time,x\n00:00:01.5,1\n00:00:02.0,2\n00:00:02.5,3\n",
    b"timecode,x,y\n01:00:00:00,1,a\n01:00:00:01,2,b\n01:00:00:02,3,a\n",
    b"timestamp,x\n2026-03-01T12:00:00.0Z,1\n2026-03-01T12:00:00.1Z,2\n2026-03-01T12:00:00.2Z,3\n",
    b"time_ms;x;y\n0;0,5;1\n40;0,75;2\n80;1;3\n",
    b"time,turn,x\ns,deg,mm\n0,1,2\n0.1,3,4\n",
    b"sep=;\ntime;x;q.w;q.x;q.y;q.z\n0;1;1;0;0;0\n0.5;;0;1;0;0\n1;3;0;0;1;0\n",
    b'frame,"a ""b""",\'=c\n1,nan,0\n2,n/a,1e-3\n3,5,\n',
    b"UnixTimestamp,x\n1700000000000,1\n1700000000033,2\n1700000000067,3\n",
)
_TABLE_WORDS = tuple(
    b'time|t|frame|timestamp|timecode|,|;|\t|"|""|\'=|nan|NA||1e3|0.04|01:00:00:00|00:00:01;02|2026-03-01T12:00:00Z|sep=;|'
    b"rotation|deg|mm|ms|\r|x".split(b"|")
)


def csv_file(draw: random.Random) -> str:
    """Read a mutant of a plain table."""
    others = (*whole_files("csv"), *_CLOCKS)
    data = mutated_text(draw, draw.choice(others), _TABLE_WORDS, others)
    clip = csv_table.read(Path("mutant.csv"), data, _options(draw, gaps=_gaps(draw)))
    check(clip)
    return _again(draw, clip, ".csv")


def _gaps(draw: random.Random) -> GapPolicy | None:
    return draw.choice([None, None, GapPolicy(), GapPolicy(1.0)])


_DIALECTS = (
    STO.encode(),
    STO.replace("\t", "  ").encode(),
    TRC.encode(),
    MOTIVE.encode(),
    MOTIVE.replace(",,Bone", ",Type,Bone").replace(",,Hip", ",Name,Hip").replace(",,1", ",ID,1").encode(),
    DLC.encode(),
    b"".join(b"%d,0.5,1,2,2,%d,3,4,%d,\n" % (100 + 33 * i, i, i % 3) for i in range(5)),
    b"Timecode,BlendShapeCount,EyeBlinkLeft,JawOpen\n"
    + b"".join(b"01:00:00:%02d.000,2,0.%d,0.5\n" % (i, i) for i in range(4)),
)
_DIALECT_WORDS = tuple(
    b"endheader|nRows=3|nColumns=3|inDegrees=yes|DataType=double|DataType=Vec3|PathFileType|DataRate|NumMarkers|"
    b"NumFrames|Frame#|Format Version|Export Frame Rate|Rotation Type|XYZ|Quaternion|Bone|Rigid Body|Rotation|Position|"
    b"Name|Frame|scorer|individuals|bodyparts|coords|Timecode|BlendShapeCount|,|\t|,,|\n|1e9|Infinity".split(b"|")
)


def dialect_file(draw: random.Random) -> str:
    """Read a mutant of a table of some program: OpenSim, TRC, Motive, DeepLabCut, Kinect, Live Link."""
    data = mutated_text(draw, draw.choice(_DIALECTS), _DIALECT_WORDS, _DIALECTS)
    clip = csv_table.read(Path("mutant.trc"), data, _options(draw, gaps=_gaps(draw)))
    check(clip)
    return f"a table is read: {clip.dialect or 'plain'}"


def packed_file(draw: random.Random) -> str:
    """Read a mutant of a compressed file: damage is in what is packed, or in the pack."""
    suffix = draw.choice(["bvh", "csv"])
    data = draw.choice(whole_files(suffix))
    inside = draw.random() < 0.4
    if inside:
        data = mutated_text(draw, data)
    packer = draw.choice(list(PACKERS))
    data = PACKERS[packer](data)
    if not inside:
        data = mutated_bytes(draw, data)
    with _file(f"mutant.{suffix}{packer}", data) as path:
        check(read(path, rate=30, repair=draw.random() < 0.3))
    return f".{suffix}{packer} is read"


_MAPS = (
    b'{"Hips": "hip", "Knee": "knee", "\\u00e9": "e"}',
    b"Hips,hip\nKnee,knee\n",
    b'input,reference\n"a, b",c\nd,"e ""f"""\n',
)


def joint_map_file(draw: random.Random) -> str:
    """Read a mutant of a map of joints."""
    place = draw.randrange(len(_MAPS))
    data = mutated_text(draw, _MAPS[place], (b"input,reference", b'"', b"\\u0000", b"{", b",", b":"), _MAPS)
    with _file(f"mutant.{'json' if place == 0 else 'csv'}", data) as path:
        found = read_joint_map(path)
    assert found
    assert all(found), "an empty name"
    assert len(set(found.values())) == len(found)
    return "a joint map is read"


_WARP = Warp([0.0, 0.1, 0.2], [0.0, 0.15, 0.2], [(0.15, 0.1, 1.0)], name="walk").to_json().encode()


@functools.cache
def _walk() -> Motion:
    motion = read(DATA / "bvh" / "angles_beyond_half_turns.bvh")
    assert isinstance(motion, Motion)
    return replace(motion, declaration=None, declared_angles=None)


def _json_mutant(draw: random.Random, whole: bytes, value: Any) -> bytes:
    """Change JSON: mostly so that it is JSON still, for more of it comes through."""
    if draw.random() < 0.3:
        return mutated_text(draw, whole, (b"null", b"true", b"[]", b"{}", b'""', b"NaN", b"1e400", b'"a":1,'))
    for _ in range(draw.choice([1, 1, 1, 2, 3])):
        value = mutated_json(draw, value)
    return json.dumps(value).encode()


def warp_file(draw: random.Random) -> str:
    """Read a mutant of a saved warp, and do with it what commands do."""
    warp = Warp.from_json(_json_mutant(draw, _WARP, json.loads(_WARP)))
    times: FloatArray
    for times in (warp.output_times, warp.input_times):
        assert np.isfinite(times).all()
        assert len(times) == len(warp.output_times) >= 1
    assert Warp.from_json(warp.to_json()) == warp
    _ = repr(warp), warp._repr_html_(), warp.slopes
    # What is long takes long to make.
    if warp.output_end < 50:
        check(apply_warp(_walk(), warp))
    if warp.monotone:
        warp.inverse()
    return "a warp is read"


@functools.cache
def _projects() -> tuple[tuple[bytes, Any], ...]:
    values = [whole_value(random.Random(seed)) for seed in range(40)]
    for value in values[::3]:
        value["document"]["kept"] = [{"id": "w", "name": "kept"}]
        value["warps"] = {"w": json.loads(_WARP)}
    return tuple((json.dumps(value).encode(), value) for value in values)


def project_file(draw: random.Random) -> str:
    """Read a mutant of a project, write it, and read it again."""
    data = _json_mutant(draw, *draw.choice(_projects()))
    with _file("mutant.retime", data) as path:
        project = read_project(path)
        path.write_bytes(project_bytes(project.document, project.warps, path.parent))
        assert read_project(path).document == project.document
    return "a project is read"


def journal_file(draw: random.Random) -> str:
    """Read a mutant of an editor's journal, its sums made right again most times."""
    projects = [draw.choice(_projects())[1]["document"] for _ in range(2)]
    lines: list[Any] = [
        {"format": "retime-journal", "version": 2, "base": "", "start": projects[0]},
        {"did": "edit", "document": projects[1], "label": "a", "gesture": "g", "done": True},
        {"did": "undo"},
        {"did": "redo"},
        {"did": "keep", "id": "w", "warp": json.loads(_WARP)},
        {"did": "save", "digest": "0" * 64},
    ]
    if draw.random() < 0.3:
        draw.shuffle(lines)
    for _ in range(draw.choice([0, 1, 1, 2])):
        at = draw.randrange(len(lines))
        lines[at] = mutated_json(draw, lines[at])
    text = b""
    for line in lines:
        written = json.dumps(line).encode()
        text += b"%08x %s\n" % (zlib.crc32(written), written)
    if draw.random() < 0.2:
        text = mutated_text(draw, text)
    with _file("mutant-journal", text) as path:
        recovered = read_journal(path)
    assert isinstance(recovered.history.present, Document)
    return "a journal is read"


_LABELS = (
    (
        ".json",
        b'{"dur": 0.3, "n_frames": 9, "frame_ann": {"labels": [{"raw_label": "walk", "start_t": 0.05, "end_t": 0.2}, '
        b'{"start_frame": 2, "end_frame": 6}]}, "contacts": [0, 0, 1, 1, 1, 0, 0, 1, 1], "at": [{"time": 0.1}, '
        b'{"frame": 4}]}',
    ),
    (".csv", b"label,start_frame,end_frame\nstep,1,4\nturn,3,8\n"),
    (".csv", b"label,start_t,end_t,note\nstep,0.0,0.11,a\nturn,0.1,0.25,b\n"),
    (".csv", b"frame;label\n2;left\n7;right\n"),
    (".tsv", b"time\tlabel\n0.05\tleft\n0.2\tright\n"),
    (".csv", b"foot,label\n" + b"".join(b"%d,%s\n" % (i % 2, b"ab"[i % 2 : i % 2 + 1]) for i in range(9))),
)
_LABEL_WORDS = tuple(
    b"start_frame|end_frame|start_t|end_t|frame|time|onset|offset|dur|n_frames|1e400|-1|99999|null|NaN|[]|{}|,|;|\t".split(
        b"|"
    )
)
_SHOWN = (
    ShownFrames(Warp([0.0, 0.1, 0.2, 0.3], [0.0, 0.15, 0.05, 0.25]), Fraction(30), 9, 0, 9),
    ShownFrames(Warp([0.0, 0.1], [0.0, 0.1]), Fraction(30), 9, 2, 5),
    ShownFrames(Warp([0.0, 0.05, 0.2], [0.0, 0.1, 0.1]), Fraction(30), 9, 3, 4),
)


def labels_file(draw: random.Random) -> str:
    """Retime a mutant of what is known of a clip: what it says afterwards is still such a file."""
    suffix, data = draw.choice(_LABELS)
    if suffix == ".json":
        data = _json_mutant(draw, data, json.loads(data))
    else:
        data = mutated_text(draw, data, _LABEL_WORDS, [text for _, text in _LABELS])
    shown = draw.choice(_SHOWN)
    with _file(f"mutant{suffix}", data) as path:
        text = retimed_beside(path, shown)
    if suffix == ".json":
        json.loads(text, parse_constant=lambda word: _no_number(word))
    return f"labels are retimed ({suffix})"


def _no_number(word: str) -> None:
    raise AssertionError(f"{word} is written")


_RECIPES = (
    (
        ".toml",
        b'length = "80%"\nkey = ["1=0.8"]\n[[rule]]\nmatch = "walk/*"\nspeed = "0.5..2"\n'
        b'[[rule]]\nmatch = "*"\nskip = true\nlock = ["0.2:0.4"]\n',
    ),
    (".toml", b'method = "linear"\nfps = "30"\n\n[[rule]]\nmatch = "a?.bvh"\nlength = "free"\nsmoothness = 2.0\n'),
    (".csv", b'clip,length,key,speed\na.bvh,80%,1=0.8;2=1.5,0.5..2\n"b c.bvh",,,1\n'),
)
_RECIPE_WORDS = tuple(
    b'[[rule]]|[rule]|match = "*"|skip = true|table = "x.csv"|length|key|lock|speed|reference|variants|clip|"|=|[|'
    b"]|1e400|nan|inf|2026-01-01|'''|\\u0000|true|;".split(b"|")
)


def recipe_file(draw: random.Random) -> str:
    """Read a mutant of a recipe of many clips, and ask what some of them get."""
    suffix, data = draw.choice(_RECIPES)
    data = mutated_text(draw, data, _RECIPE_WORDS, [text for _, text in _RECIPES])
    with _file(f"recipe{suffix}", data) as path:
        recipe = read_recipe(path, Treatment())
    for name in ("a.bvh", "walk/b.bvh", "b c.bvh"):
        recipe.treatment_of(name)
    return f"a recipe is read ({suffix})"


def _frame_time(text: str, reader: Callable[[str], Any] = rate.rate_from_frame_time) -> Any:
    """Read a frame time, for which a reader of files says where it stands."""
    try:
        return reader(text)
    except ValueError as error:
        raise FormatError(str(error)) from None


_TYPED: tuple[tuple[Callable[[str], Any], tuple[str, ...]], ...] = (
    (grammar.read_time, ("1.5", "1.5s", "30f", "00:01.5", "1/3", "90%", "01:00:00:12")),
    (lambda text: grammar.parse_time(text, Fraction(30)), ("1.5", "45f", "1:02.5", "2/3")),
    (lambda text: grammar.parse_length(text, 120, Fraction(30)), ("65%", "1.5s", "50f", "1.5", "2x")),
    (grammar.check_length, ("65%", "free", "50f")),
    (lambda text: grammar.parse_frame_range(text, 120), ("3:50", ":", "10:", ":90", "-1:5")),
    (grammar.parse_speed, ("0.5", "1/4", "2x", "200%")),
    (grammar.parse_speeds, ("1/4..4", "0.5..2", "..2", "1")),
    (grammar.read_span, ("0.2:0.4", "5f..10f", "1:00..1:02", "0.2-0.4")),
    (grammar.read_lock, ("0.2:0.4", "0.2..0.4=1/2", "5f..10f@0.5..2")),
    (grammar.read_key, ("1=0.8", "1.5=1.2@0.5", "30f=20f")),
    (grammar.parse_share, ("0.5", "50%", "1/3")),
    (rate.parse_rate, ("30", "29.97", "30000/1001", "23.976", "ntsc", "1e3")),
    (_frame_time, ("0.0333333", "0.008333", "1/30", "0.04", "8.33e-3")),
    (lambda text: _frame_time(text, rate.rate_meant_by), ("33.333", "30", "41.667")),
    (parse_channel, ("pan=angle:deg", "x=linear:mm", "q.*=quaternion", "note=label", "a:b=linear")),
    (parse_channels, ("pan=angle:deg,x=linear", "a=label")),
    (GapPolicy.parse, ("keep", "bridge", "0.5s", "bridge:0.5")),
)
_TYPED_WORDS = tuple("1e400|..|=|@|%|f|s|:|;|/|nan|inf|-|+|1_0|٣|x|0|999999999999|1e-320|,".encode().split(b"|"))


def typed_text(draw: random.Random) -> str:
    """Read a mutant of what people type for times, lengths, speeds, rates and channels."""
    reader, texts = draw.choice(_TYPED)
    data = mutated_text(draw, draw.choice(texts).encode(), _TYPED_WORDS, [text.encode() for text in texts])
    found = reader(data.decode("utf-8", "surrogateescape"))
    numbers = found if isinstance(found, tuple) else (found,)
    # No fastest speed is one of inf.
    assert not any(np.isnan(one) for one in numbers if isinstance(one, float)), found
    return "what was typed is taken"


@functools.cache
def whole_files(kind: str) -> tuple[bytes, ...]:
    """Return files that mutants are made of."""
    found = _files(kind)
    if kind == "bvh":
        # Shorter names and numbers: more of what is changed is grammar.
        found += tuple(re.sub(rb"(\.\d)\d+", rb"\1", text) for text in found if text.isascii())
    return found


KINDS: dict[str, Trial] = {
    "bvh": bvh_file,
    "asf": asf_file,
    "amc": amc_file,
    "csv": csv_file,
    "tables": dialect_file,
    "packed": packed_file,
    "joint-map": joint_map_file,
    "warp": warp_file,
    "project": project_file,
    "journal": journal_file,
    "labels": labels_file,
    "recipe": recipe_file,
    "typed": typed_text,
}
