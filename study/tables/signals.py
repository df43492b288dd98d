"""One warp for a camera and a curve, and a guided warp of a signal."""

from __future__ import annotations

from retime.evaluate.metrics.flights import FlightTiming
from study.signals.ball import SignalResult
from study.signals.camera import CameraResult
from study.signals.curve import CurveResult
from study.tables.table import Table


def signals_table(camera: CameraResult, curve: CurveResult, ball: SignalResult) -> Table:
    """One warp for a camera, and a guided warp of a signal."""
    rows = (
        ("camera aim off by, before", f"{camera.before:.2f}°", "camera and figure as made"),
        (
            "… both warped by one warp",
            f"{camera.together:.2f}°",
            f"{camera.n_input} to {camera.n_output} frames, 24 Hz",
        ),
        ("… the figure alone warped", f"{camera.motion_alone:.1f}°", "what goes wrong otherwise"),
        (
            "curve of the root's height off by, warped by the same warp",
            f"{curve.together * 1000:.1f} mm",
            f"{curve.n_input} to {curve.n_output} samples, 50 Hz",
        ),
        ("… the figure alone warped", f"{curve.motion_alone * 1000:.0f} mm", "what goes wrong otherwise"),
        ("ball, guided: flight frames kept", _kept(ball.timing), f"gravity {ball.gravity:.2f} × 9.81 m/s²"),
        (
            "ball, linear: flight frames kept",
            _kept(ball.linear_timing),
            f"gravity {ball.linear_gravity:.2f} × 9.81 m/s²",
        ),
    )
    return Table(("what", "value", "note"), rows, numbers_from=3)


def _kept(timing: FlightTiming) -> str:
    return f"{timing.n_kept} of {timing.n_frames}"
