"""ffmpeg: a chain of filters for ``-/filter:v``, or before version 7 ``-filter_script:v``.

``setpts`` gives each input frame the time at which it is to be shown, so it needs the inverse of the warp; a hold or a
span that runs backward has none. ``T`` is the input's time in seconds, ``TB`` its time base, which ``settb`` makes a
millionth of a second, as a time is cut off to it. A frame is given the time at which it becomes the nearest one, half
a frame of the input early; then ``fps`` with ``round=up`` shows at each output frame the input frame nearest to what
the warp asks for. ``trim`` leaves out what the warp does not show, ``tpad`` keeps the last frame of the rest, and a
second ``trim`` ends after the last output frame. The pieces stand in ``if`` inside ``if``, halved each time, as ffmpeg
reads no more than some hundred levels. A file of filters has no comments.

Source: ffmpeg-filters, setpts, trim, fps (https://ffmpeg.org/ffmpeg-filters.html), and ffmpeg-utils, Expression
Evaluation.
"""

from __future__ import annotations

import re

import numpy as np

from retime.errors import FormatError
from retime.hosts.shot import Shot, plain, warp_of
from retime.hosts.text import decoded, number
from retime.warp.curve import Warp

_PIECE = re.compile(r"([\d.]+)\+\(T-([\d.]+)\)\*([\d.]+)")
_END = re.compile(r"trim=start=[\d.]+:end=([\d.]+),")


def write(warp: Warp, shot: Shot) -> str:
    """Write the chain."""
    rate = shot.exact_rate
    inverse = warp.inverse()
    at, use = inverse.output_times.tolist(), inverse.input_times.tolist()
    pieces = [
        f"{plain(out)}+(T-{plain(time)})*{_sharp((later - out) / (end - time))}"
        for time, end, out, later in zip(at[:-1], at[1:], use[:-1], use[1:], strict=True)
    ]
    # The last frame that is shown stays, so that no frame of the output is the end of the stream.
    shown = f"trim=start={plain(max(at[0] - 0.5 / float(rate), 0.0))}:end={plain(at[-1] + 0.5 / float(rate))}"
    begin = f"settb=AVTB,{shown},tpad=stop=-1:stop_mode=clone"
    half = f"setpts='PTS-{plain(0.5 / float(rate))}/TB'"
    fps = f"fps={rate}:start_time={plain(shot.first_frame(warp) / float(rate))}:round=up"
    end = f"trim=end_frame={shot.count_frames(warp)}"
    return f"{begin},{half},setpts='max(0,{_tree(pieces, at)})/TB',{fps},{end}\n"


def _sharp(slope: float) -> str:
    """Write a slope, which a long piece multiplies, with more digits than a time."""
    return f"{slope:.17f}".rstrip("0").rstrip(".")


def _tree(pieces: list[str], at: list[float]) -> str:
    """Choose the piece by halves; `at` holds where each begins."""
    if len(pieces) == 1:
        return pieces[0]
    half = len(pieces) // 2
    return f"if(lt(T,{plain(at[half])}),{_tree(pieces[:half], at[:half])},{_tree(pieces[half:], at[half:])})"


def read(data: bytes, shot: Shot) -> Warp:
    """Read the pieces of a chain that `write` made, to compare them."""
    text = decoded(data)
    end = _END.search(text)
    pieces = _PIECE.findall(text)
    if end is None or not pieces:
        raise FormatError("expected a chain of filters that retime wrote")
    use, at, slopes = (np.array([number(word) for word in column]) for column in zip(*pieces, strict=True))
    last_in = number(end[1]) - 0.5 / float(shot.exact_rate)
    last_out = use[-1] + (last_in - at[-1]) * slopes[-1]
    return warp_of([*use, last_out], [*at, last_in])
