"""Premiere Pro (and Final Cut Pro 7): a sequence whose clip has the effect Time Remap.

``graphdict`` has keys of the clip's frame, ``when``, and of the source's frame, ``value``; ``variablespeed`` 1 says
that they count. Without Bezier handles the curve FCPCurve is a line between keys. Frames of both count from the clip's
own beginning, 0, at the rate, which is a whole ``timebase`` and, for 1000/1001 of it, ``ntsc`` TRUE.

Time Remapping goes no faster than 1000 % (http://www.dvpa.com/public/483.cfm, of CS3; a newer word was not found).

Source: Apple, Final Cut Pro XML Interchange Format, "Speed XML" and the Elements Catalog
(https://developer.apple.com/library/archive/documentation/AppleApplications/Reference/FinalCutPro_XML/Topics/Topics.html).
Which flags of keys Premiere asks for is nowhere written: the first and the last have those that its own files have.
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from retime.errors import FormatError, OptionError
from retime.hosts.safe_xml import letters, parse_xml
from retime.hosts.shot import Shot, plain, warp_of
from retime.hosts.source_file import address, file_name_of, name_of
from retime.hosts.text import number
from retime.warp.curve import Warp


def write(warp: Warp, shot: Shot) -> str:
    """Write a sequence with one clip."""
    rate = _rate(shot.exact_rate)
    source = shot.item or "clip.mov"
    name = letters(name_of(source))
    first, n = shot.first_frame(warp), shot.count_frames(warp)
    frames = np.rint(warp.output_times * float(shot.exact_rate)).astype(np.int64).tolist()
    shows = (warp.input_times * float(shot.exact_rate)).tolist()
    n_in = int(np.ceil(max(shows) - 1e-6)) + 1
    keys = "".join(
        f"<keyframe><when>{at}</when><value>{plain(value)}</value><speedvirtualkf>TRUE</speedvirtualkf>"
        f"{'<speedkfstart>TRUE</speedkfstart>' * (key == 0)}"
        f"{'<speedkfend>TRUE</speedkfend>' * (key == len(frames) - 1)}"
        "</keyframe>\n"
        for key, (at, value) in enumerate(zip(frames, shows, strict=True))
    )
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n<!DOCTYPE xmeml>\n<xmeml version="4">\n'
        f"<sequence><name>retimed {name}</name><duration>{first + n}</duration>{rate}<media><video>\n"
        f"<format><samplecharacteristics>{rate}<width>1920</width><height>1080</height></samplecharacteristics></format>\n"
        f'<track><clipitem id="clip1"><name>{name}</name><duration>{max(n_in, first + n)}</duration>{rate}\n'
        f"<start>{first}</start><end>{first + n}</end><in>{first}</in><out>{first + n}</out>\n"
        f'<file id="file1"><name>{letters(file_name_of(source))}</name><pathurl>{letters(address(source))}</pathurl>'
        f"{rate}"
        f"<duration>{n_in}</duration><media><video/></media></file>\n"
        "<filter><effect><name>Time Remap</name><effectid>timeremap</effectid><effectcategory>motion</effectcategory>"
        "<effecttype>motion</effecttype><mediatype>video</mediatype>\n"
        f"{_parameter('variablespeed', '1', 0, 1)}{_parameter('speed', '100', -100000, 100000)}"
        "<parameter><parameterid>reverse</parameterid><name>reverse</name><value>FALSE</value></parameter>\n"
        "<parameter><parameterid>frameblending</parameterid><name>frameblending</name><value>FALSE</value></parameter>\n"
        f"<parameter><parameterid>graphdict</parameterid><name>graphdict</name><valuemin>0</valuemin>"
        f"<valuemax>{n_in}</valuemax><value>0</value>\n{keys}"
        "<interpolation><name>FCPCurve</name></interpolation></parameter>\n"
        "</effect></filter></clipitem></track>\n</video></media></sequence>\n</xmeml>\n"
    )


def _rate(rate: Fraction) -> str:
    """Write the rate."""
    for base, ntsc in ((rate, "FALSE"), (rate * 1001 / 1000, "TRUE")):
        if base.denominator == 1:
            return f"<rate><timebase>{base}</timebase><ntsc>{ntsc}</ntsc></rate>"
    raise OptionError(
        f"premiere has no sequence of {float(rate):g} frames a second: whole rates, or 1000/1001 of one (--rate)"
    )


def _parameter(name: str, value: str, least: int, most: int) -> str:
    return (
        f"<parameter><parameterid>{name}</parameterid><name>{name}</name><valuemin>{least}</valuemin>"
        f"<valuemax>{most}</valuemax><value>{value}</value></parameter>\n"
    )


def read(data: bytes, shot: Shot) -> Warp:
    """Read the keys of a document that `write` made, to compare them."""
    for parameter in parse_xml(data).all("parameter"):
        name = parameter.child("parameterid")
        if name is not None and name.text == "graphdict":
            pairs = [[_number(key.child("when")), _number(key.child("value"))] for key in parameter.all("keyframe")]
            frames = np.array(pairs).reshape(-1, 2)
            return warp_of(shot.times(frames[:, 0]), shot.times(frames[:, 1]))
    raise FormatError("expected a document that retime wrote, with a graphdict")


def _number(element: object) -> float:
    return number(getattr(element, "text", ""))
