"""What the page is told to draw of a clip."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from retime import write
from retime.motion.channels import ChannelKind
from retime.motion.signal import Signal
from retime.project.document import ClipFile, Document
from retime.project.reader import Reader, Sources
from retime.search.poses.references import Reference
from retime.server.drawn_messages import clip_messages
from tests.cli.figures import figure
from tests.fuzz.random_clips import below_a_node


def test_of_a_figure_under_a_node_its_body_is_shown() -> None:
    """A root that stays put, and what hangs on it, is no part of the figure: not of its extent, nor of its ground."""
    jump = figure()
    moved = below_a_node(np.random.default_rng(3), jump)
    alone, below = (clip_messages(sources_of(clip, reference=jump)) for clip in (jump, moved))
    for name in ("names", "parents", "n_nodes", "feet", "counterparts"):
        assert [getattr(one, name) for one in below] == [getattr(one, name) for one in alone], name
    assert below[0].names[0] == "Hips"
    np.testing.assert_allclose(below[0].positions, alone[0].positions, atol=1e-5)
    np.testing.assert_array_equal(below[0].contacts, alone[0].contacts)
    np.testing.assert_array_equal(below[0].flights, alone[0].flights)


def test_channels_are_told_with_what_they_hold() -> None:
    kinds = (ChannelKind("angle", "deg"), ChannelKind("label"), ChannelKind("linear"))
    values = np.stack([np.linspace(170, 180, 8), np.arange(8) % 2, np.zeros(8)], axis=1)
    (told,) = clip_messages(sources_of(Signal(("yaw", "id", "x"), values, Fraction(30), kinds=kinds)))
    assert told.kinds == ("angle:deg", "label", "linear")


def test_of_a_clip_that_is_cut_the_page_knows_where_in_its_file_it_lies(tmp_path) -> None:
    clip = figure()
    write(clip, tmp_path / "jump.bvh")
    whole = ClipFile(str(tmp_path / "jump.bvh"))
    part = ClipFile(whole.path, first_frame=12, last_frame=40)
    (told,) = clip_messages(Reader().read(Document((part,))))
    assert (told.n_frames, told.n_whole, told.first_frame) == (29, clip.n_frames, 12)
    assert told.start_time * told.rate == pytest.approx(12)
    (told,) = clip_messages(Reader().read(Document((whole,))))
    assert (told.start_time, told.n_whole) == (0, clip.n_frames)


def sources_of(clip, *, reference=None) -> Sources:
    references = () if reference is None else (Reference(reference),)
    return Sources(clips=(clip,), wholes=tuple(one.motion for one in references), references=references)
