"""Where a camera stands and looks, of clips that are one."""

from __future__ import annotations

import re

import numpy as np

from retime.arrays import FloatArray
from retime.motion import rotation
from retime.motion.any_motion import AnyMotion
from retime.motion.kinematics import global_poses, metres_per_unit
from retime.motion.motion import Motion
from retime.motion.signal import Signal

# Of a lens nobody speaks of: as high as a normal one sees, degrees; and the height of a film that its length is told
# for, millimetres.
_USUAL_VIEW, _FILM = 40.0, 24.0
_METRES = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254, "inch": 0.0254, "ft": 0.3048}
_PLACES = ("tx,ty,tz", "x,y,z", "posx,posy,posz", "positionx,positiony,positionz", "translatex,translatey,translatez",
           "locationx,locationy,locationz", "px,py,pz")  # fmt: skip
# Angles, and the order that they are applied in, the last first; quaternions.
_TURNS = (
    ("rz,ry,rx", "ZYX"), ("rotatez,rotatey,rotatex", "ZYX"), ("rotationz,rotationy,rotationx", "ZYX"),
    ("rotz,roty,rotx", "ZYX"), ("pan,tilt,roll", "YXZ"), ("yaw,pitch,roll", "YXZ"), ("pan,tilt", "YX"),
    ("yaw,pitch", "YX"), ("qw,qx,qy,qz", ""), ("rotw,rotx,roty,rotz", ""),
)  # fmt: skip
_WORD = re.compile(r"(?<![a-z])cam(era)?(?![a-z])")


def camera_path(clip: AnyMotion, *, unit: float = 1.0) -> FloatArray | None:
    """Return where a camera is, where it looks, and how much it sees, in every frame; None where a clip is none.

    A signal is a camera where it has channels for a place (``tx``, ``ty``, ``tz``; ``pos_x`` ...; ``location.x`` ...)
    and for a direction: ``rx``, ``ry``, ``rz`` (degrees unless the channel says radians; turned about X first, then Y,
    then Z), ``pan``, ``tilt`` and ``roll``, or a quaternion ``qw``, ``qx``, ``qy``, ``qz``. What stands before them, as
    in ``cam1_tx``, does not count. ``fov`` (degrees, from the lower edge to the upper) or ``focal`` (millimetres) may
    stand beside. A motion is one where it has at most three joints, one of which is called a camera. A camera looks
    along its own -Z, and Y is up.

    Parameters
    ----------
    clip : Motion or Signal
        The clip.
    unit : float
        Metres of a unit of a signal whose channels say none.

    Returns
    -------
    float array, shape (n_frames, 8), or None
        Place (metres, Y up), rotation (wxyz), and view from the lower edge to the upper (degrees).

    Examples
    --------
    >>> still = Signal(("cam_tx", "cam_ty", "cam_tz", "cam_pan", "cam_tilt"), np.ones((2, 5)) * [0, 1.5, 4, 90, 0], 30)
    >>> camera_path(still)[0].round(2).tolist()
    [0.0, 1.5, 4.0, 0.71, 0.0, 0.71, 0.0, 40.0]
    """
    found = _of_motion(clip) if isinstance(clip, Motion) else _of_signal(clip, unit)
    return found if found is None or np.isfinite(found).all() else None


def _of_motion(clip: Motion) -> FloatArray | None:
    names = clip.skeleton.names
    joint = next((i for i, name in enumerate(names) if _is_camera(name)), None)
    if joint is None or len(names) > 3:
        return None
    poses = global_poses(clip)
    return _path(poses.positions[:, joint] * metres_per_unit(clip), poses.rotations[:, joint], None)


def _is_camera(name: str) -> bool:
    # Capitals begin words, and so does what is no letter.
    return _WORD.search(re.sub(r"(?<=[a-z])(?=[A-Z])", " ", name).lower()) is not None


def _of_signal(clip: Signal, unit: float) -> FloatArray | None:
    plain = [re.sub(r"[^a-z]", "", re.sub(r"^.*(cam(era)?\d*)[^a-z]+", "", name.lower())) for name in clip.names]

    def columns(text: str) -> list[int] | None:
        wanted = text.split(",")
        # A name that stands there twice tells nothing.
        return [plain.index(name) for name in wanted] if all(plain.count(name) == 1 for name in wanted) else None

    place = next(filter(None, map(columns, _PLACES)), None)
    turn = next(((found, order) for text, order in _TURNS if (found := columns(text)) is not None), None)
    if place is None or turn is None:
        return None
    said = clip.kinds[place[0]].unit.lower()
    positions = clip.values[:, place] * _METRES.get(said, unit)
    found, order = turn
    if order == "":
        length = np.linalg.norm(clip.values[:, found], axis=1)
        if not (length > 1e-9).all():
            return None
        rotations = clip.values[:, found] / length[:, None]
    else:
        angles = clip.values[:, found]
        rotations = rotation.from_euler(order, angles if clip.kinds[found[0]].unit == "rad" else np.radians(angles))
    view: FloatArray | None = None
    for text in ("fov", "vfov", "focal", "focallength"):
        lens = columns(text)
        if lens is None:
            continue
        value = clip.values[:, lens[0]]
        if (value > 0).all():
            view = 2 * np.degrees(np.arctan(_FILM / 2 / value)) if text.startswith("focal") else value
            break
    return _path(positions, rotations, view)


def _path(positions: FloatArray, rotations: FloatArray, view: FloatArray | None) -> FloatArray:
    seen = np.full(len(positions), _USUAL_VIEW) if view is None else np.clip(view, 1.0, 170.0)
    return np.concatenate([positions, rotations, seen[:, None]], axis=1)
