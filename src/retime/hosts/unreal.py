"""Unreal Engine 5.5 and later: a script that keys the Time Warp track of the open Level Sequence.

A Time Warp track of the kind Curve holds "a 1:1 mapping from unwarped to warped time"
(``UMovieSceneTimeWarpCurve``): the key's frame, and as its value the frame that is shown, here counted at the display
rate from `Shot.start`, and turned by the script into ticks of the sequence's tick resolution. Epic's Python interface
names the track, but not the keys of its channel: the script looks for a channel that takes keys, and where there is
none says so and prints the keys, to be typed in. It could not be run here.

Source: Epic, UMovieSceneTimeWarpCurve, MovieSceneTimeWarpTrack
(https://dev.epicgames.com/documentation/en-us/unreal-engine/API/Runtime/MovieScene/UMovieSceneTimeWarpCurve).
"""

from __future__ import annotations

import numpy as np

from retime.hosts.shot import Shot, plain_rows, warp_of
from retime.hosts.text import decoded, script_numbers
from retime.warp.curve import Warp

_AFTER = """
import unreal

sequence = unreal.LevelSequenceEditorBlueprintLibrary.get_current_level_sequence()
if sequence is None:
    raise RuntimeError("open the Level Sequence first")
shown = sequence.get_display_rate()
if shown.numerator * RATE[1] != shown.denominator * RATE[0]:
    raise RuntimeError("the sequence shows %d/%d frames a second, this curve has %d/%d"
                       % (shown.numerator, shown.denominator, RATE[0], RATE[1]))
ticks = sequence.get_tick_resolution()
per_frame = float(ticks.numerator) * RATE[1] / (float(ticks.denominator) * RATE[0])
tracks = sequence.find_tracks_by_type(unreal.MovieSceneTimeWarpTrack)
if not tracks:
    raise RuntimeError("add a track first: + Track > Time Warp > Curve")
channels = [channel for section in tracks[0].get_sections() for channel in section.get_all_channels()]
keyed = [channel for channel in channels if hasattr(channel, "add_key")]
if not keyed:
    for at, shows in zip(AT_FRAME, SHOWS_FRAME):
        print("frame %s shows frame %s" % (at, shows))
    raise RuntimeError("this version of Unreal gives scripts no access to the keys of a Time Warp track; type in the "
                       "keys that are printed above, with linear interpolation")
for key in keyed[0].get_keys():
    keyed[0].remove_key(key)
for at, shows in zip(AT_FRAME, SHOWS_FRAME):
    key = keyed[0].add_key(unreal.FrameNumber(int(at // 1)), shows * per_frame, at % 1.0)
    key.set_interpolation_mode(unreal.RichCurveInterpMode.RCIM_LINEAR)
"""


def write(warp: Warp, shot: Shot) -> str:
    """Write the script, to be run by Tools > Execute Python Script."""
    rate = shot.exact_rate
    return (
        "# Keys the Time Warp track (+ Track > Time Warp > Curve) of the Level Sequence that is open.\n"
        f"RATE = [{rate.numerator}, {rate.denominator}]\n"
        f"AT_FRAME = [{', '.join(plain_rows(shot.frames(warp.output_times)))}]\n"
        f"SHOWS_FRAME = [{', '.join(plain_rows(shot.frames(warp.input_times)))}]\n"
        f"{_AFTER}"
    )


def read(data: bytes, shot: Shot) -> Warp:
    """Read the keys of a script that `write` made, to compare them."""
    text = decoded(data)
    at, use = (np.array(script_numbers(text, name)) for name in ("AT_FRAME", "SHOWS_FRAME"))
    return warp_of(shot.times(at), shot.times(use))
