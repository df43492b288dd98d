"""Every option of the search, declared once.

The command line, the editor's document and the fields of its page are made from this list; `retime.guided_warp` keeps
a signature of its own, and a test compares the two. Defaults stand here and nowhere else. CONTRIBUTING.md says how to
add an option.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Literal

from retime.errors import OptionError
from retime.limits import MAX_STEP

# What people type for an option, or what it holds:
# length    "65%", "9.3", "280f", or "free"     rate      "29.97", "30000/1001"
# speeds    "1/4..8"                             influence from 0 to 1, or a curve of (output time, share)
# number, whole, choice, flag                    as they say
Kind = Literal["length", "rate", "speeds", "influence", "number", "whole", "choice", "flag"]
Stage = Literal["analysis", "solve"]
Section = Literal["Keytimes", "Control", "Method"]
SearchName = Literal["priced", "layered", "heuristic"]
FreeWeight = Literal["neutral", "sum"]
Panel = Literal["timing", "search", "more"]
# For whom an option says something: the methods, and "hand" where a hand's speeds are carried over (`retime.imitate`).
Method = Literal["guided", "align", "linear", "spline", "hand"]

_SCORED: tuple[Method, ...] = ("guided",)
_ALL: tuple[Method, ...] = ("guided", "align", "hand")


# A weight beyond this outweighs all else, as this one does; sums with far larger ones have no digits left.
MOST_WEIGHT = 1e6


@dataclass(frozen=True)
class Choice:
    """One value of an option that is chosen from a few.

    Attributes
    ----------
    value : str
        In Python and on the command line.
    label : str
        On the page.
    """

    value: str
    label: str


@dataclass(frozen=True)
class Option:
    """One option of the search.

    Attributes
    ----------
    name : str
        What `retime.guided_warp` calls it.
    kind : str
        What it holds.
    default : object
        What holds where it is left out; None: what `usual` says.
    stage : {"analysis", "solve"}
        Whether the clips are analysed anew when it changes, or only the search runs again.
    section : str
        Its heading in the help of the command line.
    help : str
        What it does, for the command line.
    label, hint : str
        Its name on the page, and one line about it there, in an animator's words.
    panel : str
        Where it stands on the page: under Timing, Search, or More.
    usual : str
        The default in words, where it is not one plain value.
    in_short : str
        The same in a word or two, where that is too long for an empty field of the page.
    unit : str
        Of a number; people may type it, and read it after the default.
    least, most : float
        Bounds of a number, included. Those of a rate hold for the page alone, where nobody could stop a search that
        takes for ever.
    slider : (float, float), optional
        On the page a slider from 0 to the first number, in steps of the second; left out, a field.
    curve : {"straight", "square"}
        How the slider's place becomes the value: a square gives small values more room.
    choices : tuple of Choice
        The values of a choice.
    flag : str
        On the command line; left out, the name with dashes (and before them "no", where a flag is set by default).
    metavar : str
        What stands for its value in help.
    needs_free : bool
        It says something only where the length is free.
    methods : tuple of str
        Where it says something: for which methods, and "hand" where a hand's speeds are carried over.
    """

    name: str
    kind: Kind
    default: Any
    stage: Stage
    section: Section
    help: str
    label: str
    hint: str
    panel: Panel
    usual: str = ""
    in_short: str = ""
    unit: str = ""
    least: float = -math.inf
    most: float = math.inf
    slider: tuple[float, float] | None = None
    curve: Literal["straight", "square"] = "straight"
    choices: tuple[Choice, ...] = ()
    flag: str = ""
    metavar: str = ""
    needs_free: bool = False
    methods: tuple[Method, ...] = ("guided", "hand")

    @property
    def on_command_line(self) -> str:
        """Its flag."""
        return self.flag or f"--{'no-' if self.default is True else ''}{self.name.replace('_', '-')}"

    @property
    def default_words(self) -> str:
        """What holds where it is left out, in words."""
        if self.usual:
            return self.usual
        if self.kind == "flag":
            return "on" if self.default else "off"
        if self.kind == "choice":
            return str(self.default)
        return f"{self.default:g} {self.unit}".rstrip()

    def checked(self, value: Any) -> Any:
        """Return a value as the search wants it: a number of NumPy's, say, as a plain one.

        Raises
        ------
        OptionError
            It is not of this option's kind, or outside its bounds.
        """
        if value is None and self.default is None:
            return None
        if self.kind in ("number", "whole"):
            return self._checked_number(value)
        if self.kind == "choice":
            if value not in [choice.value for choice in self.choices]:
                allowed = ", ".join(choice.value for choice in self.choices)
                raise OptionError(f"{self.name} must be one of {allowed}; found {value!r}", option=self.name)
        elif self.kind == "flag" and not isinstance(value, bool):
            raise OptionError(f"{self.name} must be True or False; found {value!r}", option=self.name)
        # What is typed (lengths, rates, speeds) is read, and refused, where the clip's rate is known.
        return value

    def _checked_number(self, value: Any) -> int | float:
        # NumPy loads with it, for which help does not wait.
        from retime.checks import real, whole

        what = self.name if self.kind == "whole" else f"the {self.name.replace('_', ' ')}"
        number = (whole if self.kind == "whole" else real)(value, what, option=self.name)
        if not math.isfinite(number):
            raise OptionError(f"{what} must be a number, found {value}", option=self.name)
        if not self.least <= number <= self.most:
            bounds = f"at least {self.least:g}" if self.most == math.inf else f"from {self.least:g} to {self.most:g}"
            raise OptionError(f"{what} must be {bounds}, found {value}", option=self.name)
        return number


OPTIONS: tuple[Option, ...] = (
    Option(
        name="length",
        kind="length",
        default=None,
        usual="as the keytimes say; after the last one the input plays on",
        in_short="as the keytimes say",
        stage="solve",
        section="Keytimes",
        metavar="L",
        help="Length of the output: 65%, 9.3 (seconds) or 280f (frames at the clip's rate), or free: the search finds "
        "it.",
        label="Length",
        hint="65%, 9.3 (seconds), 280f, 0:09.3 or free: the search finds it",
        panel="timing",
        methods=("guided", "linear", "spline", "hand"),
    ),
    Option(
        name="min_length",
        kind="length",
        default=None,
        usual="none",
        stage="solve",
        section="Keytimes",
        metavar="L",
        help="With --length free: no shorter than this.",
        label="At least",
        hint="A free length is no shorter than this: 65%, 9.3 (seconds), 280f",
        panel="timing",
        needs_free=True,
    ),
    Option(
        name="max_length",
        kind="length",
        default=None,
        usual="none",
        stage="solve",
        section="Keytimes",
        metavar="L",
        help="With --length free: no longer than this.",
        label="At most",
        hint="A free length is no longer than this: 65%, 9.3 (seconds), 280f",
        panel="timing",
        needs_free=True,
    ),
    Option(
        name="free_weight",
        kind="choice",
        default="neutral",
        stage="solve",
        section="Keytimes",
        metavar="NAME",
        help="With --length free: weigh both clocks alike, or the paper's plain sum, which favours short results.",
        label="Weighed",
        hint="What makes one free length better than another",
        panel="timing",
        choices=(Choice("neutral", "Both clocks alike"), Choice("sum", "Plain sum (the paper's)")),
        needs_free=True,
        methods=_SCORED,
    ),
    Option(
        name="influence",
        kind="influence",
        default=1.0,
        stage="solve",
        section="Control",
        metavar="V",
        help="From 0 (spline through the keytimes) to 1 (guided), or a curve over output time: 0s=0,2s=1.",
        label="Influence",
        hint="1 follows the search; 0 is the spline through the keytimes, as drawn by hand",
        panel="timing",
        least=0.0,
        most=1.0,
        slider=(1.0, 0.01),
        methods=_ALL,
    ),
    Option(
        name="evenness",
        kind="number",
        default=None,
        usual="4 where a figure moves like itself, 0.1 like another, 0 for signals",
        stage="solve",
        section="Control",
        metavar="W",
        help="How evenly moving parts share the hurry (or the slowness), while pauses give way first; 0 is off.",
        label="Evenness",
        hint="How evenly moving parts share the hurry; pauses give way first",
        panel="timing",
        least=0.0,
        most=MOST_WEIGHT,
        slider=(8.0, 0.5),
        methods=_SCORED,
    ),
    Option(
        name="keep_flights",
        kind="number",
        default=None,
        usual="24 where a figure moves like itself, else 0",
        stage="solve",
        section="Control",
        metavar="K",
        help="How strongly jumps are played at their own speed; 0 is off.",
        label="Keep jumps",
        hint="Play jumps at their own speed",
        panel="timing",
        least=0.0,
        most=MOST_WEIGHT,
        slider=(48.0, 1.0),
        methods=_SCORED,
    ),
    Option(
        name="content",
        kind="number",
        default=0.0,
        stage="solve",
        section="Control",
        metavar="W",
        help="How dear it is to leap over poses, in feature units; 0 is off, 2 keeps nearly all actions.",
        label="Keep content",
        hint="How dear it is to leap over what happens",
        panel="more",
        least=0.0,
        most=MOST_WEIGHT,
        methods=_SCORED,
    ),
    Option(
        name="ends",
        kind="number",
        default=0.0,
        stage="solve",
        section="Control",
        metavar="W",
        help="How near to its own speed a clip begins and ends, in median scores; 0 is off, 0.2 is mild.",
        label="Calm ends",
        hint="How near to its own speed the clip begins and ends",
        panel="more",
        least=0.0,
        most=MOST_WEIGHT,
        methods=_SCORED,
    ),
    Option(
        name="own_timing",
        kind="number",
        default=0.0,
        stage="solve",
        section="Control",
        metavar="W",
        help="How near the clip stays to its own timing where a reference says little; 0 is off, 0.1 is mild.",
        label="Own timing",
        hint="How near the clip stays to its own timing where the reference says little",
        panel="more",
        least=0.0,
        most=MOST_WEIGHT,
        methods=_SCORED,
    ),
    Option(
        name="smoothness",
        kind="number",
        default=0.0,
        stage="solve",
        section="Control",
        metavar="W",
        help="Weight on changes of log-speed, in median scores.",
        label="Smoothness",
        hint="How much a change of speed costs: the more, the fewer changes",
        panel="timing",
        least=0.0,
        most=MOST_WEIGHT,
        slider=(4.0, 0.05),
        curve="square",
        methods=_ALL,
    ),
    Option(
        name="speed",
        kind="speeds",
        default=None,
        usual="none",
        stage="solve",
        section="Control",
        metavar="LO..HI",
        help="Slowest and fastest playback speed, such as 1/4..8; sets upsample and max_skip.",
        label="Speed limits",
        hint="Slowest and fastest for the whole clip: 1/2..2, 50%..200%, ..2",
        panel="timing",
        methods=_ALL,
    ),
    Option(
        name="loop",
        kind="flag",
        default=False,
        stage="solve",
        section="Control",
        help="The clip is a cycle and stays one: first and last speed agree.",
        label="Loop: its end meets its beginning",
        hint="The clip is a cycle, and stays one",
        panel="timing",
    ),
    Option(
        name="paper",
        kind="flag",
        default=False,
        stage="analysis",
        section="Method",
        help="The paper read literally: torso space, a time scale of one frame, its plain sum, and no price on tempo.",
        label="As in the paper",
        hint="The paper read literally, with nothing of what was added since",
        panel="more",
    ),
    Option(
        name="match_tempo",
        kind="flag",
        default=False,
        stage="analysis",
        section="Method",
        help="Take the reference's timing without its tempo: it is imitated as if it moved as fast as the clip.",
        label="Match the reference's tempo",
        hint="Imitate where the reference hurries and lingers, not how quick it is as a whole",
        panel="more",
        methods=_SCORED,
    ),
    Option(
        name="score",
        kind="choice",
        default="joint",
        stage="analysis",
        section="Method",
        metavar="NAME",
        help="joint: the paper's. conditional: how the reference moves where its pose is like this.",
        label="Score",
        hint="What makes a frame's speed look right",
        panel="search",
        choices=(Choice("joint", "Joint (the paper's)"), Choice("conditional", "Conditional")),
        methods=_SCORED,
    ),
    Option(
        name="search",
        kind="choice",
        default="priced",
        stage="solve",
        section="Method",
        metavar="NAME",
        help="priced, layered: exact. heuristic: the paper's, from coarse to fine; its excess is reported.",
        label="Exactness",
        hint="The best way there is, or a good one sooner, as the paper finds it",
        panel="more",
        choices=(
            Choice("priced", "Exact"),
            Choice("layered", "Exact, as in the paper"),
            Choice("heuristic", "Coarse to fine (paper)"),
        ),
    ),
    Option(
        name="features",
        kind="choice",
        default=None,
        usual="heading (torso where Y is not up), or signal",
        stage="analysis",
        section="Method",
        metavar="NAME",
        help="What a pose is. torso, heading: joints in that space. signal: the channels.",
        label="Pose",
        hint="In which space poses are compared",
        panel="search",
        choices=(
            Choice("torso", "Torso (the paper's)"),
            Choice("heading", "Heading"),
            Choice("signal", "Plain channels"),
        ),
        methods=_ALL,
    ),
    Option(
        name="rate",
        kind="rate",
        default=None,
        usual="30 Hz",
        stage="analysis",
        section="Method",
        metavar="R",
        help="Analysis rate, Hz; the output keeps the clip's own rate.",
        label="Search rate",
        hint="How many frames a second the search looks at: 30, 29.97. The output keeps the clip's own rate",
        panel="search",
        unit="Hz",
        least=1.0,
        most=240.0,
        methods=_ALL,
    ),
    Option(
        name="max_skip",
        kind="whole",
        default=None,
        usual="8 times upsample where a figure moves like itself; 16 for another reference; 8 for signals; more where "
        "the length needs it",
        in_short="as needed",
        stage="solve",
        section="Method",
        metavar="N",
        help="Largest step between neighbouring frames of the path: no speed beyond max_skip / upsample.",
        label="Longest step",
        hint="How many frames the search may leap to the next one it shows: the more, the faster it may play",
        panel="more",
        least=1,
        most=MAX_STEP,
        methods=_ALL,
    ),
    Option(
        name="upsample",
        kind="whole",
        default=None,
        usual="4 where a figure gets shorter, 12 where longer (1 and 4 where max_skip is given); 8 for another "
        "reference; fewer in takes beyond a minute or two; 1 or 4 for signals",
        in_short="as needed",
        stage="solve",
        section="Method",
        metavar="U",
        help="Input frames offered per analysis period: no speed below 1/U.",
        label="Finest step",
        hint="Into how many parts the search may divide a frame: 4 lets it play at a quarter of the speed",
        panel="more",
        least=1,
        methods=_ALL,
    ),
    Option(
        name="n_neighbors",
        kind="whole",
        default=3,
        stage="analysis",
        section="Method",
        flag="--neighbors",
        metavar="K",
        help="Reference frames averaged in a score.",
        label="Neighbours",
        hint="With how many frames of the reference each frame is compared",
        panel="more",
        least=1,
    ),
    Option(
        name="time_scale",
        kind="number",
        # By docs/study: from 0.1 to 0.2 flights are kept alike, and at 0.2 other timing is imitated best.
        default=0.2,
        stage="analysis",
        section="Method",
        metavar="S",
        help="How much velocity and acceleration weigh against pose, seconds.",
        label="Time scale",
        hint="How much the speed of the body counts beside its pose, in seconds",
        panel="more",
        unit="s",
        least=0.0,
        methods=_ALL,
    ),
    Option(
        name="low_pass",
        kind="number",
        default=4.0,
        stage="analysis",
        section="Method",
        metavar="HZ",
        help="Cutoff of the filter that the analysis looks through, Hz; 0 is off.",
        label="Low-pass",
        hint="Shaking that is faster than this, in Hz, is not looked at; 0: all is",
        panel="more",
        unit="Hz",
        least=0.0,
        methods=_ALL,
    ),
    Option(
        name="smoothing",
        kind="number",
        default=5,
        stage="solve",
        section="Method",
        metavar="N",
        help="Output frames, at the analysis rate, averaged to smooth the path's steps; 0 is off.",
        label="Smoothing",
        hint="Over how many of its frames the search evens out the speed; 0: it does not",
        panel="more",
        least=0,
        methods=_ALL,
    ),
)

BY_NAME: Mapping[str, Option] = {option.name: option for option in OPTIONS}


def names(stage: Stage, method: Method = "guided") -> tuple[str, ...]:
    """Name the options of a stage that say something for a method, in the order of their declaration."""
    return tuple(option.name for option in OPTIONS if option.stage == stage and method in option.methods)


def default_of(name: str) -> Any:
    """Return what holds where an option is left out."""
    return BY_NAME[name].default


def completed(stage: Stage, given: Mapping[str, Any]) -> dict[str, Any]:
    """Put the defaults to the options that were given.

    Raises
    ------
    OptionError
        A name that no option of the stage has, or a value that is not of its kind.
    """
    refuse_unknown(given, names(stage))
    return {name: BY_NAME[name].checked(given.get(name, default_of(name))) for name in names(stage)}


def refuse_unknown(given: Iterable[str], known: Iterable[str]) -> None:
    """Raise OptionError where a name is no option."""
    for name in given:
        if name not in known:
            raise OptionError(f"there is no option {name!r}; there are {', '.join(known)}")
