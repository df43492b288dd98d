"""The report: what happened when a file was read, and the file without its names, which still behaves in the same way.

The claim is tried, not hoped for: what was made is read again, and what comes of both readings is compared.
"""

from __future__ import annotations

import re
import tempfile
import traceback
import warnings
import zipfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from io import BytesIO
from itertools import groupby
from pathlib import Path, PurePath

from retime.errors import FormatError, RetimeError, words_of
from retime.files import noting_reads, read_bytes, resolved
from retime.formats.compressed import plain_path, read_plain
from retime.formats.file_signatures import foreign_kind
from retime.formats.read_options import ReadOptions
from retime.formats.registry import read_with, refuse_unfit
from retime.issue_report import binary_files, text_files
from retime.issue_report.stand_ins import StandIns, alike
from retime.issue_report.vocabulary import SPOKEN, words_of_messages
from retime.motion.channels import ChannelKind
from retime.motion.motion import Motion, Up

MOST_BYTES = 1 << 20
"""Of a report: what can be dropped into an issue."""

Mask = Callable[[bytes, StandIns], bytes]
Shorter = Callable[[bytes, int | None, ReadOptions], Iterator[bytes]]


@dataclass(frozen=True)
class Stripping:
    """How files of a kind are stripped.

    Attributes
    ----------
    mask : callable
        Replaces names.
    shorter : callable, optional
        Makes shorter files, to be tried one after another.
    keeps : str
        What stays, for the person who sends it.
    """

    mask: Mask
    shorter: Shorter | None
    keeps: str


def _text(mask: Mask) -> Mask:
    return lambda data, names: text_files.masked_text(mask, data, names)


_TABLE = Stripping(
    _text(text_files.mask_table),
    lambda data, line, _: text_files.shorter_table(data, line),
    "the numbers, dates and words that readers of tables know, in the rows that are in it",
)
_ASF = Stripping(
    _text(text_files.mask_asf),
    lambda data, line, _: text_files.shorter_amc(data, line),
    "the skeleton's numbers, and those of the frames that are in it",
)
STRIPPINGS: dict[str, Stripping] = {
    ".bvh": Stripping(
        _text(text_files.mask_bvh),
        lambda data, line, _: text_files.shorter_bvh(data, line),
        "the skeleton's numbers, and those of the frames that are in it",
    ),
    ".amc": _ASF,
    **dict.fromkeys((".csv", ".tsv", ".trc", ".mot", ".sto"), _TABLE),
    ".c3d": Stripping(
        binary_files.mask_c3d,
        lambda data, _, options: binary_files.shorter_c3d(data, options),
        "all parameters that are numbers; of the frames the first five and the last two, the others repeat the first",
    ),
    ".npy": Stripping(
        binary_files.mask_npy,
        lambda data, _, options: binary_files.shorter_npy(data, options),
        "of the numbers the first five frames and the last two, the others repeat the first",
    ),
    ".npz": Stripping(
        binary_files.mask_npz,
        lambda data, _, options: binary_files.shorter_npz(data, options),
        "of each array the first five rows and the last two, the others repeat the first; packed anew",
    ),
    ".json": Stripping(_text(binary_files.mask_keypoints), None, "all numbers"),
    ".glb": Stripping(
        binary_files.mask_glb, None, "the keys of all animations, and the nodes; meshes and pictures are zero"
    ),
    ".gltf": Stripping(
        binary_files.mask_gltf, None, "the keys of all animations, and the nodes; meshes and pictures are zero"
    ),
    ".fbx": Stripping(
        lambda data, names: (
            binary_files.mask_fbx(data, names)
            if data.startswith(b"Kaydara FBX Binary")
            else text_files.masked_text(text_files.mask_fbx_text, data, names)
        ),
        None,
        "the keys of all animations, and the numbers of the nodes; of a binary file meshes and embedded files are zero",
    ),
}
"""By the ending of a file's name; of other formats a report says what happened, and holds no file."""


@dataclass(frozen=True)
class Outcome:
    """What came of reading a file.

    Attributes
    ----------
    error : str
        The class of the error; "" where the file was read.
    message : str
        Its message.
    warnings : tuple of str
        What was warned of.
    facts : tuple of (str, str)
        What was read: kind, counts, rate.
    frames : int
        How many frames were read.
    trace : tuple of str
        For an error that is not meant to be: where in retime it was raised.
    line : int, optional
        The line that the error names.
    """

    error: str = ""
    message: str = ""
    warnings: tuple[str, ...] = ()
    facts: tuple[tuple[str, str], ...] = ()
    frames: int = 0
    trace: tuple[str, ...] = ()
    line: int | None = None

    def like(self, other: Outcome, names: StandIns, stem: str, *, numbers_too: bool) -> bool:
        """Tell whether another file, its names replaced, behaves in the same way; `stem` is what this one is called."""
        # A file called "frame" is called "clip" here, and so is every frame of its messages.
        pairs = {**names.of, b"clip": stem.encode()}
        return (
            self.error == other.error
            and self.facts == other.facts
            and len(self.warnings) == len(other.warnings)
            and all(
                alike(a, b, pairs, numbers_too=numbers_too)
                for a, b in zip((self.message, *self.warnings), (other.message, *other.warnings), strict=True)
            )
        )


@dataclass(frozen=True)
class Reading:
    """How a clip is read: as `retime.read` is told."""

    options: ReadOptions
    up: Up | None = None
    root: str | None = None

    def in_stand_ins(self, names: StandIns, skeleton: Path | None) -> Reading:
        """Return the same with the names that were met replaced."""
        channels: dict[str, ChannelKind] = {names.met_in(name): kind for name, kind in self.options.channels.items()}
        animation = self.options.animation
        options = replace(
            self.options,
            channels=channels,
            arrays=tuple(names.met_in(one) for one in self.options.arrays),
            animation=None if animation is None else names.met_in(animation),
            skeleton=None if self.options.skeleton is None else skeleton,
        )
        return Reading(options, self.up, None if self.root is None else names.met_in(self.root))

    def words(self) -> list[str]:
        """Write it as the command line has it."""
        options = self.options
        said: list[tuple[str, object]] = [
            ("--fps", options.rate),
            ("--skeleton", None if options.skeleton is None else options.skeleton.name),
            ("--up", self.up),
            ("--root", self.root),
            ("--animation", options.animation),
            ("--gaps", options.gaps),
            ("--confidence", options.confidence),
            *(("--array", one) for one in options.arrays),
            *(("--channel", f"{name}={kind}") for name, kind in options.channels.items()),
        ]
        flags = {
            "--repair": options.repair,
            "--decimal-comma": options.decimal_comma,
            "--allow-outside": options.outside,
        }
        return [f"{flag} {value}" for flag, value in said if value is not None] + [
            flag for flag, is_set in flags.items() if is_set
        ]


@dataclass(frozen=True)
class Report:
    """What is to be sent.

    Attributes
    ----------
    text : str
        What happened, in words; ``report.txt`` of the archive.
    files : mapping of str to bytes
        The clip without names, and files that belong to it.
    same : bool
        Whether the clip without names behaves in the same way.
    stayed : tuple of str
        The words of the file that were left.
    """

    text: str
    files: Mapping[str, bytes]
    same: bool
    stayed: tuple[str, ...]

    def archive(self) -> bytes:
        """Pack all of it; the same report gives the same bytes, and no time of day."""
        return _packed({"report.txt": self.text.encode(), **self.files})


def make_report(path: Path, reading: Reading, *, build: Sequence[tuple[str, str]], keep: Sequence[str] = ()) -> Report:
    """Read a file, and make a report of what happened.

    Parameters
    ----------
    path : Path
        The file.
    reading : Reading
        How it is read.
    build : sequence of (str, str)
        Versions, and the like.
    keep : sequence of str
        Words that are no secret and stay.

    Raises
    ------
    OSError
        The file can't be opened.
    """
    # Not there, or not to be opened: that is between the person and the system.
    with path.open("rb"):
        pass
    outcome, read_files = _read(path, reading)
    names = StandIns(frozenset(word.lower().encode() for one in keep for word in one.split()))
    suffix = plain_path(path).suffix.lower()
    made = _Made({}, False, None, "this format can't be stripped, so the file is not in the report")
    if suffix in STRIPPINGS:
        with warnings.catch_warnings():
            # What was to be warned of was taken down.
            warnings.simplefilter("ignore")
            made = _strip(path, reading, outcome, names, read_files)
    text = _in_words(path, reading, outcome, made, names, build)
    stayed = tuple(sorted({word.decode("latin-1") for word in names.stayed}, key=str.lower))
    return Report(text, made.files, made.same, stayed if made.files else ())


@dataclass(frozen=True)
class _Made:
    files: dict[str, bytes]
    same: bool
    outcome: Outcome | None
    why: str


def _strip(path: Path, reading: Reading, outcome: Outcome, names: StandIns, read_files: list[Path]) -> _Made:
    """Make the file without names, the shortest that behaves in the same way."""
    suffix = plain_path(path).suffix.lower()
    try:
        data = read_plain(path, reading.options.limits, repair=reading.options.repair)
    except (RetimeError, OSError):
        return _Made({}, False, None, "what is in the file can't be had, so it is not in the report")
    stripping = STRIPPINGS[suffix]
    clip = f"clip{suffix}"
    foreign = foreign_kind(data)
    masked = stripping.mask(data, names)
    if b"\0" in data:
        # In a binary file damage may have carried a name to where nobody looks for one.
        masked = names.swept(masked)
    start = b""
    if foreign is not None:
        # What a file is told by; of another kind altogether it may be all that counts.
        start = next(data[:n] for n in range(1, len(data) + 1) if foreign_kind(data[:n]) == foreign)
        masked = start + masked[len(start) :]
    beside = _beside(path, data, masked, read_files, names)
    shorter = [] if stripping.shorter is None else list(stripping.shorter(masked, outcome.line, reading.options))
    least: _Made | None = None
    for content in [start, *shorter, masked]:
        files = {clip: content, **beside}
        if len(_packed(files)) > MOST_BYTES:
            continue
        again = _read_again(clip, files, reading, names)
        same = outcome.like(again, names, plain_path(path).stem, numbers_too=content is masked)
        made = _Made(files, same, again, "")
        if same:
            return made
        least = made
    if least is None:
        return _Made(
            {}, False, None, f"nothing of it fits into {MOST_BYTES >> 20} MiB, so the file is not in the report"
        )
    return least


def _beside(path: Path, data: bytes, masked: bytes, read_files: list[Path], names: StandIns) -> dict[str, bytes]:
    """Strip the files that were read with a clip: the skeleton of an AMC, the buffers of a glTF.

    One that is not there is none of them: that may be what the report is about.
    """
    found: dict[str, bytes] = {}
    buffers: dict[Path, tuple[str, binary_files.Spans]] = {}
    if plain_path(path).suffix.lower() == ".gltf":
        theirs, ours = binary_files.buffers_beside(data), binary_files.buffers_beside(masked)
        for index in theirs.keys() & ours.keys():
            place, spans = theirs[index]
            buffers[resolved(path.parent / place)] = (ours[index][0], spans)
    for other in read_files:
        if other == path:
            continue
        try:
            content = read_bytes(other)
        except (RetimeError, OSError):
            continue
        if plain_path(other).suffix.lower() == ".asf":
            found["clip.asf"] = text_files.masked_text(text_files.mask_asf, content, names)
        elif resolved(other) in buffers:
            name, spans = buffers[resolved(other)]
            found[name] = binary_files.blank_but(content, spans)
    return found


def _read_again(clip: str, files: Mapping[str, bytes], reading: Reading, names: StandIns) -> Outcome:
    with tempfile.TemporaryDirectory(prefix="retime-report-") as folder:
        for name, content in files.items():
            place = Path(folder, name)
            place.parent.mkdir(parents=True, exist_ok=True)
            place.write_bytes(content)
        return _read(Path(folder, clip), reading.in_stand_ins(names, Path(folder, "clip.asf")))[0]


def _read(path: Path, reading: Reading) -> tuple[Outcome, list[Path]]:
    """Read a file, and take down whatever happens, and which files were read."""
    error, message, line = "", "", None
    trace: tuple[str, ...] = ()
    facts: tuple[tuple[str, str], ...] = ()
    frames = 0
    with warnings.catch_warnings(record=True) as caught, noting_reads() as read_files:
        warnings.simplefilter("always")
        try:
            clip = read_with(path, reading.options, up=reading.up, root=reading.root)
            refuse_unfit(clip, reading.options.channels, reading.root)
            facts, frames = _facts(clip), clip.n_frames
        except (RetimeError, OSError, MemoryError) as problem:
            error, message = type(problem).__name__, words_of(problem)
            line = problem.line if isinstance(problem, FormatError) else None
        except Exception as problem:  # What nobody expected is what the report is for.
            error, message = type(problem).__name__, str(problem)
            trace = _trace(problem)
    message, *said = (
        _without_places(text, path, read_files) for text in (message, *(str(one.message) for one in caught))
    )
    return Outcome(error, message, tuple(said), facts, frames, trace, line), read_files


def _without_places(text: str, path: Path, read_files: Sequence[Path]) -> str:
    """Call the file "clip" in a message, and leave out where it lies, and what is read with it."""
    for file in (path, *read_files):
        suffix = plain_path(file).suffix.lower()
        if file == path or suffix == ".asf":
            text = text.replace(str(file), f"clip{suffix}").replace(file.name, f"clip{suffix}")
        for folder in sorted({form for one in (file, resolved(file)) for form in _spellings(one.parent)}, key=len):
            # A folder of its own, not the end or the begin of another's name.
            alone = rf"(?<![\w./\\]){re.escape(folder)}"
            text = re.sub(rf"{alone}[/\\]+", "", text)
            # One of two letters is a word more often.
            if len(folder) > 2:
                text = re.sub(rf"{alone}(?!\w)", "FOLDER", text)
    whole = plain_path(path).stem
    # An ASF is looked for by the subject's name alone, 02.asf of 02_04.amc.
    text = text.replace(f"{whole.partition('_')[0]}.asf", "clip.asf")
    # The name of a person may be the file's; one of two letters is left, for it is a word more often.
    return re.sub(rf"(?<!\w){re.escape(whole)}(?!\w)", "clip", text) if len(whole) > 2 else text


def _spellings(folder: PurePath) -> set[str]:
    r"""Write a folder as messages may have it: as it is, with backslashes doubled by quoting, with slashes.

    Examples
    --------
    >>> from pathlib import PureWindowsPath
    >>> sorted(map(len, _spellings(PureWindowsPath(r"C:\\Users\\Ann"))))
    [12, 12, 14]
    >>> _spellings(PurePath("/"))
    set()
    """
    whole = str(folder).rstrip("/\\")
    return {whole, whole.replace("\\", "\\\\"), folder.as_posix().rstrip("/")} - {""}


def _in_own_words(message: str, names: StandIns) -> str:
    """Leave out of a message each word that the readers' code has not: it may be a name."""
    own = words_of_messages("retime.formats", "retime.errors")

    def one(match: re.Match[str]) -> str:
        word = match[0]
        data = word.encode("utf-8", "surrogateescape")
        is_number = not any(letter.isalpha() for letter in word)
        is_known = is_number or word.lower() in own or data in names.of or names.keeps(data)
        return word if is_known else "..."

    return SPOKEN.sub(one, message)


def _facts(clip: object) -> tuple[tuple[str, str], ...]:
    """Say what was read, without a name."""
    if isinstance(clip, Motion):
        skeleton = clip.skeleton
        return (
            ("holds", "motion"),
            ("joints", str(len(skeleton.names))),
            ("end sites", str(len(skeleton.end_sites))),
            ("parents", " ".join(map(str, skeleton.parents))),
            ("rate", str(clip.rate)),
            ("first frame", str(clip.first_frame)),
        )
    from retime.motion.signal import Signal

    assert isinstance(clip, Signal)
    return (
        ("holds", "signal"),
        ("channels", str(len(clip.names))),
        ("kinds", ", ".join(f"{len(list(group))} {kind}" for kind, group in groupby(_kind(one) for one in clip.kinds))),
        ("rate", str(clip.rate)),
        ("table", clip.dialect or ""),
        ("first frame", str(clip.first_frame)),
    )


def _kind(kind: ChannelKind) -> str:
    """Name a kind without the words of a label."""
    return str(replace(kind, words=()))


def _trace(problem: BaseException) -> tuple[str, ...]:
    """Name the places in retime that an error came through, by file within the package, line and function."""
    package = Path(__file__).parents[1]
    return tuple(
        f"retime/{Path(frame.filename).relative_to(package).as_posix()}:{frame.lineno} {frame.name}"
        for frame in traceback.extract_tb(problem.__traceback__)
        if Path(frame.filename).is_relative_to(package)
    )


def _packed(files: Mapping[str, bytes]) -> bytes:
    packed = BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            # A date of its own is what ZipInfo gives: 1980.
            archive.writestr(zipfile.ZipInfo(name), content, zipfile.ZIP_DEFLATED)
    return packed.getvalue()


def _in_words(
    path: Path, reading: Reading, outcome: Outcome, made: _Made, names: StandIns, build: Sequence[tuple[str, str]]
) -> str:
    suffix = plain_path(path).suffix.lower() or "(no ending)"
    # Where both say the same, what the stripped file makes retime say holds no name for certain.
    shown = outcome if made.outcome is None or not made.same else made.outcome
    options = reading.in_stand_ins(names, Path("clip.asf")).words()

    def told(message: str) -> str:
        # Of the file's own message not all names need be known.
        return names.met_in(message if made.same else _in_own_words(message, names))

    lines = [
        "retime report",
        "",
        *(f"{name}: {value}" for name, value in build),
        "",
        f"file: {suffix}, {path.stat().st_size} bytes",
        *([f"options: {' '.join(options)}"] if options else []),
    ]
    if outcome.error:
        lines.append(f"it ended in {outcome.error}: {told(shown.message)}")
        lines += [f"  in {place}" for place in outcome.trace]
    else:
        lines.append(f"it was read: {outcome.frames} frames")
    lines += [f"  {name}: {value}" for name, value in outcome.facts]
    lines += [f"warning: {told(one)}" for one in shown.warnings]
    lines.append("")
    if not made.files:
        lines.append(made.why)
        return "\n".join(lines) + "\n"
    lines.append("in this report, without names: " + ", ".join(f"{n} ({len(c)} bytes)" for n, c in made.files.items()))
    lines.append(f"  it keeps {STRIPPINGS[suffix].keeps}")
    if made.same:
        lines.append(
            f"  read again it behaves in the same way: retime info {' '.join([next(iter(made.files)), *options])}"
        )
    else:
        lines.append("  read again it does NOT behave in the same way, so a name, or a number left out, matters here:")
        assert made.outcome is not None
        lines.append(f"  {made.outcome.error or 'it is read'} {made.outcome.message}".rstrip())
        lines += [f"  warning: {one}" for one in made.outcome.warnings]
        lines += [f"  {name}: {value}" for name, value in made.outcome.facts if (name, value) not in outcome.facts]
    return "\n".join(lines) + "\n"
