"""Lottie: a layer that shows a precomposition by a time remap (``tm``).

``tm`` is animated: a key has its frame ``t`` in the composition, at the rate ``fr``, and ``s``, the second of the
precomposition that is shown. A key's handles ``o`` and ``i`` at (0, 0) and (1, 1) make a line to the next. The file is
a composition with an empty precomposition, to be filled, or to copy ``tm`` from.

Read are lines and Bezier handles, drawn by lines to within the tolerance.

Source: Lottie specification, layers, "Time Remapping"
(https://lottie.github.io/lottie-spec/latest/specs/layers/), and Keyframes.
"""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from retime.errors import FormatError
from retime.hosts.bezier import drawn
from retime.hosts.choosing import chosen
from retime.hosts.shot import MOST_KEYS, Shot, plain, warp_of
from retime.hosts.text import json_number
from retime.strict_json import parse_json
from retime.warp.curve import Warp


def write(warp: Warp, shot: Shot) -> str:
    """Write a composition."""
    rate = float(shot.exact_rate)
    name = shot.item or "clip"
    at = [float(plain(value)) for value in (warp.output_times * rate).tolist()]
    use = [float(plain(value)) for value in warp.input_times.tolist()]
    keys: list[dict[str, Any]] = [
        {"t": frame, "s": [second], "i": {"x": [1], "y": [1]}, "o": {"x": [0], "y": [0]}}
        for frame, second in zip(at, use, strict=True)
    ]
    keys[-1] = {"t": at[-1], "s": [use[-1]]}
    end = shot.first_frame(warp) + shot.count_frames(warp)
    layer = {
        "ty": 0,
        "nm": name,
        "ind": 1,
        "refId": name,
        "ip": shot.first_frame(warp),
        "op": end,
        "st": 0,
        "w": 1920,
        "h": 1080,
        "ks": {},
        "tm": {"a": 1, "k": keys},
    }
    document = {
        "v": "5.7.0",
        "nm": f"retimed {name}",
        "fr": rate,
        "ip": 0,
        "op": end,
        "w": 1920,
        "h": 1080,
        "assets": [{"id": name, "nm": name, "layers": []}],
        "layers": [layer],
    }
    return json.dumps(document, allow_nan=False) + "\n"


def read(data: bytes, shot: Shot) -> Warp:
    """Read the one time remap of a composition, or that of the layer or precomposition of the name `Shot.item`."""
    document = parse_json(data, what="a composition")
    if not isinstance(document, dict) or not isinstance(document.get("layers"), list):
        known = isinstance(document, dict) and document.get("format") == "retime-warp"
        hint = "; this is a warp of retime already" if known else ""
        raise FormatError(f"expected a composition of Lottie: a JSON object with layers{hint}")
    rate = json_number(document.get("fr"), "fr, the frames a second")
    if not 1e-6 <= rate <= 1e6:
        raise FormatError(f"fr: no composition has {rate:g} frames a second")
    assets = document.get("assets")
    levels = [document, *(asset for asset in (assets if isinstance(assets, list) else []) if isinstance(asset, dict))]
    found: dict[str, Any] = {}
    for level in levels:
        layers = level.get("layers")
        for layer in layers if isinstance(layers, list) else []:
            if isinstance(layer, dict) and "tm" in layer:
                name = str(layer.get("nm") or layer.get("refId") or f"layer {len(found) + 1}")
                found[name if name not in found else f"{name} ({len(found) + 1})"] = layer["tm"]
    return _remap(
        chosen(found, shot.item, "layer with a time remap (tm)", "a Lottie composition"), rate, shot.tolerance
    )


def _remap(remap: Any, rate: float, tolerance: float) -> Warp:
    """Make the warp of an animated property."""
    keys = remap.get("k") if isinstance(remap, dict) else None
    if isinstance(remap, dict) and "x" in remap:
        # Players work it out in the place of the keys.
        raise FormatError(
            "the time remap has an expression (x), whose times are not in the file: in After Effects choose "
            "Animation > Keyframe Assistant > Convert Expression to Keyframes, and export again"
        )
    if not isinstance(keys, list) or not all(isinstance(key, dict) for key in keys):
        raise FormatError("the time remap has no keys: it holds one moment, and a retime curve needs two or more")
    if len(keys) > MOST_KEYS:
        raise FormatError(f"more than {MOST_KEYS} keys")
    at = [json_number(key.get("t"), f"key {n}, t") / rate for n, key in enumerate(keys)]
    use = [_value(key, n, keys) for n, key in enumerate(keys)]
    lines = warp_of(at, use)
    out_times, in_times, curved = [lines.output_times[:1]], [lines.input_times[:1]], False
    for n, key in enumerate(keys[:-1]):
        t0, t1, v0, v1 = at[n], at[n + 1], use[n], use[n + 1]
        if key.get("h") == 1 and v0 != v1:
            raise FormatError(f"key {n} holds and then jumps from {v0:g} to {v1:g} s, which a warp can't")
        handles = [_handle(key.get(side), f"key {n}, {side}") for side in ("o", "i")]
        straight = key.get("h") == 1 or v0 == v1 or all(handle is None or handle[0] == handle[1] for handle in handles)
        if straight:
            out_times.append(np.array([t1]))
            in_times.append(np.array([v1]))
            continue
        (ox, oy), (ix, iy) = handles[0] or (0.0, 0.0), handles[1] or (1.0, 1.0)
        x = np.array([t0, t0 + ox * (t1 - t0), t0 + ix * (t1 - t0), t1])
        y = np.array([v0, v0 + oy * (v1 - v0), v0 + iy * (v1 - v0), v1])
        try:
            xs, ys = drawn(x, y, tolerance / 2, {})
        except FormatError as error:
            raise FormatError(f"key {n}: {error.problem}") from None
        out_times.append(xs)
        in_times.append(ys)
        curved = True
    return warp_of(np.concatenate(out_times), np.concatenate(in_times)).simplify(tolerance / 2) if curved else lines


def _value(key: dict[str, Any], n: int, keys: list[dict[str, Any]]) -> float:
    """Return the second that a key shows; the last one of an old file has it in the key before."""
    found = key.get("s")
    if found is None and n == len(keys) - 1 and n:
        found = keys[n - 1].get("e")
    if isinstance(found, list):
        found = found[0] if found else None
    return json_number(found, f"key {n}, s")


def _handle(found: Any, what: str) -> tuple[float, float] | None:
    """Return a handle, in parts of the span."""
    if found is None:
        return None
    if not isinstance(found, dict):
        raise FormatError(f"{what}: expected a handle with x and y")
    x, y = (value[0] if isinstance(value, list) and value else value for value in (found.get("x"), found.get("y")))
    return json_number(x, f"{what}.x"), json_number(y, f"{what}.y")
