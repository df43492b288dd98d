"""Draw the pictures that move, in docs/images/gallery: the sample clip before and after, as SVG that plays by itself.

Usage: python tools/make_motion_pictures.py [FOLDER]

A pose is one value of an animated path, a picture a twentieth of a second. Each picture checks what it shows.
"""

from __future__ import annotations

import html
import sys
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import retime
from retime.evaluate.plot.stick_figure import HEAD_RADIUS, view_of
from retime.motion.flights import flights
from retime.search.keytimes import as_keytimes

PLACE = Path(__file__).resolve().parents[1] / "docs" / "images" / "gallery"
CLIP = retime.sample()
FLIGHTS = [(first / 60, last / 60) for first, last in flights(CLIP)]
PICTURES_A_SECOND = 20
# Pixels: the picture, a row of it, and a stature.
WIDTH, ROW, STATURE, MARGIN = 640, 166, 104, 44
# Seconds that the last pose stays before all begin again.
REST = 1.2
INK, IN_FLIGHT, FAR, GROUND = "#0f172a", "#c2410c", "#94a3b8", "#cbd5e1"


@dataclass(frozen=True)
class Row:
    """A figure that moves.

    Attributes
    ----------
    label : str
        What it shows.
    warp : Warp
        How the sample is played.
    beats : tuple of float
        Output times of a beat, in seconds, shown as a disc that flashes.
    marks : tuple of (float, float)
        Spans of the output that are told apart by colour; left out, the flights.
    """

    label: str
    warp: retime.Warp
    beats: tuple[float, ...] = ()
    marks: tuple[tuple[float, float], ...] | None = None


def as_it_is() -> retime.Warp:
    """Play the clip as it was captured."""
    return retime.linear_warp(as_keytimes(CLIP, None, ()))


def shown_flights(warp: retime.Warp) -> list[tuple[float, float]]:
    """Return when the flights are seen, in output time; a warp that turns back shows one more than once."""
    times = np.arange(round(warp.output_end * PICTURES_A_SECOND) + 1) / PICTURES_A_SECOND
    inside = np.zeros(len(times), bool)
    for first, last in FLIGHTS:
        inside |= (warp(times) >= first) & (warp(times) <= last)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], inside, [False]]).astype(int)))
    return [(times[a], times[min(b, len(times) - 1)]) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def drawn(rows: Sequence[Row]) -> str:
    """Return a picture of rows, one below the other, which begin together."""
    lasts = max(row.warp.output_end for row in rows) + REST
    height = ROW * len(rows)
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" width="{WIDTH}" height="{height}" '
        'font-family="Helvetica, Arial, sans-serif">',
        f'<rect width="{WIDTH}" height="{height}" rx="8" fill="#ffffff"/>',
        *(_row(row, ROW * index, lasts) for index, row in enumerate(rows)),
        "</svg>",
    ]
    return "\n".join(parts) + "\n"


def _row(row: Row, top: float, lasts: float) -> str:
    times = np.arange(round(row.warp.output_end * PICTURES_A_SECOND) + 1) / PICTURES_A_SECOND
    input_times = np.asarray(row.warp(np.minimum(times, row.warp.output_end)))
    view = view_of(CLIP)
    poses = view.project(CLIP, input_times) * STATURE
    travel = np.interp(input_times, np.arange(CLIP.n_frames) / 60, _travel())
    room = WIDTH - 2 * MARGIN
    poses[:, :, 0] += MARGIN + travel[:, None] * room
    ground = top + ROW - 22
    poses[:, :, 1] = ground - poses[:, :, 1]
    share = times / lasts
    marks = row.marks if row.marks is not None else tuple(shown_flights(row.warp))
    ends = f"{row.warp.output_end:.1f} s"
    parts = [
        f'<text x="14" y="{top + 28}" font-size="22" fill="#334155">{html.escape(row.label)}'
        f'<tspan fill="#64748b">  {ends}</tspan></text>',
        f'<line x1="14" x2="{WIDTH - 14}" y1="{ground:.1f}" y2="{ground:.1f}" stroke="{GROUND}" stroke-width="2"/>',
    ]
    for side, ink, width in (("left", FAR, 5), ("", INK, 6), ("right", INK, 5)):
        nodes = [chain.nodes for chain in view.chains if chain.side == side]
        values = ";".join(_path(pose, nodes) for pose in poses)
        parts.append(
            f'<path fill="none" stroke="{ink}" stroke-width="{width}" stroke-linecap="round" stroke-linejoin="round" '
            f'd="{_path(poses[0], nodes)}">{_steps("d", values, share, lasts)}'
            f"{_marked('stroke', ink, marks, lasts) if ink == INK else ''}</path>"
        )
    x, y = poses[:, view.head, 0], poses[:, view.head, 1]
    parts.append(
        f'<circle r="{HEAD_RADIUS * STATURE:.1f}" fill="{INK}" cx="{x[0]:.1f}" cy="{y[0]:.1f}">'
        f"{_steps('cx', ';'.join(f'{one:.1f}' for one in x), share, lasts)}"
        f"{_steps('cy', ';'.join(f'{one:.1f}' for one in y), share, lasts)}"
        f"{_marked('fill', INK, marks, lasts)}</circle>"
    )
    if row.beats:
        flashes = tuple((beat, beat + 0.12) for beat in row.beats)
        parts.append(
            f'<circle r="11" cx="{WIDTH - 28}" cy="{top + 22}" fill="{GROUND}">'
            f"{_marked('fill', GROUND, flashes, lasts)}</circle>"
        )
    return "\n".join(parts)


def _travel() -> np.ndarray:
    """Return how far along its way the figure is at each frame, from 0 to 1, so that it moves from left to right."""
    place = CLIP.local_translations[:, 0][:, [0, 2]]
    way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(place, axis=0), axis=1))])
    return way / way[-1]


def _path(pose: np.ndarray, chains: list[tuple[int, ...]]) -> str:
    return "".join("M" + "L".join(f"{pose[node, 0]:.1f} {pose[node, 1]:.1f}" for node in nodes) for nodes in chains)


def _steps(attribute: str, values: str, share: np.ndarray, lasts: float) -> str:
    """Show one value after the other; the last one stays until all begin again."""
    times = ";".join(f"{one:.4f}".rstrip("0").rstrip(".") for one in share)
    return (
        f'<animate attributeName="{attribute}" calcMode="discrete" dur="{lasts:.2f}s" repeatCount="indefinite" '
        f'keyTimes="{times}" values="{values}"/>'
    )


def _marked(attribute: str, plain: str, spans: Sequence[tuple[float, float]], lasts: float) -> str:
    """Change a colour for some spans of the output."""
    times, values = [0.0], [plain]
    for first, last in spans:
        times += [first / lasts, last / lasts]
        values += [IN_FLIGHT, plain]
    return _steps(attribute, ";".join(values), np.array(times), lasts)


def shorter() -> list[Row]:
    """Shorten the clip to 65 %: played evenly its jumps are rushed, guided they keep their own speed."""
    evenly = retime.linear_warp(as_keytimes(CLIP, "65%", ()))
    guided = retime.guided_warp(CLIP, length="65%").warp
    for first, last in FLIGHTS:
        shown = np.interp([first, last], guided.input_times, guided.output_times)
        assert abs((shown[1] - shown[0]) / (last - first) - 1) < 0.1
    return [Row("Captured", as_it_is()), Row("65 %, evenly", evenly), Row("65 %, retime", guided)]


def longer() -> list[Row]:
    """Lengthen it to 140 %: pauses and steps give, the jumps don't float."""
    evenly = retime.linear_warp(as_keytimes(CLIP, "140%", ()))
    guided = retime.guided_warp(CLIP, length="140%").warp
    for first, last in FLIGHTS:
        shown = np.interp([first, last], guided.input_times, guided.output_times)
        assert (shown[1] - shown[0]) / (last - first) < 1.15
    return [Row("140 %, evenly", evenly), Row("140 %, retime", guided)]


def beat() -> list[Row]:
    """Land on the beat, 100 a minute: the take-off of each jump and its landing stay as far apart as they were."""
    period = 0.6
    beats = tuple(np.arange(0, CLIP.end_time, period).round(6))
    downs = [last for _, last in FLIGHTS]
    keys = [(down, period * round(down / period)) for down in downs]
    guided = retime.guided_warp(CLIP, keys=keys).warp
    assert np.allclose(guided([on for _, on in keys]), downs)
    return [Row("Captured, off the beat", as_it_is(), beats), Row("Landings on the beat", guided, beats)]


def again() -> list[Row]:
    """Hold the top of the first jump, and play the second one backward and again."""
    (up, down), top = FLIGHTS[-1], float(np.mean(FLIGHTS[0]))
    keys = [(top, top), (top, top + 0.8), (down, down + 0.8), (up, down + 0.8 + down - up)]
    length = f"{CLIP.duration + 0.8 + 2 * (down - up):.4f}s"
    guided = retime.guided_warp(CLIP, length=length, keys=keys).warp
    assert np.allclose(guided(np.linspace(top, top + 0.8, 5)), top)
    assert guided.speed(down + 0.8 + (down - up) / 2) < 0
    return [Row("A hold, and once more from the take-off", guided)]


def limp() -> list[Row]:
    """Let one stride limp by hand: every step of both walks follows."""
    start, stop = 81, 151
    hand = retime.Warp([0.0, 0.35, 1.2], [0.0, 35 / 60, (stop - 1 - start) / 60])
    with warnings.catch_warnings():
        # Of the jumps, and of standing, a stride says nothing: it warns of that.
        warnings.simplefilter("ignore", retime.RetimeWarning)
        found = retime.imitate(CLIP, (start, stop), hand).warp
    marks = tuple(np.interp([start / 60, (stop - 1) / 60], found.input_times, found.output_times))
    later = np.diff(np.interp(np.array([512, 547, 581]) / 60, found.input_times, found.output_times))
    assert abs(later[0] - later[1]) > 0.1
    return [Row("Captured", as_it_is(), marks=((start / 60, (stop - 1) / 60),)), Row("Limping", found, marks=(marks,))]


PICTURES: dict[str, Callable[[], list[Row]]] = {
    "shorter": shorter,
    "longer": longer,
    "beat": beat,
    "again": again,
    "limp": limp,
}


def main() -> None:
    """Draw all of them."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else PLACE
    folder.mkdir(parents=True, exist_ok=True)
    for name, picture in PICTURES.items():
        (folder / f"{name}.svg").write_text(drawn(picture()), encoding="utf-8", newline="\n")


if __name__ == "__main__":
    main()
