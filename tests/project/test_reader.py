from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest

from retime.errors import FormatError, RetimeWarning
from retime.motion.signal import Signal
from retime.project.document import ClipFile, Document
from retime.project.faults import FaultyError
from retime.project.reader import Reader
from tests.formats.curves.gltf.scenes import skinned_scene


@pytest.fixture
def table(tmp_path: Path) -> str:
    rows = [f"{i / 10:.1f},{i},{'' if i == 4 else i}" for i in range(9)]
    (tmp_path / "table.csv").write_text("\n".join(["time,pan,x", *rows]))
    return str(tmp_path / "table.csv")


def clip_of(reader: Reader, file: ClipFile) -> Signal:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RetimeWarning)
        (clip,) = reader.read(Document((file,))).clips
    assert isinstance(clip, Signal)
    return clip


def test_a_document_says_what_channels_hold_and_what_to_do_about_gaps(table: str) -> None:
    reader = Reader()
    bridged = clip_of(reader, ClipFile(table, channels="p*=angle:rad", gaps="bridge"))
    assert [str(kind) for kind in bridged.kinds] == ["angle:rad", "linear"]
    assert bridged.values[4].tolist() == [4, 4]
    # Another way to read is another clip, though the file is the same.
    kept = clip_of(reader, ClipFile(table, gaps="keep", first_frame=2, last_frame=6))
    assert np.argwhere(kept.holes).tolist() == [[2, 1]]
    assert [str(kind) for kind in kept.kinds] == ["linear", "linear"]


@pytest.mark.parametrize(
    ("file", "says"),
    [
        ({}, "column 'x': expected a number, found nothing; --gaps bridge fills gaps"),
        ({"gaps": "fill"}, "gaps are 'bridge', 'bridge:SECONDS' or 'keep'; found 'fill'"),
        ({"gaps": "keep", "channels": "pan"}, "expected a channel and its kind"),
        ({"gaps": "keep", "channels": "tilt=angle"}, "table has no channel 'tilt'; there are pan, x"),
    ],
)
@pytest.mark.filterwarnings("ignore::retime.errors.RetimeWarning")
def test_what_can_not_be_read_so_is_blamed_on_the_clip(table: str, file: dict[str, str], says: str) -> None:
    with pytest.raises(FaultyError, match=says) as caught:
        Reader().read(Document((ClipFile(table, **file),)))
    assert caught.value.fault.clip == 0


def test_a_mesh_that_is_damaged_is_told_once_and_the_clip_is_read_all_the_same(tmp_path: Path) -> None:
    whole, broken = skinned_scene(1, 20), skinned_scene(1, 20)
    broken.json["meshes"][0]["primitives"] = {}
    for name, scene in (("whole", whole), ("broken", broken)):
        (tmp_path / f"{name}.glb").write_bytes(scene.glb())
    reader, document = Reader(), Document((ClipFile(str(tmp_path / "broken.glb")),))
    with pytest.warns(RetimeWarning, match="its mesh is not shown: .*one of primitives"):
        (skin,) = reader.read(document).skins
    assert skin is None
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = reader.read(document)
        assert found.clips[0].n_frames == 20
        (skin,) = Reader().read(Document((ClipFile(str(tmp_path / "whole.glb")),))).skins
    assert skin is not None


def test_a_file_that_was_tried_is_read_once_and_only_for_the_next_document(tmp_path: Path, table: str) -> None:
    (tmp_path / "whole.csv").write_text("time,x\n0,1\n0.1,2\n0.2,4\n0.3,7\n")
    asked: list[str] = []

    def find(text: str) -> Path:
        asked.append(text)
        return Path(text)

    reader = Reader(find)
    whole = ClipFile(str(tmp_path / "whole.csv"))
    reader.try_file(whole.path)
    assert clip_of(reader, whole).values[:, 0].tolist() == [1, 2, 4, 7]
    assert asked.count(whole.path) == 1
    # A document without it lets go of it.
    reader.try_file(str(tmp_path / "whole.csv"))
    clip_of(reader, ClipFile(table, gaps="keep"))
    asked.clear()
    clip_of(reader, whole)
    assert asked.count(whole.path) == 1


def test_a_file_that_only_lacks_words_passes_and_a_broken_one_does_not(tmp_path: Path, table: str) -> None:
    (tmp_path / "no_rate.csv").write_text("x\n1\n2\n4\n7\n")
    (tmp_path / "walk.amc").write_text(":DEGREES\n1\nroot 0 0 0 0 0 0\n")
    (tmp_path / "broken.csv").write_text("time,x\n0,1\n0.1,two\n0.2,3\n")
    (tmp_path / "walk.doc").write_text("a walk")
    reader = Reader()
    for name in ("table.csv", "no_rate.csv", "walk.amc"):
        reader.try_file(str(tmp_path / name), may_be_told=True)
        with pytest.raises(FormatError):
            reader.try_file(str(tmp_path / name))
    # Told, the first can be read; by itself it still can't.
    with pytest.raises(FaultyError, match=r"table\.csv"):
        reader.read(Document((ClipFile(table),)))
    (tmp_path / "walk.asf").write_text("no skeleton")
    for name, says in (
        ("broken.csv", r"broken\.csv:3"),
        ("walk.doc", "no format ends in"),
        ("walk.amc", r"walk\.asf"),
        ("gone.bvh", "No such file"),
    ):
        with pytest.raises((FormatError, OSError), match=says):
            reader.try_file(str(tmp_path / name), may_be_told=True)
