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
        # Audacity's labels, Audition's and REAPER's markers, a beat tracker's list.
        ("0.5\t0.5\tone\n1.25\t1.25\ttwo\n", [(0.5, 1, ""), (1.25, 1, "")]),
        (
            "Name\tStart\tDuration\tTime Format\tType\tDescription\nMarker 01\t1:00.500\t0:00.000\tdecimal\tCue\t\n",
            [(60.5, 1, "Marker 01")],
        ),
        ("#,Name,Start,End,Length\nM1,a,0:00.500,,\nM2,b,1:01:01.1,,\n", [(0.5, 1, "a"), (3661.1, 1, "b")]),
        ("0.51 1\n1.02 2\n", [(0.51, 1, ""), (1.02, 1, "")]),
        # Beats are numbered; commas in numbers; units.
        ("beat,position\n1,0.5\n2,1\n", [(0.5, 1, ""), (1.0, 1, "")]),
        ("Zeit;Name\n0,5;a\n".replace("Zeit", "time"), [(0.5, 1, "a")]),
        ("Time (s),x\n0.5s,1\n", [(0.5, 1, "")]),
        ("0.5s\n1.1\n", [(0.5, 1, ""), (1.1, 1, "")]),
        ("1,0.5\n2,0.25\n3,1\n", [(1.0, 1, ""), (2.0, 1, ""), (3.0, 1, "")]),
    ],
)
def test_tables_of_times(tmp_path, text, wanted) -> None:
    (tmp_path / "beats.csv").write_text(text, encoding="utf-8")
    assert read_beats(tmp_path / "beats.csv") == wanted


def test_a_table_of_a_spreadsheet_may_be_utf_16(tmp_path) -> None:
    (tmp_path / "markers.csv").write_bytes("Marker Name\tIn\nKlatschen\t0:01,5\n".replace(",", ".").encode("utf-16"))
    assert read_beats(tmp_path / "markers.csv") == [(1.5, 1, "Klatschen")]


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "no row"),
        (b"time\n", "no beat"),
        (b"time\n1\nnan\n", r":3: expected a time in seconds .*found 'nan'"),
        (b"1_0\n2\n", r":1: expected a time in seconds \(63.5, 1:03.500\), found '1_0'"),
        (b"frame,name\n15,a\n", "no column of times among 'frame', 'name': call the one with the seconds 'time'"),
        (b"frame\n15\n", "no column of times"),
        (b"time (ms)\n500\n", "no column of times"),
        (b"id,when\n1,0.5\n", "no column of times"),
        (b"1,0.5\n2,1.1\n3,1.7\n", "may count the rows"),
        (b"Marker Name,In\nA,00:00:01:12\n", "'00:00:01:12' counts frames, whose rate"),
        (b"time\n15f\n", "'15f' counts frames"),
        (b"time,strength\n1,-2\n", "strength from 0 up"),
        (b"\x89PNG\r\n\x1a\n\xff", "no text"),
    ],
)
def test_what_is_no_table_of_times_is_refused(tmp_path, content, message) -> None:
    (tmp_path / "beats.csv").write_bytes(content)
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
