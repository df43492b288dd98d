"""Labels beside a clip go through its warp: compared with what each output frame shows, counted one by one."""

from __future__ import annotations

import csv
import itertools
import json
from fractions import Fraction

import numpy as np
import pytest

from retime.batch.labels import ShownFrames, retimed_beside
from retime.errors import FormatError
from retime.warp.curve import Warp

RATE = Fraction(30)


def shown_by(seed: int, *, n_file: int = 90, first: int = 0, n_used: int = 90, backward: bool = False) -> ShownFrames:
    rng = np.random.default_rng(seed)
    end = (n_used - 1) / 30
    inner = rng.uniform(0.05, 0.95, 4) * end
    if not backward:
        inner = np.sort(inner)
    outputs = np.concatenate([[0.0], np.cumsum(rng.uniform(0.2, 1.0, 5))])
    return ShownFrames(Warp(outputs, np.array([0.0, *inner, end])), RATE, n_file, first, n_used)


@pytest.mark.parametrize("backward", [False, True])
@pytest.mark.parametrize("seed", range(6))
def test_a_range_of_frames_is_where_the_output_shows_it(seed: int, backward: bool) -> None:
    shown = shown_by(seed, first=5, n_file=100, backward=backward)
    frames = shown.frames.tolist()
    rng = np.random.default_rng(seed + 100)
    for _ in range(40):
        low, high = sorted(rng.integers(0, 100, 2).tolist())
        ranges = shown.ranges(low, high)
        covered = {i for start, stop in ranges for i in range(start, stop + 1)}
        wanted = {i for i, frame in enumerate(frames) if low <= frame <= high}
        if wanted:
            assert covered == wanted
            assert all(stop + 1 < start for (_, stop), (start, _) in itertools.pairwise(ranges))
        elif high < 5 or low > 94:
            assert ranges == []
        else:
            # Leapt over: it lies on the nearest frame.
            ((place, end),) = ranges
            middle = 0.5 * (low + high)
            assert place == end
            assert abs(frames[place] - middle) == min(abs(frame - middle) for frame in frames)


@pytest.mark.parametrize("seed", range(6))
def test_spans_and_moments_are_those_of_the_warp(seed: int) -> None:
    shown = shown_by(seed, first=6, n_file=100)
    times = np.linspace(0, shown.warp.output_end, 20001)
    inputs = shown.warp(times) + 0.2
    for low, high in ((0.5, 1.5), (0.25, 3.0), (1.0, 1.1)):
        ((start, end),) = shown.spans(low, high)
        inside = times[(inputs >= low) & (inputs <= high)]
        assert start == pytest.approx(inside[0], abs=2e-4)
        assert end == pytest.approx(inside[-1], abs=2e-4)
        moment = shown.moment(low)
        assert moment is not None
        assert float(shown.warp(moment)) + 0.2 == pytest.approx(low, abs=1e-9)
    assert shown.moment(0.1) is None
    assert shown.moment(50.0) is None
    assert shown.spans(0.0, 0.1) == []
    # What reaches the end of the input reaches that of the output: its last frame is shown for a period.
    assert shown.spans(2.0, 40.0)[-1][1] == pytest.approx(shown.duration)


def write_rows(path, rows) -> None:
    with path.open("w", newline="") as file:
        csv.writer(file).writerows(rows)


def test_rows_of_ranges_become_rows_of_the_output(tmp_path) -> None:
    shown = ShownFrames(Warp([0.0, 1.0, 2.0], [0.0, 2.0, 1.0]), RATE, 61, 0, 61)
    source = tmp_path / "walk_labels.csv"
    write_rows(source, [["label", "start_t", "end_t", "note"], ["turn", "1.0", "1.5", "=x"], ["end", "0", "0.5", ""]])
    (tmp_path / "out.csv").write_bytes(retimed_beside(source, shown))
    rows = list(csv.reader((tmp_path / "out.csv").read_text().splitlines()))
    # The warp runs backward from 2 s to 1 s: what lies there is shown twice.
    assert rows == [
        ["label", "start_t", "end_t", "note"],
        ["turn", "0.5", "0.75", "=x"],
        ["turn", "1.5", "2", "=x"],
        ["end", "0", "0.25", ""],
    ]


def test_frames_and_moments_in_tables(tmp_path) -> None:
    shown = ShownFrames(Warp([0.0, 1.0], [0.0, 2.0]), RATE, 61, 0, 61)
    write_rows(tmp_path / "a.csv", [["start_frame", "end_frame", "kind"], ["10", "19", "left"], ["60", "60", "end"]])
    (tmp_path / "b.csv").write_bytes(retimed_beside(tmp_path / "a.csv", shown))
    assert (tmp_path / "b.csv").read_text().splitlines() == ["start_frame,end_frame,kind", "5,9,left", "30,30,end"]
    write_rows(tmp_path / "c.csv", [["time", "event"], ["0.5", "step"], ["9", "beyond"]])
    (tmp_path / "d.csv").write_bytes(retimed_beside(tmp_path / "c.csv", shown))
    assert (tmp_path / "d.csv").read_text().splitlines() == ["time,event", "0.25,step"]


def test_a_row_a_frame_is_shown_as_the_frames_are(tmp_path) -> None:
    shown = ShownFrames(Warp([0.0, 1.0], [0.0, 2.0]), RATE, 70, 5, 61)
    rows = [["left", "right"], *[[str(i % 2), str(int(i < 30))] for i in range(70)]]
    write_rows(tmp_path / "contacts.csv", rows)
    (tmp_path / "out.csv").write_bytes(retimed_beside(tmp_path / "contacts.csv", shown))
    back = np.loadtxt(tmp_path / "out.csv", delimiter=",", skiprows=1)
    head = (tmp_path / "out.csv").read_text().splitlines()[0].split(",")
    assert np.array_equal(back[:, head.index("right")], [float(frame < 30) for frame in shown.frames])


def test_babel_s_documents(tmp_path) -> None:
    shown = ShownFrames(Warp([0.0, 1.0, 2.0], [0.0, 1.0, 3.0]), RATE, 91, 0, 91)
    document = {
        "babel_sid": 12,
        "dur": 3.0,
        "seq_ann": {"labels": [{"raw_label": "walk", "act_cat": ["walk"]}]},
        "frame_ann": {
            "labels": [
                {"raw_label": "stand", "start_t": 0.0, "end_t": 1.0},
                {"raw_label": "walk", "start_t": 1.0, "end_t": 3.0},
            ]
        },
        "contacts": {"left": [int(i < 45) for i in range(91)]},
        "n_frames": 91,
    }
    (tmp_path / "a.json").write_text(json.dumps(document))
    (tmp_path / "b.json").write_bytes(retimed_beside(tmp_path / "a.json", shown))
    made = json.loads((tmp_path / "b.json").read_text())
    assert made["frame_ann"]["labels"] == [
        {"raw_label": "stand", "start_t": 0.0, "end_t": 1.0},
        {"raw_label": "walk", "start_t": 1.0, "end_t": 2.0},
    ]
    assert made["seq_ann"] == document["seq_ann"]
    assert made["babel_sid"] == 12
    assert made["dur"] == pytest.approx(61 / 30, abs=1e-6)
    assert made["n_frames"] == 61
    assert made["contacts"]["left"] == [int(frame < 45) for frame in shown.frames]


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("a.json", '{"words": "nothing"}', "found no ranges"),
        ("a.json", "{", "not JSON"),
        ("a.csv", "start_t,end_t\n1,x\n", "a time in seconds, found 'x'"),
        ("a.csv", "start_frame,end_frame\n1,2.5\n", "a frame's number"),
        ("a.csv", "start_frame,end_frame\n1\n", "too short"),
        ("a.csv", "start_frame,end_frame\n1,inf\n", "a frame's number"),
        ("a.csv", "a,b\n1,2\n3,4\n5,6\n", "found 3 rows"),
        ("a.csv", "", "empty"),
        ("a.csv", "start_frame,end_frame\n1_0,20\n", "a frame's number, found '1_0'"),
        ("a.csv", "start_t,end_t\n1,\u0662\n", "a time in seconds"),
        ("a.csv", "start_frame,note\n1," + "x" * 200_000 + "\n", "field larger than"),
        ("a.json", '{"start_t": 0, "end_t": 1e400}', "1e400 is too large"),
        ("a.json", '{"start_t": 0, "end_t": 1, "note": "\\ud800"}', "half a letter"),
        ("a.txt", "x", ".csv, .tsv or .json"),
    ],
)
def test_what_says_nothing_is_refused(tmp_path, name: str, text: str, said: str) -> None:
    (tmp_path / name).write_text(text)
    shown = ShownFrames(Warp([0.0, 1.0], [0.0, 2.0]), RATE, 61, 0, 61)
    with pytest.raises(FormatError) as caught:
        retimed_beside(tmp_path / name, shown)
    assert said in str(caught.value)


@pytest.mark.parametrize("end", ["\n", "\r", "\r\n"])
def test_a_table_of_any_line_ends_is_read(tmp_path, end: str) -> None:
    (tmp_path / "a.csv").write_bytes(f"label,start_frame,end_frame{end}step,2,4{end}".encode())
    shown = ShownFrames(Warp([0.0, 1.0], [0.0, 2.0]), RATE, 61, 0, 61)
    (tmp_path / "b.csv").write_bytes(retimed_beside(tmp_path / "a.csv", shown))
    assert (tmp_path / "b.csv").read_text() == "label,start_frame,end_frame\nstep,1,2\n"


def test_a_table_of_other_bytes_than_text_is_refused_by_its_line(tmp_path) -> None:
    (tmp_path / "a.csv").write_bytes(b"start_frame,end_frame,who\n1,2,a\n3,4,Ren\xe9\n")
    shown = ShownFrames(Warp([0.0, 1.0], [0.0, 2.0]), RATE, 61, 0, 61)
    with pytest.raises(FormatError, match=r"a\.csv:3: expected UTF-8 text"):
        (tmp_path / "b.csv").write_bytes(retimed_beside(tmp_path / "a.csv", shown))


@pytest.mark.parametrize("head", ["label\n", "", "label,side\n"])
def test_a_text_a_frame_is_that_of_the_frame_shown(tmp_path, head: str) -> None:
    shown = ShownFrames(Warp([0.0, 1.0], [0.0, 2.0]), RATE, 70, 5, 61)
    rows = [f"w{i}" + ",left" * ("," in head) for i in range(70)]
    (tmp_path / "a.csv").write_text(head + "\n".join(rows) + "\n")
    made = retimed_beside(tmp_path / "a.csv", shown).decode().splitlines()
    assert made == [*head.splitlines(), *(rows[frame] for frame in shown.frames)]


def test_a_row_a_frame_is_written_as_it_was(tmp_path) -> None:
    shown = ShownFrames(Warp([0.0, 1.0], [0.0, 1.7]), RATE, 70, 5, 52)
    cells = [["007" if i < 30 else "012", str(i % 3 // 2), str(4), f"{i / 8}"] for i in range(70)]
    write_rows(tmp_path / "a.csv", [["subject_id", "contact", "count", "x"], *cells])
    (tmp_path / "b.csv").write_bytes(retimed_beside(tmp_path / "a.csv", shown))
    with (tmp_path / "b.csv").open(newline="") as file:
        head, *rows = csv.reader(file)
    assert [row[1:-1] for row in rows] == [cells[frame][:-1] for frame in shown.frames]
    assert head == ["time", "subject_id", "contact", "count", "x"]
