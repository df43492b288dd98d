"""FCPXML (Final Cut Pro; Resolve reads it): a clip with a ``timeMap``.

``timept`` gives a ``time`` of the retimed clip and the ``value``, a time of the original clip, as rational seconds,
both from the clip's first frame; ``interp="linear"`` must be said, as ``smooth2``, a spline whose form is nowhere
written down, is what holds otherwise. Values that fall run backward, equal ones hold. Lengths and places of clips stand
on whole frames, times of the map need not. The nearest frame is shown: the last that has begun (``floor``) would be a
frame early wherever rounding leaves a value a hair below a whole frame.

A map's first and last point are the ends of the clip, and a clip ends when its last frame has been shown. A warp ends
where its last frame begins: so one more point holds that frame until the clip ends, and a last hold of less than a
frame and a half is, when read, no part of the warp.

Source: Apple, FCPXML Reference, ``timeMap`` and ``timept``
(https://developer.apple.com/documentation/professional-video-applications/timemap), and its DTD 1.10.
"""

from __future__ import annotations

import re
import warnings
from fractions import Fraction

import numpy as np

from retime.errors import FormatError, RetimeWarning
from retime.hosts.choosing import chosen
from retime.hosts.safe_xml import Element, attribute, parse_xml
from retime.hosts.shot import MOST_KEYS, Shot, warp_of
from retime.hosts.source_file import address, name_of
from retime.warp.curve import Warp

_TIME = re.compile(r"([+-]?\d{1,19})(?:/(\d{1,10}))?s", re.ASCII)
# Parts of a second that map times are written in, at least.
_FINE = 10_000_000


def write(warp: Warp, shot: Shot) -> str:
    """Write a project with one clip."""
    rate = shot.exact_rate
    n_out = shot.first_frame(warp) + shot.count_frames(warp)
    n_in = int(np.ceil(float(warp.input_times.max()) * float(rate) - 1e-6)) + 1
    source = shot.item or "clip.mov"
    name = attribute(name_of(source))
    # A multiple of the rate's, so that whole frames are exact.
    scale = rate.numerator * -(-_FINE // rate.numerator)
    points = "".join(
        f'            <timept time="{_fine(at, scale)}" value="{_fine(use, scale)}" interp="linear"/>\n'
        for at, use in zip(warp.output_times.tolist(), warp.input_times.tolist(), strict=True)
    )
    if n_out / float(rate) > warp.output_end + 1e-6:
        # To the digit, as the clip's own end is.
        end, value = _exact(n_out / rate), _fine(float(warp.input_times[-1]), scale)
        points += f'            <timept time="{end}" value="{value}" interp="linear"/>\n'
    start = _exact(shot.first_frame(warp) / rate)
    duration = _exact(shot.count_frames(warp) / rate)
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n<!DOCTYPE fcpxml>\n<fcpxml version="1.10">\n  <resources>\n'
        f'    <format id="r1" frameDuration="{_exact(1 / rate)}" width="1920" height="1080"/>\n'
        f'    <asset id="r2" name={name} start="0s" duration="{_exact(n_in / rate)}" hasVideo="1" format="r1">\n'
        f'      <media-rep kind="original-media" src={attribute(address(source))}/>\n    </asset>\n  </resources>\n'
        f"  <project name={attribute('retimed ' + name_of(source))}>\n"
        f'    <sequence format="r1" duration="{_exact(n_out / rate)}">\n      <spine>\n'
        f'        <asset-clip ref="r2" name={name} offset="{start}" start="{start}" duration="{duration}">\n'
        '          <timeMap frameSampling="nearest-neighbor" preservesPitch="1">\n'
        f"{points}"
        "          </timeMap>\n        </asset-clip>\n      </spine>\n    </sequence>\n  </project>\n</fcpxml>\n"
    )


def _exact(time: Fraction) -> str:
    return f"{time.numerator}s" if time.denominator == 1 else f"{time.numerator}/{time.denominator}s"


def _fine(time: float, scale: int) -> str:
    return _exact(Fraction(round(Fraction(time) * scale), scale))


def read(data: bytes, shot: Shot) -> Warp:
    """Read the one time map of a document, or that of the clip of the name `Shot.item`."""
    top = parse_xml(data)
    if top.tag != "fcpxml":
        raise FormatError(f"expected a document of fcpxml, found {top.tag[:40]!r}", line=top.line)
    found: dict[str, Element] = {}
    waiting = [top]
    while waiting:
        element = waiting.pop()
        if element.child("timeMap") is not None:
            name = element.attributes.get("name", element.tag)
            found[name if name not in found else f"{name} ({len(found) + 1})"] = element
        waiting += reversed(element.children)
    clip = chosen(found, shot.item, "clip with a timeMap", "FCPXML")
    if clip.attributes.get("enabled") == "0":
        warnings.warn(
            "the clip is disabled, so Final Cut Pro does not show it; its time map is read all the same",
            RetimeWarning,
            stacklevel=2,
        )
    time_map = next(child for child in clip.children if child.tag == "timeMap")
    points = [child for child in time_map.children if child.tag == "timept"]
    if len(points) > MOST_KEYS:
        raise FormatError(f"more than {MOST_KEYS} keys", line=points[MOST_KEYS].line)
    for point in points:
        kind = point.attributes.get("interp", "smooth2")
        if kind != "linear":
            raise FormatError(
                f'a timept with interp="{kind[:40]}" is a spline that only Final Cut Pro knows: turn its smooth '
                'speed transitions off, or write interp="linear"',
                line=point.line,
            )
    outputs, inputs = ([_time(point, what) for point in points] for what in ("time", "value"))
    if len(points) > 2 and inputs[-1] == inputs[-2] and outputs[-1] - outputs[-2] < 1.5 * _frame(top):
        del outputs[-1], inputs[-1]
    return warp_of(outputs, inputs, place=lambda key: {"line": points[key].line}, begins={"line": time_map.line})


def _frame(top: Element) -> float:
    """Return how long a frame lasts by the first format, seconds; 0 where none says."""
    for element in top.all("format"):
        if "frameDuration" in element.attributes:
            return _time(element, "frameDuration")
    return 0.0


def _time(point: Element, what: str) -> float:
    match = _TIME.fullmatch(point.attributes.get(what, "").strip())
    if match is None or int(match[2] or 1) == 0:
        found = point.attributes.get(what)
        raise FormatError(
            f"{what}: expected rational seconds such as 1001/24000s, found {found!r:.50}", line=point.line
        )
    return float(Fraction(int(match[1]), int(match[2] or 1)))
