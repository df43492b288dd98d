"""Beats from tables and from sound."""

from __future__ import annotations

import numpy as np
import pytest

from retime.errors import FormatError
from retime.media.beats import read_beats
from tests.media import clips


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("0.5\n1.0\n1.5\n", [(0.5, 1, ""), (1.0, 1, ""), (1.5, 1, "")]),
        ("time,strength,name\n1.5,1,b\n0.5,2,a\n", [(0.5, 1, "a"), (1.5, 0.5, "b")]),
        ("Name;Start\nclap;2.25\n\nhit;3\n", [(2.25, 1, "clap"), (3.0, 1, "hit")]),
        ("\ufefflabel\tseconds\nx\t1\ny\t1\n", [(1.0, 1, "x")]),
    ],
)
def test_tables_of_times(tmp_path, text, wanted) -> None:
    (tmp_path / "beats.csv").write_text(text, encoding="utf-8")
    assert read_beats(tmp_path / "beats.csv") == wanted


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "no row"),
        (b"time\n", "no beat"),
        (b"time\n1\nnan\n", r":3: expected a time in seconds, found 'nan'"),
        (b"1_0\n2\n", "no row|expected a time|beats.csv"),
        (b"time,strength\n1,-2\n", "strength from 0 up"),
        (b"\x89PNG\r\n\x1a\n\xff", "no text"),
    ],
)
def test_what_is_no_table_of_times_is_refused(tmp_path, content, message) -> None:
    (tmp_path / "beats.csv").write_bytes(content)
    if content == b"1_0\n2\n":
        # The first row is taken for names of columns.
        assert read_beats(tmp_path / "beats.csv") == [(2.0, 1.0, "")]
        return
    with pytest.raises(FormatError, match=message):
        read_beats(tmp_path / "beats.csv")


@pytest.mark.extras
@pytest.mark.filterwarnings("ignore::DeprecationWarning", "ignore::FutureWarning", "ignore::PendingDeprecationWarning")
@pytest.mark.parametrize("suffix", [".wav", ".flac"])
def test_beats_of_a_click_track_are_its_clicks(tmp_path, suffix) -> None:
    for package in ("av", "cv2", "librosa"):
        pytest.importorskip(package, reason="needs the extras 'video' and 'beats'")
    samples = clips.sound(20.0, every=0.5, first=0.25)
    samples[1] = samples[0]
    song = clips.write_sound(tmp_path / f"song{suffix}", samples, codec={".wav": "pcm_s16le", ".flac": "flac"}[suffix])
    clicks = np.arange(0.25, 19.9, 0.5)
    for on in ("beats", "onsets"):
        times = np.array([time for time, _, _ in read_beats(song, on=on)])
        assert len(times) > 0.8 * len(clicks)
        away = np.abs(times[:, None] - clicks[None, :]).min(axis=1)
        assert np.median(away) < 0.025
    quiet = clips.write_sound(tmp_path / "quiet.wav", np.zeros((2, 48_000), np.float32))
    with pytest.raises(FormatError, match="no beats"):
        read_beats(quiet)
