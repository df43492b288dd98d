"""Clips, groups and references as the solver reads them, and what it warns of."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from retime import Reference, RetimeWarning, Signal, Warp, guided_warp, imitate, read, write
from retime.motion.contacts import contacts
from tests.server.serving import KEY, Served, serving


def test_a_group_is_searched_together_and_others_follow(folder) -> None:
    with serving(folder, "jump.bvh", "leap.bvh", "camera.csv") as served, served.ready_page() as page:
        page.edit(options={"length": "75%"})
        first = page.curve()
        jump, leap, camera = page.document["clips"]
        page.edit(clips=[jump, {**leap, "role": "search"}, camera])
        together = page.curve()
    clips = [read(folder / name) for name in ("jump.bvh", "leap.bvh")]
    np.testing.assert_array_equal(first["input_times"], guided_warp(clips[0], length="75%").warp.input_times)
    np.testing.assert_array_equal(together["input_times"], guided_warp(clips, length="75%").warp.input_times)


def test_a_group_imitates_a_group_and_a_stretch_of_itself(folder) -> None:
    jump, leap = (read(folder / name) for name in ("jump.bvh", "leap.bvh"))
    write(leap.frames(0, 200), folder / "a.bvh")
    write(jump.frames(0, 200), folder / "b.bvh")
    with serving(folder, "jump.bvh", "leap.bvh") as served, served.ready_page() as page:
        first, second = page.document["clips"]
        page.edit(
            clips=[first, {**second, "role": "search"}], options={"length": "75%"}, references=[{"path": "a.bvh"}]
        )
        problem = page.curve()
        assert "needs a counterpart for each" in problem["message"]
        assert problem["reference"] == 0
        page.edit(references=[{"path": "a.bvh", "counterparts": [{"clip": 1, "path": "b.bvh"}], "last_frame": 150}])
        files = page.curve()
        page.edit(references=[{"first_frame": 60, "last_frame": 180}])
        itself = page.curve()
    cuts = [read(folder / name).frames(0, 151) for name in ("a.bvh", "b.bvh")]
    expected = guided_warp([jump, leap], reference=Reference(cuts), length="75%").warp
    np.testing.assert_array_equal(files["input_times"], expected.input_times)
    stretch = Reference([clip.frames(60, 181) for clip in (jump, leap)])
    expected = guided_warp([jump, leap], reference=stretch, length="75%").warp
    np.testing.assert_array_equal(itself["input_times"], expected.input_times)


def test_a_reference_says_which_joint_stands_for_which(folder) -> None:
    leap = read(folder / "leap.bvh")
    own = read(folder / "jump.bvh").skeleton.names
    names = tuple(f"Part{i}" for i in range(len(leap.skeleton.names)))
    other = replace(leap, skeleton=replace(leap.skeleton, names=names))
    write(other, folder / "strange.bvh")
    # The file is wrong about one, and the document has the last word.
    said = dict(zip(own, [names[0], *reversed(names[1:])], strict=True))
    (folder / "map.json").write_text(json.dumps(said))
    pairs = [{"input": name, "reference": to} for name, to in zip(own[1:], names[1:], strict=True)]
    with serving(folder, "jump.bvh") as served, served.ready_page() as page:
        page.edit(references=[{"path": "strange.bvh"}], options={"length": "80%"})
        assert page.until("clip", what="reference")["counterparts"] == [""] * len(own)
        assert "too few of its joints" in page.curve()["message"]
        page.edit(references=[{"path": "strange.bvh", "joint_map": "map.json", "joints": pairs}])
        assert page.until("clip", what="reference")["counterparts"] == list(names)
        found = page.curve()
    reference = Reference(read(folder / "strange.bvh"), joint_map=dict(zip(own, names, strict=True)))
    expected = guided_warp(read(folder / "jump.bvh"), reference=reference, length="80%").warp
    np.testing.assert_array_equal(found["input_times"], expected.input_times)


def test_a_warning_is_told_once_and_to_who_comes_later(folder) -> None:
    steep = {**KEY, "speed": 30.0}
    with serving(folder, "jump.bvh") as served, served.ready_page() as page:
        page.edit(keys=[steep], method="spline")
        assert "without turning back" in page.until("notice")["text"]
        page.edit(keys=[{**steep, "id": "j"}])
        page.curve()
        assert page.heard.count("notice") == 1
        with served.page() as late:
            assert late.until("notice")["kind"] == "warning"


def len_of(served: Served, name: str) -> int:
    return read(served.folder / name).n_frames


def test_another_clip_is_sent_where_the_document_names_it(served) -> None:
    with served.ready_page() as page:
        references = [{"path": "leap.bvh"}, {"first_frame": 60, "last_frame": 180}]
        page.edit(references=references, options={"rate": "12"})
        clips = [page.until("clip") for _ in range(2)]
        assert [(clip["what"], clip["index"], clip["count"]) for clip in clips] == [
            ("reference", 0, 2),
            ("reference", 1, 2),
        ]
        assert (clips[1]["start_time"], clips[1]["n_frames"], clips[1]["n_whole"]) == (
            1.0,
            121,
            len_of(served, "jump.bvh"),
        )
        page.curve()
        why = page.until("why")
        assert (why["sources"], why["mirrored"]) == ([0, 1], [False, False])
        # What is the same is not sent again; who comes later is told all of it, and nothing that is gone.
        page.edit(references=[references[0], {**references[1], "last_frame": 200}])
        page.curve()
        assert [message["index"] for message in page.mail if message["type"] == "clip"] == [1]
        page.edit(references=[])
        page.curve()
        with served.page() as late:
            late.until("curve")
            assert [message["what"] for message in late.mail if message["type"] == "clip"] == ["clip"]


def test_feet_and_flights_are_told_with_their_clip(served: Served) -> None:
    clip = read(served.folder / "jump.bvh")
    with served.page() as page:
        told = page.until("clip")
    rate = float(clip.rate)
    np.testing.assert_allclose(told["flights"], [[first / rate, last / rate] for first, last in clip.flights()])
    found = contacts(clip)
    ends = [f"end of {clip.skeleton.names[site.parent]}" for site in clip.skeleton.end_sites]
    assert told["feet"] == [
        clip.skeleton.names[foot.joint] if foot.end_site is None else ends[foot.end_site] for foot in found.feet
    ]
    standing = np.zeros(found.at_rest.shape, dtype=bool)
    for foot, start, end in told["contacts"]:
        standing[round(start * rate) : round(end * rate) + 1, int(foot)] = True
    np.testing.assert_array_equal(standing, found.at_rest)


def test_what_a_synchronised_frame_was_matched_with_lies_in_its_reference(folder) -> None:
    end = read(folder / "leap.bvh").end_time
    with serving(folder, "jump.bvh") as served, served.ready_page() as page:
        page.edit(references=[{"path": "leap.bvh", "mirror": True}], method="align", repeat=1.5)
        curve, why = page.curve(), page.until("why", revision=page.revision)
    assert curve["method"] == "align"
    times = why["matched_times"][1:-1, 0]
    # Its own clock, from the beginning again where it is repeated.
    np.testing.assert_allclose(times, np.fmod(why["output_times"][1:-1], end), atol=1e-6)
    assert why["sources"] == [0]
    assert why["mirrored"] == [why["references"][0].endswith(", mirrored")]


def test_what_a_lock_could_not_quite_keep_is_told_with_the_curve(folder) -> None:
    times = np.arange(121) / 30
    wave = Signal(("x", "y"), np.stack([np.sin(times**1.4), 2 * np.cos(1.7 * times)], axis=1), 30)
    write(wave, folder / "wave.csv")
    # 2.97 s of it are locked between two keytimes that are a hundredth farther apart.
    keys = [{"id": "a", "input_time": 0.5, "output_time": 0.5}, {"id": "b", "input_time": 3.47, "output_time": 3.48}]
    lock = {"id": "l", "start": 0.0, "end": 4.0, "slowest": 1.0, "fastest": 1.0}
    with serving(folder, "wave.csv") as served, served.ready_page() as page:
        page.edit(keys=keys, locks=[lock])
        curve = page.curve()
        page.edit(locks=[])
        without = page.curve()
    assert all("the lock 0" in words for words in curve["given_up"])
    assert (len(curve["given_up"]) > 0, without["given_up"]) == (True, [])


def test_how_much_an_example_speaks_for_is_told_with_the_curve(folder) -> None:
    with serving(folder, "jump.bvh") as served, served.ready_page() as page:
        page.edit(keys=[KEY], method="linear", example={"start": 0.5, "end": 1.5})
        curve, why = page.curve(), page.until("why", revision=page.revision)
        page.edit(example=None)
        without = page.curve()
    # The keytime has the input play 4/3 times as fast before it.
    hand = Warp(np.array([0.0, 0.75]), np.array([0.0, 1.0]))
    with pytest.warns(RetimeWarning):
        expected = imitate(read(folder / "jump.bvh"), (30, 91), hand)
    assert expected.example is not None
    assert curve["spoken_share"] == expected.example.share < 1
    np.testing.assert_array_equal(curve["unspoken"], np.reshape(expected.example.unspoken, (-1, 2)))
    assert curve["example_warnings"] == list(expected.example.warnings)
    np.testing.assert_allclose(curve["hand_input_times"], [0.5, 1.5])
    np.testing.assert_allclose(curve["hand_output_times"], [0.375, 1.125])
    # What was matched is told in the time of the clip, not of the stretch.
    assert np.nanmin(why["matched_times"]) >= 0.5
    assert np.nanmax(why["matched_times"]) <= 1.5
    assert (without["spoken_share"], without["example_warnings"], len(without["hand_output_times"])) == (None, [], 0)
