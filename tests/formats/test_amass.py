"""Archives of SMPL bodies: read as motions, retimed in place."""

from __future__ import annotations

import io
import warnings
import zipfile
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation, Slerp

from retime.errors import FormatError, FormatWarning, RetimeWarning
from retime.formats import amass
from retime.formats.in_place import retime_file
from retime.formats.read_options import Limits, ReadOptions
from retime.formats.registry import facts_of, format_in, read, stays_in_place, write
from retime.formats.smpl_body import BODIES
from retime.motion import rotation
from retime.motion.motion import Motion
from retime.motion.signal import Signal
from retime.warp.curve import Warp
from tests.formats.body_files import body, npz, smplx

PATH = Path("walk_poses.npz")
PLAIN = ReadOptions()


def members_of(data: bytes) -> dict[str, np.ndarray]:
    with np.load(io.BytesIO(data), allow_pickle=False) as archive:
        return {name: archive[name] for name in archive.files}


def raw_of(data: bytes) -> dict[str, bytes]:
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        return {member.filename: archive.read(member) for member in archive.infolist()}


def retimed(data: bytes, warp: Warp, options: ReadOptions = PLAIN, **more: Any) -> bytes:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RetimeWarning)
        return amass.retime_frames(PATH, data, warp, options, **more)


@pytest.mark.parametrize(
    ("joints", "title"), [(22, "SMPL without hands"), (24, "SMPL"), (52, "SMPL+H"), (55, "SMPL-X")]
)
def test_a_body_is_a_motion(joints: int, title: str) -> None:
    members = body(3, joints=joints)
    motion = amass.read(PATH, npz(members), PLAIN)
    assert (motion.skeleton.n_joints, motion.rate, motion.up, motion.metres_per_unit) == (joints, 60, "z", 1.0)
    turned = Rotation.from_rotvec(members["poses"].reshape(-1, 3)).as_matrix()
    np.testing.assert_allclose(rotation.to_matrix(motion.rotations).reshape(-1, 3, 3), turned, atol=1e-12)
    assert np.array_equal(motion.local_translations[:, 0], members["trans"])
    assert amass.facts(PATH, npz(members), PLAIN)["body"].startswith(f"{title}, {joints} joints")
    flat = amass.read(PATH, npz(members | {"poses": members["poses"].reshape(-1, joints, 3)}), PLAIN)
    assert np.array_equal(flat.rotations, motion.rotations)


@pytest.mark.parametrize("body_kind", BODIES.values(), ids=lambda one: one.title)
def test_the_skeleton_is_alike_on_both_sides_and_stands(body_kind) -> None:
    skeleton = body_kind.skeleton
    for joint, name in enumerate(skeleton.names):
        if name.startswith("left"):
            other = skeleton.index(name.replace("left", "right", 1))
            assert skeleton.offsets[other].tolist() == (skeleton.offsets[joint] * [-1, 1, 1]).tolist()
            parents = [skeleton.names[skeleton.parents[i]].replace("left", "right") for i in (joint, other)]
            assert parents[0] == parents[1]
    heights = np.zeros(skeleton.n_joints)
    for joint, parent in enumerate(skeleton.parents):
        heights[joint] = skeleton.offsets[joint, 1] + (heights[parent] if parent >= 0 else 0)
    tall = heights.max() - heights.min() + 0.17
    assert 1.5 < tall < 1.8
    # Every joint without children has an end, but for the eyes and the jaw.
    leaves = set(range(skeleton.n_joints)) - set(skeleton.parents) - {site.parent for site in skeleton.end_sites}
    assert {skeleton.names[joint] for joint in leaves} <= {
        *("jaw", "left_eye_smplhf", "right_eye_smplhf", "left_wrist", "right_wrist")
    }


@pytest.mark.parametrize("dtype", ["<f4", ">f8", "<f8"])
@pytest.mark.parametrize("seed", range(4))
def test_poses_are_blended_on_the_sphere(dtype: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    members = body(seed, dtype=dtype, joints=(22, 24, 52, 55)[seed])
    outputs = np.cumsum([0, *rng.uniform(0.05, 0.4, 5)])
    warp = Warp(outputs, [0.0, 0.3, 0.3, 0.1, 0.5, 39 / 60])
    new = members_of(retimed(npz(members), warp, average=False))
    n_frames = warp.count_frames(60)
    times = np.append(outputs[0] + np.arange(n_frames - 1) / 60, outputs[-1])
    shown, frames = np.interp(times, outputs, warp.input_times), np.arange(40) / 60
    # The times of frames themselves are not always between the first and the last of them, to the last digit.
    shown = np.clip(shown, 0, frames[-1])
    vectors = new["poses"].reshape(n_frames, -1, 3)
    slack = 1e-5 if dtype == "<f4" else 1e-9
    for joint in range(vectors.shape[1]):
        old = members["poses"].astype("f8")[:, 3 * joint : 3 * joint + 3]
        expected = Slerp(frames, Rotation.from_rotvec(old))(shown)
        away = (expected.inv() * Rotation.from_rotvec(vectors[:, joint].astype("f8"))).magnitude()
        assert away.max() < slack
        # Neighbours mean the same turn: nothing jumps by a whole one.
        assert np.abs(np.diff(vectors[:, joint], axis=0)).max() < 2.0
    assert vectors[:, 0].max() > np.pi
    for name in ("trans", "dmpls"):
        for column in range(members[name].shape[1]):
            expected_values = np.interp(shown, frames, members[name][:, column].astype("f8"))
            np.testing.assert_allclose(new[name][:, column], expected_values, atol=slack * 10)
    assert {name: new[name].dtype.str for name in new} == {
        name: (value.dtype.str if value.dtype.byteorder != ">" else dtype) for name, value in members.items()
    }


@pytest.mark.parametrize("make", [body, smplx])
def test_all_else_stays_to_the_byte(make) -> None:
    more = {"labels": np.array(["a", "b"]), "markers_latent": np.ones((41, 3)), "note": np.array("40 frames")}
    members = make(1, **more)
    old = npz(members, compressed=True)
    new = retimed(old, Warp([0.0, 1.3], [0.0, 0.65]))
    before, after = raw_of(old), raw_of(new)
    assert list(after) == list(before)
    kept = {"betas", "gender", "labels", "markers_latent", "note", "mocap_framerate", "mocap_frame_rate"}
    kept |= {"num_betas", "surface_model_type"}
    for name, content in before.items():
        assert (after[name] == content) == (name.removesuffix(".npy") in kept), name
    assert all(zipfile.ZipFile(io.BytesIO(new)).getinfo(name).compress_type == zipfile.ZIP_DEFLATED for name in after)
    if make is smplx:
        arrays = members_of(new)
        assert float(arrays["mocap_time_length"]) == pytest.approx(79 / 60)
        for name, (start, stop) in {"root_orient": (0, 3), "pose_body": (3, 66), "pose_hand": (75, 165)}.items():
            assert np.array_equal(arrays[name], arrays["poses"][:, start:stop])


def test_a_warp_that_changes_nothing_changes_no_array() -> None:
    old = npz(smplx(2))
    assert raw_of(retimed(old, Warp([0.0, 39 / 60], [0.0, 39 / 60]))) == raw_of(old)


def test_frames_are_those_of_the_motion_sped_up_and_averaged() -> None:
    import retime

    data = npz(body(5, n_frames=91))
    warp = Warp([0.0, 0.5], [0.0, 1.5])
    new = retimed(data, warp)
    shown = retime.apply_warp(amass.read(PATH, data, PLAIN), warp)
    again = amass.read(PATH, new, PLAIN)
    np.testing.assert_allclose(np.abs(np.sum(shown.rotations * again.rotations, axis=-1)), 1.0, atol=1e-12)
    np.testing.assert_allclose(again.local_translations, shown.local_translations, atol=1e-12)
    # Three times as fast, a window reaches one frame to both sides.
    old, averaged = members_of(data)["dmpls"], members_of(new)["dmpls"]
    expected = old[2:-2:3] / 4 + old[3:-1:3] / 2 + old[4::3] / 4
    np.testing.assert_allclose(averaged[1:-1], expected, atol=1e-12)
    held = members_of(retimed(data, warp, held=2))
    assert np.array_equal(held["poses"][:-1:2], held["poses"][1::2])
    assert np.array_equal(held["dmpls"][0], held["dmpls"][1])


def test_arrays_of_other_kinds() -> None:
    n_frames = 40
    more = {
        "frame_ids": np.arange(n_frames),
        "seen": np.arange(n_frames) % 2 == 0,
        "words": np.array([f"w{i // 10}" for i in range(n_frames)]),
        "left_contact": (np.arange(n_frames) // 10 % 2).astype("f4"),
        "markers": np.asfortranarray(np.random.default_rng(0).normal(size=(n_frames, 5, 3))),
        "global_orient": np.column_stack([np.zeros((n_frames, 2)), np.linspace(3, 9, n_frames)]),
        "rows": np.zeros((n_frames, 0)),
        "far": np.full(n_frames, np.inf),
    }
    more["markers"][10:12, 2] = np.nan
    new = members_of(retimed(npz(body(1, **more)), Warp([0.0, 1.3], [0.0, 0.65])))
    assert new["frame_ids"].dtype == np.int64
    assert set(new["frame_ids"]) == set(range(40))
    assert np.all(np.diff(new["frame_ids"]) >= 0)
    assert new["seen"].dtype == np.bool_
    assert set(new["words"]) == {"w0", "w1", "w2", "w3"}
    assert set(new["left_contact"]) == {0.0, 1.0}
    assert new["markers"].shape == (79, 5, 3)
    np.testing.assert_allclose(new["markers"][::2], more["markers"])
    assert np.isnan(new["markers"][19:24, 2]).all()
    # Beyond half a turn, turns go on.
    np.testing.assert_allclose(new["global_orient"][:, 2], np.linspace(3, 9, 79), atol=1e-9)
    assert new["rows"].shape == (79, 0)
    assert np.isinf(new["far"]).all()
    assert len(new["far"]) == 79


def test_objects_are_kept_and_never_loaded() -> None:
    class Bomb:
        def __reduce__(self) -> tuple[Any, ...]:
            return (pytest.fail, ("unpickled",))

    objects, few = np.empty(40, dtype=object), np.empty(3, dtype=object)
    objects[:], few[:] = [Bomb()] * 40, [Bomb()] * 3
    data = npz(body(1, labels_obs=objects, notes=few))
    assert format_by_claim(data)
    with pytest.warns(FormatWarning, match="labels_obs holds no plain numbers and is kept as it is"):
        new = amass.retime_frames(PATH, data, Warp([0.0, 0.325], [0.0, 0.65]), PLAIN)
    assert raw_of(new)["labels_obs.npy"] == raw_of(data)["labels_obs.npy"]
    assert raw_of(new)["notes.npy"] == raw_of(data)["notes.npy"]


def format_by_claim(data: bytes) -> bool:
    return amass.claims(io.BytesIO(data))


@pytest.mark.parametrize(
    ("members", "claimed"),
    [
        (body(), True),
        (body(joints=22), True),
        ({"poses": np.zeros((5, 156))}, False),
        ({"poses": np.zeros((5, 157)), "trans": np.zeros((5, 3))}, False),
        ({"poses": np.zeros((5, 63)), "trans": np.zeros((5, 3))}, False),
        ({"smpl_poses": np.zeros((5, 72)), "smpl_trans": np.zeros((5, 3))}, True),
        ({"values": np.zeros((5, 156)), "rate": np.array(30)}, False),
    ],
)
def test_what_is_taken_for_a_body(members: dict[str, Any], claimed: bool) -> None:
    assert format_by_claim(npz(members)) is claimed


def test_what_is_no_archive_is_not_claimed() -> None:
    data = npz(body())
    assert not any(format_by_claim(part) for part in (b"", b"PK", data[:5000], b"\0" * 100))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"trans": np.zeros((39, 3))}, r"trans have shape \(39, 3\); expected \(40, 3\)"),
        ({"mocap_framerate": np.array(0.0)}, "mocap_framerate: "),
        ({"mocap_framerate": np.array([1.0, 2.0])}, "expected one number"),
        ({"poses": np.full((40, 156), np.nan)}, "the rotation of joint 0 at frame 0 is not a number"),
        ({"poses": np.full((40, 156), 1e7)}, "poses are rotation vectors"),
        ({"trans": np.full((40, 3), 1e200)}, "the translation of joint 'pelvis' at frame 0"),
        ({"poses": np.zeros((0, 156)), "trans": np.zeros((0, 3))}, r"poses have shape \(0, 156\)"),
    ],
)
def test_damage_is_named(change: dict[str, Any], message: str) -> None:
    with pytest.raises(FormatError, match=message):
        amass.read(PATH, npz(body() | change), PLAIN)


def test_poses_alone_tell_no_body() -> None:
    data = npz({"poses": body()["poses"]})
    assert not amass.claims(io.BytesIO(data))
    with pytest.raises(FormatError, match="tells no body: it has none of trans"):
        amass.read(PATH, data, PLAIN)


def test_limits_and_rates() -> None:
    members = body()
    del members["mocap_framerate"]
    with pytest.raises(FormatError, match="holds no rate"):
        amass.read(PATH, npz(members), PLAIN)
    assert amass.read(PATH, npz(members), ReadOptions(rate=Fraction(25))).rate == 25
    with pytest.raises(FormatError, match=r"Limits\.frames"):
        amass.read(PATH, npz(body()), ReadOptions(limits=Limits(frames=39)))
    with pytest.raises(FormatError, match=r"Limits\.joint_poses"):
        amass.read(PATH, npz(body()), ReadOptions(limits=Limits(joint_poses=2000)))
    # A rate that is corrected is written where the file has its own, in its own type.
    warp = Warp([0.0, 0.3], [0.0, 0.6])
    for array, expected in ((np.array(60), 30), (np.array("60/1"), "30"), (np.array(60.0, dtype="f4"), 30.0)):
        new = members_of(retimed(npz(body(mocap_framerate=array)), warp, ReadOptions(rate=Fraction(30))))
        assert new["mocap_framerate"] == expected
    with pytest.raises(FormatError, match="as a whole number, which 60000/1001 is not"):
        retimed(npz(body(mocap_framerate=np.array(60))), warp, ReadOptions(rate=Fraction(60000, 1001)))


def test_part_of_a_take() -> None:
    members = body()
    new = members_of(retimed(npz(members), Warp([0.0, 19 / 60], [0.0, 19 / 60]), frames=(10, 29)))
    for name in ("poses", "trans", "dmpls"):
        assert np.array_equal(new[name], members[name][10:30])


def test_by_the_registry(tmp_path: Path) -> None:
    source, place = tmp_path / "a.npz", tmp_path / "b.npz"
    source.write_bytes(npz(body()))
    assert format_in(source).name == "amass"
    assert format_in(source, arrays=["poses"]).name == "npy"
    assert stays_in_place(source, place) is not None
    assert stays_in_place(source, place, arrays=["poses"]) is None
    assert isinstance(read(source), Motion)
    arrays = read(source, array=["poses", "trans"])
    assert isinstance(arrays, Signal)
    assert len(arrays.names) == 159
    retime_file(source, place, Warp([0.0, 0.325], [0.0, 0.65]))
    assert read(place).n_frames == 20 + 1
    with pytest.raises(FormatError, match=r"a \.npz file holds a signal, not a motion"):
        write(read(source), tmp_path / "c.npz")
    assert facts_of(source, PLAIN)["gender"] == "neutral"
    # Packed, it is told by what is in it too.
    import gzip

    (tmp_path / "a.npz.gz").write_bytes(gzip.compress(npz(body())))
    assert format_in(tmp_path / "a.npz.gz").name == "amass"


@pytest.mark.parametrize("suffix", [".pkl", ".pickle", ".pt", ".pth"])
def test_pickled_files_are_refused_with_the_line_that_converts_them(tmp_path: Path, suffix: str) -> None:
    with pytest.raises(FormatError) as refused:
        read(tmp_path / f"walk{suffix}")
    line = str(refused.value).split("its arrays: ")[1]
    assert line.startswith('python -c "import ')
    assert f"'walk{suffix}'" in line
    assert "numpy.savez('walk.npz'" in line
    with pytest.raises(FormatError) as refused:
        read(tmp_path / f"a'); import os; ('{suffix}")
    assert "import os" not in str(refused.value).split("its arrays: ")[1]


def test_the_line_converts(tmp_path: Path, monkeypatch) -> None:
    import pickle
    import shlex
    import subprocess
    import sys

    monkeypatch.chdir(tmp_path)
    with Path("walk.pkl").open("wb") as file:
        pickle.dump(body(), file)
    with pytest.raises(FormatError) as refused:
        read("walk.pkl")
    command = shlex.split(str(refused.value).split("its arrays: ")[1])
    subprocess.run([sys.executable, *command[1:]], check=True)
    assert isinstance(read("walk.npz"), Motion)


def test_made_up_captures(mocap: Path) -> None:
    for name, joints in (("synthetic_smplh_poses", 52), ("synthetic_smplx_stageii", 55)):
        motion = read(mocap / f"amass/{name}.npz")
        assert isinstance(motion, Motion)
        assert (motion.skeleton.n_joints, motion.rate) == (joints, 120)
