"""Animated skeletons for a page that stands alone: the poses as data, and the script that plays them."""

from __future__ import annotations

import base64
import importlib.resources
import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from retime.arrays import FloatArray
from retime.evaluate.metrics import ANALYSIS_RATE
from retime.evaluate.metrics.spans import output_intervals
from retime.evaluate.plot.stick_figure import HEAD_RADIUS, view_of
from retime.evaluate.plot.strip import in_flight
from retime.motion.kinematics import global_poses, metres_per_unit
from retime.motion.motion import Motion
from study.evaluations.evaluation import Evaluation, Version
from study.signals.camera import CameraResult

# Poses a second in the page; the script draws straight lines between them.
_RATE = ANALYSIS_RATE
# Metres a unit of the stored whole numbers.
_GRAIN = 0.001


def player_html(evaluation: Evaluation) -> str:
    """Write an evaluation's versions as a player: a place in the page, and its data.

    The page must hold `player_script` once, after all players.
    """
    return _html(evaluation.key, player_data(evaluation))


def player_script() -> str:
    """Return the script that brings the players of a page to life."""
    return importlib.resources.files("study.report").joinpath("player.js").read_text(encoding="utf-8")


def player_data(evaluation: Evaluation) -> dict[str, Any]:
    """Collect what a player needs: the skeleton's lines, and each version's poses, speeds and flights.

    Returns
    -------
    dict
        ``rate`` (poses a second), ``grain`` (metres a unit of the stored numbers), ``chains`` (side and nodes of each
        line), ``head`` (node and radius in metres), ``heading`` (radians: where the figure faces, seen from above) and
        ``versions``.
    """
    figure, used, start = _figure_data(evaluation.motion)
    versions = [_version_data(version, evaluation, used, start) for version in evaluation.versions]
    return figure | {"key": evaluation.key, "versions": versions}


def camera_player_html(result: CameraResult) -> str:
    """Write a player that looks at a warped figure through its camera, warped with it and left as it was."""
    motion = result.motion
    figure, used, start = _figure_data(motion)
    shown = {"seconds": motion.end_time, **_poses_data(motion, used, start)}
    views = [
        ("camera warped with the figure", "by the same warp", result.shown),
        ("camera as it was", "what goes wrong otherwise", result.left),
    ]
    versions = []
    for label, note, camera in views:
        times = np.minimum(_pose_times(motion), (camera.n_frames - 1) / float(camera.rate))
        places = camera.at(times).values * metres_per_unit(motion) - np.tile(start, 2)
        versions.append({"label": label, "note": note, **shown, "camera": np.round(places, 3).tolist()})
    return _html("camera", figure | {"key": "camera", "versions": versions})


def _html(key: str, data: Mapping[str, Any]) -> str:
    text = json.dumps(data, separators=(",", ":")).replace("</", "<\\/")
    return (
        f'<div class="player" data-key="{key}"><noscript>The animation needs JavaScript.</noscript>'
        f'<script type="application/json">{text}</script></div>'
    )


def _figure_data(motion: Motion) -> tuple[dict[str, Any], list[int], FloatArray]:
    """Collect what all versions share; and which nodes are drawn, and where on the ground they are counted from."""
    view = view_of(motion)
    scale = metres_per_unit(motion)
    used = sorted({node for chain in view.chains for node in chain.nodes} | ({view.head} if view.head >= 0 else set()))
    place = {node: i for i, node in enumerate(used)}
    across = view.across.mean(axis=0)
    start = node_places(motion, np.zeros(1))[0, 0] * [1.0, 0.0, 1.0]
    figure = {
        "rate": _RATE,
        "grain": _GRAIN,
        "chains": [[chain.side, [place[node] for node in chain.nodes]] for chain in view.chains],
        "head": [place[view.head], HEAD_RADIUS * view.stature * scale] if view.head >= 0 else None,
        "heading": float(np.arctan2(across[1], across[0])),
        "ground": view.ground * scale,
        "nodes": len(used),
    }
    return figure, used, start


def _pose_times(motion: Motion) -> FloatArray:
    return np.append(np.arange(int(np.ceil(motion.end_time * _RATE - 1e-6))) / _RATE, motion.end_time)


def _poses_data(motion: Motion, used: Sequence[int], start: FloatArray) -> dict[str, Any]:
    places = node_places(motion, _pose_times(motion))[:, used] - start
    return {"poses": base64.b64encode(_whole(places)).decode("ascii"), "count": len(places)}


def _version_data(version: Version, evaluation: Evaluation, used: Sequence[int], start: FloatArray) -> dict[str, Any]:
    motion = version.motion
    times = _pose_times(motion)
    data: dict[str, Any] = {
        "label": version.label,
        "note": version.note,
        "seconds": motion.end_time,
        **_poses_data(motion, used, start),
    }
    if version.warp is not None:
        # The speed that is seen between one pose and the next, and whether the input is in flight then.
        change = np.diff(version.warp(np.append(times, times[-1] + 1 / _RATE)))
        length = np.diff(np.append(times, times[-1] + 1 / _RATE))
        data["speeds"] = np.round(change / length, 3).tolist()
        data["speeds"][-1] = data["speeds"][-2] if len(times) > 1 else 1.0
        shown = [part for span in evaluation.flights for part in output_intervals(version.warp, *span)]
        data["flights"] = [[round(start, 3), round(end, 3)] for start, end in shown]
        data["aloft"] = in_flight(times, tuple(shown)).astype(int).tolist()
    elif version.label == "input":
        data["speeds"] = [1.0] * len(times)
        data["flights"] = [[round(start, 3), round(end, 3)] for start, end in evaluation.flights]
        data["aloft"] = in_flight(times, evaluation.flights).astype(int).tolist()
    return data


def node_places(motion: Motion, times: FloatArray) -> FloatArray:
    """Places of joints and end sites at some times, metres; shape (n_times, n_joints + n_end_sites, 3)."""
    poses = global_poses(motion.at(times))
    return np.concatenate([poses.positions, poses.end_positions], axis=1) * metres_per_unit(motion)


def _whole(places: FloatArray) -> bytes:
    """Write places as whole millimetres, two bytes each, little-endian: up to 32 m from where the input starts."""
    return np.clip(np.round(places / _GRAIN), -32767, 32767).astype("<i2").tobytes()
