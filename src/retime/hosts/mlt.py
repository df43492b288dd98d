"""MLT (Shotcut, Kdenlive, melt): a chain whose link ``timeremap`` says which second of its clip each frame shows.

``time_map`` is an animated property: ``frame=second`` with semicolons between; an equals sign makes a line to the next
key, where ``|=`` would jump and ``~=`` bend. A frame shows the last one of the clip that has begun by its second, which
is cut off to a whole frame with nothing for rounding: so each second is written a hair late.
Frames are whole and count from 0 at the profile's rate. Equal seconds hold, falling ones run backward. Version 1 of the
link (MLT 7.12 has it) calls the property ``map``, which version 2 passes over for ``time_map``: both are written.

Source: MLT, Link timeremap (https://www.mltframework.org/plugins/LinkTimeremap/), its unit in Shotcut's filter Time:
Remap (s), and the framework's keyframe animation (https://www.mltframework.org/docs/framework/).
"""

from __future__ import annotations

import numpy as np

from retime.errors import FormatError
from retime.hosts.safe_xml import letters, parse_xml
from retime.hosts.shot import Shot, plain, warp_of
from retime.hosts.text import number
from retime.warp.curve import Warp

# Seconds: more than digits and lines between keys may lose, less than any frame can tell.
_LATE = 1e-7


def write(warp: Warp, shot: Shot) -> str:
    """Write a document with one chain."""
    rate = shot.exact_rate
    source = shot.item or "clip.mov"
    frames = np.rint(warp.output_times * float(rate)).astype(np.int64).tolist()
    keys = ";".join(
        f"{frame}={plain(time)}" for frame, time in zip(frames, (warp.input_times + _LATE).tolist(), strict=True)
    )
    last = shot.first_frame(warp) + shot.count_frames(warp) - 1
    return (
        '<?xml version="1.0" encoding="utf-8"?>\n<mlt LC_NUMERIC="C">\n'
        '  <profile width="1920" height="1080" progressive="1" sample_aspect_num="1" sample_aspect_den="1" '
        'display_aspect_num="16" display_aspect_den="9" '
        f'frame_rate_num="{rate.numerator}" frame_rate_den="{rate.denominator}"/>\n'
        f'  <chain id="chain0" out="{last}">\n'
        f'    <property name="resource">{letters(source)}</property>\n'
        '    <property name="mlt_service">avformat</property>\n'
        # Of the output, which may be longer than the clip.
        f'    <property name="length">{last + 1}</property>\n'
        f'    <link id="link0" in="0" out="{last}">\n      <property name="mlt_service">timeremap</property>\n'
        f'      <property name="map">{keys}</property>\n      <property name="time_map">{keys}</property>\n'
        '      <property name="image_mode">nearest</property>\n      <property name="pitch">1</property>\n'
        "    </link>\n  </chain>\n"
        f'  <playlist id="playlist0">\n    <entry producer="chain0" in="{shot.first_frame(warp)}" out="{last}"/>\n'
        "  </playlist>\n</mlt>\n"
    )


def read(data: bytes, shot: Shot) -> Warp:
    """Read the map of a document that `write` made, to compare it."""
    for found in parse_xml(data).all("property"):
        if found.attributes.get("name") == "time_map":
            pairs = [pair.partition("=") for pair in found.text.split(";")]
            frames, times = (np.array([number(pair[side]) for pair in pairs]) for side in (0, 2))
            return warp_of(frames / float(shot.exact_rate), times)
    raise FormatError("expected a document that retime wrote, with a time_map")
