"""Small pictures of motions, signals and contacts for notebooks."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from retime.arrays import FloatArray
from retime.motion.flights import flights
from retime.motion.kinematics import global_poses
from retime.svg import INKS, Panel, facts_html, stacked, thinned

if TYPE_CHECKING:
    from retime.motion.contacts import Contacts
    from retime.motion.motion import Motion
    from retime.motion.signal import Signal

_POSES, _CELL, _HEIGHT, _MARGIN = 12, 66, 120, 8
_CHANNELS = len(INKS)


def motion_html(motion: Motion) -> str:
    """Return even poses of a motion, seen from beside its way, and what it holds."""
    facts: dict[str, object] = {"motion": motion.name} if motion.name else {}
    facts |= {
        "frames": motion.n_frames,
        "rate": f"{motion.rate} Hz",
        "joints": motion.skeleton.n_joints,
        "up": motion.up,
        "flights": len(flights(motion)),
    }
    return stacked(_poses_svg(motion), facts_html(facts))


def _poses_svg(motion: Motion) -> str:
    frames = np.unique(np.linspace(0, motion.n_frames - 1, min(_POSES, motion.n_frames)).round().astype(int))
    poses = global_poses(motion.at(frames / float(motion.rate)))
    nodes = np.concatenate([poses.positions, poses.end_positions], axis=1)
    # Heights stay, so that a jump is seen; the way over the ground goes, so that each pose has its own place.
    right = (nodes - poses.positions[:, :1])[:, :, [0, 2]] @ _way(motion)
    height = nodes[:, :, 1] - nodes[:, :, 1].min()
    extent = max(float(height.max()), float(np.ptp(right)) * (_HEIGHT / _CELL), 1e-12)
    scale = (_HEIGHT - 2 * _MARGIN) / extent
    parents = [*motion.skeleton.parents, *(site.parent for site in motion.skeleton.end_sites)]
    parts = []
    for i, frame in enumerate(frames):
        x = (i + 0.5) * _CELL + right[i] * scale
        y = _HEIGHT - _MARGIN - height[i] * scale
        bones = "".join(
            f"M{x[parent]:.1f},{y[parent]:.1f}L{x[joint]:.1f},{y[joint]:.1f}"
            for joint, parent in enumerate(parents)
            if parent >= 0
        )
        # A lone joint has no bone; a round end makes it a dot.
        bones = bones or f"M{x[0]:.1f},{y[0]:.1f}h0"
        parts.append(
            f'<path d="{bones}" fill="none" stroke="{INKS[0]}" stroke-width="2" stroke-linecap="round"/>'
            f'<text x="{(i + 0.5) * _CELL:.1f}" y="{_HEIGHT + 12}" text-anchor="middle">'
            f"{frame / float(motion.rate):.2f} s</text>"
        )
    width, tall = len(frames) * _CELL, _HEIGHT + 18
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{tall}" viewBox="0 0 {width} {tall}" '
        f'font-family="sans-serif" font-size="10" fill="#475569" role="img">'
        f'<rect width="{width}" height="{tall}" fill="white"/>{"".join(parts)}</svg>'
    )


def _way(motion: Motion) -> FloatArray:
    """Return the direction over the ground (x, z) in which the root goes farthest; x for one that stays."""
    root = motion.positions[:, 0][:, [0, 2]]
    away = root - root[0]
    farthest = away[np.argmax(np.sum(away * away, axis=1))]
    length = float(np.hypot(*farthest))
    return farthest / length if length > 1e-9 else np.array([1.0, 0.0])


def signal_html(signal: Signal) -> str:
    """Return the first channels of a signal, each scaled to its own range, and what it holds."""
    times = np.arange(signal.n_frames) / float(signal.rate)
    kept = thinned(signal.n_frames)
    panel = Panel("values", 0.0, float(times[-1]), 0.0, 1.0, of="s")
    for channel in range(min(_CHANNELS, len(signal.names))):
        values = signal.values[:, channel]
        low, high = float(values.min()), float(values.max())
        share = (values - low) / (high - low) if high > low else np.full(len(values), 0.5)
        panel.line(times[kept], share[kept], ink=INKS[channel])
    panel.legend(signal.names[:_CHANNELS])
    n_channels = len(signal.names)
    drawn = f"; the first {_CHANNELS} are drawn" if n_channels > _CHANNELS else ""
    facts: dict[str, object] = {"signal": signal.name} if signal.name else {}
    facts |= {
        "frames": signal.n_frames,
        "rate": f"{signal.rate} Hz",
        "channels": f"{n_channels}, each in its own range{drawn}",
    }
    return stacked(panel.svg(), facts_html(facts))


def contacts_html(contacts: Contacts) -> str:
    """Return when each foot stands, as bars over time."""
    rate = float(contacts.rate)
    n_feet = len(contacts.feet)
    panel = Panel("feet that stand", 0.0, contacts.n_frames / rate, -0.5, max(n_feet, 1) - 0.5, of="s")
    for foot, point in enumerate(contacts.feet):
        panel.rule(foot, f"joint {point.joint}" if point.end_site is None else f"end {point.end_site}")
    spans = contacts.spans()
    for span in spans:
        panel.bar(span.first_frame / rate, (span.last_frame + 1) / rate, span.foot, ink=INKS[span.foot % len(INKS)])
    return stacked(panel.svg(), facts_html({"feet": n_feet, "contacts": len(spans), "frames": contacts.n_frames}))
