from __future__ import annotations

import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from retime import Motion, guided_warp, plot_warps, read
from retime.errors import FormatError, MissingExtraError, OptionError, OutputExistsError
from retime.motion.signal import Signal
from retime.search.keytimes import as_keytimes
from retime.warp.curve import Warp
from retime.warp.keytime import Keytime
from retime.warp.spline import linear_warp, spline_warp
from tests.evaluate.figures import GRAVITY, jumper, keeping_flight, ramp

matplotlib = pytest.importorskip("matplotlib")

from matplotlib.axes import Axes  # noqa: E402
from matplotlib.colors import to_rgb  # noqa: E402
from matplotlib.figure import Figure  # noqa: E402
from matplotlib.lines import Line2D  # noqa: E402

MOCAP = Path(__file__).resolve().parents[3] / "shared" / "mocap" / "cmu-bvh"
KEYS = (
    Keytime(input_time=0.0, output_time=0.0),
    Keytime(input_time=3.0, output_time=1.0),
    Keytime(input_time=4.0, output_time=3.0),
)
LINEAR = linear_warp(KEYS)


def axes_of(figure: Figure, label: str) -> Axes:
    (found,) = [axes for axes in figure.axes if axes.get_label() == label]
    return found


def strip_of(figure: Figure) -> list[Axes]:
    return [axes for axes in figure.axes if axes.get_label().startswith("strip ")]


def line_of(axes: Axes, label: str) -> Line2D:
    (found,) = [line for line in axes.lines if line.get_label() == label]
    return found


def texts_of(axes: Axes) -> list[str]:
    return [text.get_text() for text in axes.texts]


def heads_of(axes: Axes) -> np.ndarray:
    """Output time and height of each pose's head; a `jumper` stands straight, so its head is above its time."""
    return np.array([[line.get_xdata()[0], line.get_ydata()[0]] for line in axes.lines if line.get_label() == "_head"])


def shaded(axes: Axes) -> list[tuple[float, float]]:
    """Start and stop of each shaded flight of a row."""
    boxes = [
        patch.get_path().get_extents(patch.get_patch_transform())
        for patch in axes.patches
        if patch.get_label() == "_flight"
    ]
    return [(box.x0, box.x1) for box in boxes]


def drawn_speed(line: Line2D, time: float) -> float:
    """Read a step curve at a time that is not on a step."""
    x, y = np.asarray(line.get_xdata()), np.asarray(line.get_ydata())
    (piece,) = np.flatnonzero((x[::2] < time) & (time < x[1::2]))
    assert y[2 * piece] == y[2 * piece + 1] or np.isnan(y[2 * piece])
    return float(y[2 * piece])


class TestSpeeds:
    def test_the_curves_are_the_warps_slopes(self) -> None:
        spline = spline_warp(KEYS)
        speed = axes_of(plot_warps({"linear": LINEAR, "spline": spline}), "speed")
        assert [drawn_speed(line_of(speed, "linear"), t) for t in (0.5, 2.0)] == [3.0, 0.5]
        for time in np.random.default_rng(0).uniform(0, 3, 50):
            assert drawn_speed(line_of(speed, "spline"), time) == spline.speed(time)

    def test_the_axis_is_logarithmic_from_a_tenth_to_ten_with_the_unit_line(self) -> None:
        speed = axes_of(plot_warps([LINEAR]), "speed")
        assert speed.get_yscale() == "log"
        assert speed.get_ylim() == (0.1, 10.0)
        assert [tick.get_text() for tick in speed.get_yticklabels()] == ["1/10", "1/4", "1/2", "1", "2", "4", "10"]
        assert list(line_of(speed, "_unit speed").get_ydata()) == [1.0, 1.0]
        assert speed.get_xlim() == (0.0, 3.0)
        assert "(×)" in speed.get_ylabel()
        assert "(s)" in speed.get_xlabel()

    def test_a_long_warp_is_thinned_but_keeps_its_extremes_and_its_ends(self) -> None:
        rng = np.random.default_rng(1)
        slopes = rng.uniform(0.5, 2, 40_000)
        slopes[[12_345, 31_000]] = [0.2, 7.0]
        times = np.arange(40_001) / 120
        warp = Warp(times, np.concatenate([[0.0], np.cumsum(slopes) / 120]))
        line = line_of(axes_of(plot_warps({"w": warp}), "speed"), "w")
        x, y = np.asarray(line.get_xdata()), np.asarray(line.get_ydata())
        assert len(x) < 10_000
        assert (y.min(), y.max()) == (pytest.approx(0.2), pytest.approx(7.0))
        assert (x[0], x[-1]) == (times[0], times[-1])
        assert abs(x[y.argmax()] - 31_000 / 120) < 0.5

    def test_holds_and_backward_pieces_are_left_out_of_the_curve_and_said(self) -> None:
        warp = Warp(np.array([0.0, 1, 2, 3, 4]), np.array([0.0, 2, 2, 1.5, 3]))
        speed = axes_of(plot_warps({"w": warp}), "speed")
        line = line_of(speed, "w")
        assert [drawn_speed(line, t) for t in (0.5, 3.5)] == [2.0, 1.5]
        assert np.isnan([drawn_speed(line, t) for t in (1.5, 2.5)]).all()
        backward = line_of(speed, "_backward")
        assert drawn_speed(backward, 2.5) == 0.5
        assert np.isnan([drawn_speed(backward, t) for t in (0.5, 1.5, 3.5)]).all()
        assert (backward.get_marker(), line.get_marker()) == ("<", "None")
        (hold,) = [patch for patch in speed.patches if patch.get_label() == "_hold"]
        assert (hold.get_x(), hold.get_x() + hold.get_width()) == (1.0, 2.0)
        assert texts_of(speed) == ["hold", "backward"]

    def test_holds_of_several_warps_do_not_cover_each_other(self) -> None:
        hold = Warp(np.array([0.0, 1, 2]), np.array([0.0, 0, 2]))
        speed = axes_of(plot_warps({"a": hold, "b": hold}), "speed")
        low, high = [patch for patch in speed.patches if patch.get_label() == "_hold"]
        assert low.get_y() + low.get_height() <= high.get_y()

    def test_speeds_beyond_the_axis_run_along_its_edge_and_are_given_in_numbers(self) -> None:
        warp = Warp(np.array([0.0, 1, 2, 3]), np.array([0.0, 40, 40.02, 41.02]))
        speed = axes_of(plot_warps({"w": warp}), "speed")
        edge = line_of(speed, "_beyond")
        assert [drawn_speed(edge, t) for t in (0.5, 1.5)] == [10.0, 0.1]
        assert np.isnan(drawn_speed(edge, 2.5))
        assert texts_of(speed) == ["▲ up to 40×", "▼ down to 0.02×"]

    def test_flights_are_shaded_around_each_warps_own_speed_at_its_own_times(self) -> None:
        motion = jumper(lead=1.0, rest=1.0)
        twice = linear_warp([(0, 0), (motion.end_time, motion.end_time / 2)])
        figure = plot_warps({"half": twice, "kept": keeping_flight(motion, 0.65)}, motion=motion)
        half, kept = [p for p in axes_of(figure, "speed").patches if p.get_label() == "_flights"]
        for ribbon, warp_speed, row in ((half, 2.0, "strip half"), (kept, 1.0, "strip kept")):
            box = ribbon.get_path().get_extents()
            assert box.y0 < warp_speed < box.y1 < 1.5 * warp_speed
            assert [(box.x0, box.x1)] == [pytest.approx(times) for times in shaded(axes_of(figure, row))]


class TestMap:
    def test_the_curves_are_the_warps(self) -> None:
        time_map = axes_of(plot_warps({"linear": LINEAR}), "map")
        line = line_of(time_map, "linear")
        np.testing.assert_array_equal(line.get_xdata(), LINEAR.output_times)
        np.testing.assert_array_equal(line.get_ydata(), LINEAR.input_times)
        assert (time_map.get_xlabel(), time_map.get_ylabel()) == ("output time (s)", "input time (s)")

    def test_keytimes_are_marked_in_the_map_and_above_the_speeds(self) -> None:
        figure = plot_warps([LINEAR, Warp([0.0, 3.0], [0.0, 4.0], [(2.5, 2.0)])])
        marks = line_of(axes_of(figure, "map"), "_keytimes")
        expected = sorted([*KEYS, Keytime(input_time=2.5, output_time=2.0)])
        assert list(marks.get_xdata()) == [key.output_time for key in expected]
        assert list(marks.get_ydata()) == [key.input_time for key in expected]
        speed = axes_of(figure, "speed")
        keys = axes_of(figure, "keys")
        assert list(line_of(keys, "_keytimes").get_xdata()) == [0.0, 1.0, 2.0, 3.0]
        # A keytime has no speed: no mark stands among the speeds, and the lane's times are those below it.
        assert all(line.get_marker() in ("None", "", None) for line in speed.lines)
        assert keys.get_xlim() == speed.get_xlim()
        assert keys.get_position().y0 >= speed.get_position().y1 - 1e-9
        # The ends have the panel's own edges for lines.
        assert [line.get_xdata()[0] for line in speed.lines if line.get_label() == "_key line"] == [1.0, 2.0]

    def test_keytimes_that_are_passed_replace_the_warps_own(self) -> None:
        figure = plot_warps([LINEAR], keytimes=[Keytime(input_time=1.5, output_time=0.5)])
        assert list(line_of(axes_of(figure, "map"), "_keytimes").get_ydata()) == [1.5]
        assert "_keytimes" not in [line.get_label() for line in axes_of(plot_warps([LINEAR], keytimes=[]), "map").lines]

    def test_a_warp_that_only_holds_has_a_map(self) -> None:
        time_map = axes_of(plot_warps([Warp(np.array([0.0, 1.0]), np.array([2.0, 2.0]))]), "map")
        low, high = time_map.get_ylim()
        assert low < 2.0 < high


class TestTellingWarpsApart:
    def test_no_two_of_eight_share_colour_or_dashes(self) -> None:
        methods = ["linear", "spline", "guided", "guided", "blend", "", "", ""]
        warps = [replace(LINEAR, method=method) for method in methods]
        lines = [line for line in axes_of(plot_warps(warps), "speed").lines if not line.get_label().startswith("_")]
        assert len(lines) == 8
        assert len({line.get_color() for line in lines}) == 8
        assert len({str(line._dash_pattern) for line in lines}) == 8  # the public get_linestyle() says only "--"

    def test_the_legend_names_them_once_each(self) -> None:
        warps = [
            replace(LINEAR, name="walk"),
            replace(LINEAR, name="walk"),
            LINEAR,
            Warp(np.arange(2.0), np.arange(2.0)),
        ]
        legend = axes_of(plot_warps(warps), "speed").get_legend()
        assert legend is not None
        assert [text.get_text() for text in legend.get_texts()] == ["walk", "walk 2", "linear", "warp"]

    @pytest.mark.parametrize(
        ("labels", "rows"), [(["a", "b", "c"], 1), (["a long name, one"] * 5, 2), (["guided"] * 2, 1)]
    )
    def test_the_legend_leaves_the_title_its_place(self, labels: list[str], rows: int) -> None:
        warps = {f"{label} {i}": LINEAR for i, label in enumerate(labels)}
        axes = axes_of(plot_warps(warps), "speed")
        legend = axes.get_legend()
        assert legend is not None
        axes.figure.draw_without_rendering()
        boxes = [text.get_window_extent() for text in legend.get_texts()]
        assert len({round(box.y0) for box in boxes}) == rows
        titles = [text for text in axes.figure.texts if text.get_text() == "Playback speed"]
        assert [legend.get_window_extent().x0 > title.get_window_extent().x1 for title in titles] == [True]

    def test_a_method_keeps_its_pen_whatever_comes_before_it(self) -> None:
        def color(figure: Figure, label: str) -> object:
            return line_of(axes_of(figure, "speed"), label).get_color()

        guided = replace(LINEAR, method="guided")
        alone = color(plot_warps({"guided": guided}), "guided")
        assert color(plot_warps({"steps": guided, "guided": guided}), "guided") == alone
        assert color(plot_warps({"steps": guided, "guided": guided}), "steps") != alone


@pytest.fixture(scope="module")
def motion() -> Motion:
    return jumper(lead=1.0, rest=1.5)


@pytest.fixture(scope="module")
def figure(motion: Motion) -> Figure:
    length = 0.65 * motion.end_time
    linear = linear_warp([(0, 0), (motion.end_time, length)])
    return plot_warps({"linear": linear, "guided": keeping_flight(motion, 0.65)}, motion=motion)


class TestStrip:
    def test_there_is_a_row_for_the_input_and_one_for_each_warp(self, figure: Figure) -> None:
        labels = [axes.get_label() for axes in figure.axes]
        assert labels == ["speed", "keys", "map", "strip input", "strip linear", "strip guided"]
        assert figure.axes[-1].get_xlabel() == "output time (s)"

    def test_all_rows_have_the_same_seconds_a_centimetre(self, figure: Figure) -> None:
        rows = strip_of(figure)
        assert len({row.get_xlim() for row in rows}) == 1
        assert len({(row.get_position().x0, row.get_position().x1) for row in rows}) == 1

    def test_all_poses_stand_at_even_output_times(self, figure: Figure) -> None:
        steps = np.concatenate([np.diff(heads_of(row)[:, 0]) for row in strip_of(figure)])
        np.testing.assert_allclose(steps, steps[0])

    def test_the_jump_takes_as_many_poses_where_it_is_kept_and_fewer_in_linear(self, figure: Figure) -> None:
        counts, durations = [], []
        for row in strip_of(figure):
            ((start, stop),) = shaded(row)
            times = heads_of(row)[:, 0]
            counts.append(int(np.sum((times >= start) & (times <= stop))))
            durations.append(stop - start)
            (label,) = [text for text in texts_of(row) if "pose" in text]
            assert label == f"{stop - start:.2f} s · {counts[-1]} poses"
        assert counts[0] == counts[2] > counts[1]
        assert durations[2] == pytest.approx(durations[0])
        assert durations[1] == pytest.approx(0.65 * durations[0])

    def test_poses_in_flight_have_their_own_colour(self, figure: Figure) -> None:
        for row in strip_of(figure):
            ((start, stop),) = shaded(row)
            heads = [line for line in row.lines if line.get_label() == "_head"]
            aloft = {to_rgb(line.get_color()) for line in heads if start <= line.get_xdata()[0] <= stop}
            standing = {to_rgb(line.get_color()) for line in heads if not start <= line.get_xdata()[0] <= stop}
            assert len(aloft) == len(standing) == 1
            assert aloft != standing

    def test_the_heads_show_the_height_of_the_jump(self, figure: Figure, motion: Motion) -> None:
        times, heights = heads_of(axes_of(figure, "strip input")).T
        rise = (heights - heights[0]) * 1.7
        # A stiff figure of 1.7 m that takes off at 1 s.
        aloft = np.clip(times - 1.0, 0.0, 0.5)
        np.testing.assert_allclose(rise, GRAVITY / 2 * aloft * (0.5 - aloft), atol=0.004)

    def test_each_figure_is_drawn_to_scale(self, motion: Motion, figure: Figure) -> None:
        row = axes_of(figure, "strip input")
        paths = [patch for patch in row.patches if patch.get_label() == "" and patch.get_facecolor()[3] == 0]
        points = row.transData.transform(paths[0].get_path().vertices)
        breadth = abs(points[1, 0] - points[0, 0])
        leg = np.linalg.norm(points[2] - points[1])
        # The left hip is 0.1 m off the middle, and the camera 25 degrees in front of the side.
        assert breadth / leg == pytest.approx(0.1 * np.sin(np.radians(25)), rel=1e-6)

    def test_a_long_clip_is_shown_around_the_take_off(self) -> None:
        motion = jumper(lead=30.0, rest=30.0)
        figure = plot_warps({"kept": keeping_flight(motion, 0.65)}, motion=motion)
        for label in ("strip input", "strip kept"):
            ((start, _),) = shaded(axes_of(figure, label))
            assert start == pytest.approx(0.0)
        assert "take-off" in axes_of(figure, "strip kept").get_xlabel()
        assert any("of 61" in text or "of 60" in text for text in texts_of(axes_of(figure, "strip input")))

    @pytest.mark.parametrize("n_frames", [1, 2, 5])
    def test_a_few_frames_have_a_strip(self, n_frames: int, tmp_path: Path) -> None:
        motion = jumper(lead=1.0, rest=1.0).frames(10, 10 + n_frames)
        warp = Warp(np.array([0.0, 0.1]), np.array([0.0, motion.end_time]))
        plot_warps([warp], motion=motion, path=tmp_path / "short.svg")
        ElementTree.parse(tmp_path / "short.svg")


class TestSignals:
    def test_rows_show_the_channels_at_even_output_times(self) -> None:
        signal = ramp()
        warp = Warp(np.array([0.0, 1.0, 2.0]), np.array([0.0, 3.0, 4.0]))
        figure = plot_warps({"w": warp}, motion=signal, n_poses=8)
        samples = line_of(axes_of(figure, "strip w"), "_samples of channel 1")
        np.testing.assert_allclose(samples.get_xdata(), [0.0, 0.5, 1.0, 1.5, 2.0])
        # Scaled to the channel's own range: the share of the input that has gone by.
        np.testing.assert_allclose(samples.get_ydata(), [0.0, 0.375, 0.75, 0.875, 1.0])
        assert len(line_of(axes_of(figure, "strip input"), "_samples of channel 0").get_xdata()) == 9

    def test_three_channels_are_shown_and_named(self) -> None:
        figure = plot_warps([Warp(np.array([0.0, 2.0]), np.array([0.0, 4.0]))], motion=ramp(5))
        legend = axes_of(figure, "strip input").get_legend()
        assert legend is not None
        assert [text.get_text() for text in legend.get_texts()] == ["channel 0", "channel 1", "channel 2"]

    def test_a_channel_that_never_changes_is_no_division_by_zero(self) -> None:
        flat = Signal(("flat",), np.full((20, 1), 3.0), Fraction(10))
        row = axes_of(plot_warps([Warp(np.array([0.0, 1.0]), np.array([0.0, 1.9]))], motion=flat), "strip input")
        assert not line_of(row, "flat").get_ydata().any()


class TestFiles:
    def test_an_svg_is_valid_and_keeps_its_words(self, tmp_path: Path) -> None:
        motion = jumper(lead=1.0, rest=1.0)
        path = tmp_path / "warp.svg"
        plot_warps({"kept": keeping_flight(motion, 0.65)}, motion=motion, path=path, title="A jump")
        root = ElementTree.parse(path).getroot()
        assert root.tag == "{http://www.w3.org/2000/svg}svg"
        words = [text.text for text in root.iter("{http://www.w3.org/2000/svg}text")]
        assert {"A jump", "input", "kept", "output time (s)", "playback speed (×)"} <= set(words)
        assert path.stat().st_size < 200_000

    def test_a_png_is_valid_with_a_white_ground(self, tmp_path: Path) -> None:
        from PIL import Image

        path = tmp_path / "warp.PNG"
        plot_warps([LINEAR], path=path)
        with Image.open(path) as image:
            assert image.format == "PNG"
            assert image.width == 2560
            assert image.convert("RGB").getpixel((5, 5)) == (255, 255, 255)
        assert path.stat().st_size < 100_000

    def test_the_same_warps_give_the_same_bytes(self, tmp_path: Path) -> None:
        motion = jumper(lead=0.5, rest=0.5)
        for name in ("first", "second"):
            plot_warps([LINEAR, keeping_flight(motion, 0.8)], motion=motion, path=tmp_path / f"{name}.svg")
            plot_warps([LINEAR], path=tmp_path / f"{name}.png")
            plot_warps([LINEAR], path=tmp_path / f"{name}.pdf")
        for suffix in (".svg", ".pdf", ".png"):
            assert (tmp_path / f"first{suffix}").read_bytes() == (tmp_path / f"second{suffix}").read_bytes()

    def test_a_pdf_is_one_page_with_its_letters(self, tmp_path: Path) -> None:
        plot_warps([LINEAR], path=tmp_path / "warp.pdf")
        data = (tmp_path / "warp.pdf").read_bytes()
        assert data.startswith(b"%PDF-")
        assert data.count(b"/Type /Page ") == 1
        # Type 3 fonts are drawings of letters.
        assert b"/Type3" not in data
        assert b"/FontFile2" in data

    def test_the_users_own_style_does_not_show(self, tmp_path: Path) -> None:
        plot_warps([LINEAR], path=tmp_path / "plain.svg")
        with matplotlib.rc_context({"font.size": 30, "axes.facecolor": "red", "svg.fonttype": "path"}):
            plot_warps([LINEAR], path=tmp_path / "styled.svg")
            assert matplotlib.rcParams["font.size"] == 30
        assert (tmp_path / "plain.svg").read_bytes() == (tmp_path / "styled.svg").read_bytes()

    def test_a_file_is_not_overwritten_unless_asked(self, tmp_path: Path) -> None:
        path = tmp_path / "warp.svg"
        path.write_text("mine")
        with pytest.raises(OutputExistsError):
            plot_warps([LINEAR], path=path)
        assert path.read_text() == "mine"
        plot_warps([LINEAR], path=path, overwrite=True)
        ElementTree.parse(path)
        assert list(tmp_path.iterdir()) == [path]

    @pytest.mark.parametrize("name", ["warp.gif", "warp", "warp.svg.gz"])
    def test_another_ending_is_refused_before_any_work(self, name: str, tmp_path: Path) -> None:
        with pytest.raises(FormatError, match=r"written as \.svg, \.pdf, \.png"):
            plot_warps([LINEAR], path=tmp_path / name)
        assert not list(tmp_path.iterdir())

    def test_names_of_strangers_do_no_harm(self, tmp_path: Path) -> None:
        path = tmp_path / "names.svg"
        names = [
            "<b>&amp;",
            "$\\frac{1}{0}$",
            "_hidden",
            "tab\tnul\0bell\a",
            "走る.bvh",
            "x" * 500,
            "lone \ud800",
            "$x$ y",
        ]
        signal = replace(ramp(3), names=("$a$", "_b", "c\0"), name="<script>\n")
        plot_warps(dict.fromkeys(names, LINEAR), motion=signal, path=path)
        words = "\n".join(text.text or "" for text in ElementTree.parse(path).iter("{http://www.w3.org/2000/svg}text"))
        assert "<b>&amp;" in words
        assert "_hidden" in words
        assert "走る.bvh" in words
        assert "x" * 100 not in words


class TestRefusals:
    @pytest.mark.parametrize("warps", [[], {}])
    def test_no_warp(self, warps: list[Warp]) -> None:
        with pytest.raises(OptionError, match="no warp to show"):
            plot_warps(warps)

    @pytest.mark.parametrize("n_poses", [1, 0, -3])
    def test_too_few_poses(self, n_poses: int) -> None:
        with pytest.raises(OptionError, match=f"n_poses={n_poses}"):
            plot_warps([LINEAR], motion=jumper(lead=1, rest=1), n_poses=n_poses)

    def test_no_matplotlib(self, monkeypatch: pytest.MonkeyPatch) -> None:
        for name in [name for name in sys.modules if name.partition(".")[0] == "matplotlib"]:
            monkeypatch.delitem(sys.modules, name)
        monkeypatch.setitem(sys.modules, "matplotlib", None)
        with pytest.raises(MissingExtraError, match=r"retime\[plot\]") as caught:
            plot_warps([LINEAR])
        assert (caught.value.package, caught.value.extra) == ("matplotlib", "plot")

    def test_pyplot_is_never_imported_and_the_module_itself_needs_no_matplotlib(self, tmp_path: Path) -> None:
        code = (
            "import sys, retime.evaluate.plot.warps as plot\n"
            "assert not any(name.startswith('matplotlib') for name in sys.modules)\n"
            "from retime import Warp\n"
            "for suffix in ('svg', 'png'):\n"
            "    plot.plot_warps([Warp([0.0, 1.0], [0.0, 2.0])], path=sys.argv[1] + suffix)\n"
            "assert 'matplotlib.pyplot' not in sys.modules\n"
        )
        subprocess.run([sys.executable, "-c", code, str(tmp_path / "warp.")], check=True)


@pytest.mark.parametrize(("clip", "length"), [("02_04", "65%"), ("02_04", "150%"), ("49_04", "80%")])
def test_on_a_real_jump_the_guided_row_has_as_many_poses_as_the_input(clip: str, length: str) -> None:
    path = MOCAP / f"{clip}.bvh"
    if not path.exists():
        pytest.skip("the motion capture data is not beside the checkout (../shared/mocap)")
    motion = read(path)
    assert isinstance(motion, Motion)
    # The first frame of these files is a T-pose.
    motion = motion.frames(1, motion.n_frames)
    keytimes = as_keytimes(motion, length, ())
    warps = {"linear": linear_warp(keytimes), "guided": guided_warp(motion, length=length).warp}
    figure = plot_warps(warps, motion=motion)
    durations, counts = [], []
    for row in strip_of(figure):
        start, stop = max(shaded(row), key=lambda times: times[1] - times[0])
        durations.append(stop - start)
        counts.append(sum(start <= line.get_xdata()[0] <= stop for line in row.lines if line.get_label() == "_head"))
    assert durations[2] == pytest.approx(durations[0], abs=0.02)
    assert abs(durations[1] - durations[0]) > 0.1 * durations[0]
    texts = [next(text for text in texts_of(row) if "pose" in text) for row in strip_of(figure)[::2]]
    assert texts[0] == texts[1]


class TestOnAxesOfOnesOwn:
    @pytest.mark.parametrize("panel", ["speed", "map"])
    def test_a_panel_is_the_one_of_the_whole_picture(self, panel) -> None:
        mine = Figure()
        left, right = mine.subplots(1, 2)
        assert plot_warps({"linear": LINEAR}, ax=right, panel=panel) is mine
        whole = axes_of(plot_warps({"linear": LINEAR}), panel)
        np.testing.assert_array_equal(line_of(right, "linear").get_xydata(), line_of(whole, "linear").get_xydata())
        assert (right.get_xlim(), right.get_ylim()) == (whole.get_xlim(), whole.get_ylim())
        assert not left.lines
        assert mine.axes == [left, right]

    def test_on_a_part_of_a_figure_the_whole_is_returned_and_written(self, tmp_path: Path) -> None:
        mine = Figure()
        part = mine.subfigures(1, 2)[0]
        assert plot_warps([LINEAR], ax=part.subplots(), path=tmp_path / "mine.pdf") is mine
        assert (tmp_path / "mine.pdf").read_bytes().startswith(b"%PDF-")

    def test_flights_are_shaded_there_too(self) -> None:
        motion = jumper(lead=0.5, rest=0.5)
        axes = Figure().subplots()
        plot_warps([keeping_flight(motion, 0.8)], motion=motion, ax=axes)
        assert any(patch.get_label() == "_flights" for patch in axes.patches)

    @pytest.mark.parametrize(
        ("options", "says"),
        [
            ({"panel": "strip"}, "one of speed, map; found 'strip'"),
            ({"title": "mine"}, "no title"),
        ],
    )
    def test_what_has_no_place_there_is_refused(self, options, says: str) -> None:
        with pytest.raises(OptionError, match=says):
            plot_warps([LINEAR], ax=Figure().subplots(), **options)


def test_a_hole_hides_nothing_of_its_channel() -> None:
    values = np.column_stack([np.arange(90.0), np.arange(90.0)])
    values[20:26, 0] = np.nan
    signal = Signal(("x", "y"), values, 30, gaps="keep")
    warp = linear_warp([(0.0, 0.0), (signal.end_time, 2.0)])
    figure = plot_warps(warp, motion=signal)
    lines = {line.get_label(): line for axes in figure.axes for line in axes.get_lines()}
    shown = np.asarray(lines["x"].get_ydata(), dtype=float)
    assert 0 < np.isnan(shown).sum() < len(shown) / 4
    assert (np.nanmin(shown), np.nanmax(shown)) == (0.0, 1.0)
