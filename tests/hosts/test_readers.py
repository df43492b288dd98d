"""Curves as other programs write them, and what is wrong with some: said with its place and what would help."""

from __future__ import annotations

import json
import time
import warnings
from fractions import Fraction

import numpy as np
import pytest

from retime import export_curve, import_curve
from retime.errors import FormatError, FormatWarning, OptionError, RetimeWarning
from retime.hosts.bezier import drawn
from retime.hosts.maya import unit_of
from retime.hosts.registry import HOSTS, host_named
from retime.warp.curve import Warp

NUKE = "TimeWarp {{\n inputs 0\n lookup {{{{curve {}}}}}\n name Ramp\n}}\n"
MAYA = """//Maya ASCII 2024 scene
//Name: warp.ma
requires maya "2024";
currentUnit -l centimeter -a degree -t pal;
fileInfo "product" "Maya; 2024";
createNode transform -n "ball";
\tsetAttr ".t" -type "double3" 1 2 3 ;
createNode animCurveTT -n "warp";
\trename -uid "1A2B";
{}connectAttr "warp.o" ":time1.twi";
"""
KTV = '\tsetAttr -s 3 ".ktv[0:2]"  1 1 26 51 51 51;\n'


def read(tmp_path, text: str | bytes, name: str, host: str | None = None, **options):
    place = tmp_path / name
    place.write_bytes(text.encode() if isinstance(text, str) else text)
    return import_curve(place, host, **options)


# Tables.


@pytest.mark.parametrize(
    ("text", "outputs", "inputs"),
    [
        ("output_time,input_time\n0,0\n1.5,3e0\n", [0, 1.5], [0, 3]),
        ("\ufeff0;0\r\n1.5;3\r\n\r\n", [0, 1.5], [0, 3]),
        ('"Output_Time"\t"input_time"\n-1\t.5\n2\t+1.\n', [-1, 2], [0.5, 1]),
        ("output_frame,input_frame\n1,1\n25,13\n", [0, 1], [0, 0.5]),
    ],
)
def test_tables(tmp_path, text, outputs, inputs) -> None:
    warp = read(tmp_path, text, "a.csv", rate=24 if "frame" in text else None, start=1 if "frame" in text else None)
    np.testing.assert_allclose(warp.output_times, outputs)
    np.testing.assert_allclose(warp.input_times, inputs)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "needs two or more keys, found 0"),
        ("0,0\n", "needs two or more keys, found 1"),
        ("0,0\n1,2,3\n", r"a\.csv:2: expected two columns.*with a comma"),
        ("0,0\n1,nan\n", r"a\.csv:2: expected a finite number"),
        ("0,0\n1,1e400\n", r"a\.csv:2: .*too large"),
        ("0,0\n1,1_0\n", r"a\.csv:2: expected a number"),
        ("0,0\n1,1\n1,2\n", r"a\.csv:3: output times must increase: key 2 is at 1 s.*sort the keys"),
        ("0,0\n2,1\n1,2\n", r"a\.csv:3: output times must increase"),
        ("0,0\n1,1e8\n", r"a\.csv:2: key 1: no clip has a time"),
        ("time,value\n0,0\n1,1\n", r"a\.csv:1: expected the columns output_time,input_time"),
        ("x,y\n", r"a\.csv:1: expected the columns"),
        (b"\xff\xfe0,0", "UTF-8"),
        (b"0,0\n\x00", "NUL"),
    ],
)
def test_tables_that_are_none(tmp_path, text, said) -> None:
    with pytest.raises(FormatError, match=said):
        read(tmp_path, text, "a.csv")


def test_frames_need_a_rate(tmp_path) -> None:
    with pytest.raises(OptionError, match="--rate"):
        read(tmp_path, "output_frame,input_frame\n0,0\n1,1\n", "a.csv")
    with pytest.raises(OptionError, match="--rate"):
        read(tmp_path, "1\t1\n2\t2\n", "a.txt")


def test_framecurve(tmp_path) -> None:
    head = "# http://framecurve.org/specification-v1\n# at_frame\tuse_frame_of_source\n"
    text = f"{head}1\t1.00000\n\n11\t3.50000\n21\t21.0\n"
    warp = read(tmp_path, text, "a.framecurve.txt", rate=10)
    np.testing.assert_allclose(warp.output_times, [0, 1, 2])
    np.testing.assert_allclose(warp.input_times, [0, 0.25, 2])
    with pytest.raises(FormatError, match=r"a\.txt:2: expected at_frame and use_frame_of_source.*, found 1 column"):
        read(tmp_path, "1\t1\n2\n", "a.txt", rate=10)


# Nuke.


@pytest.mark.parametrize(
    ("curve", "outputs", "inputs"),
    [
        ("L x1 1 x25 13", [0, 1], [0, 0.5]),
        ("L l x1 1 k x25 13", [0, 1], [0, 0.5]),
        # Without an x a key stands as far on as the one before; the first at 0.
        ("i L 0 12 24", [-1 / 24, 0, 1 / 24], [-1 / 24, 11 / 24, 23 / 24]),
        ("L x1 1 x3 3 9", [0, 2 / 24, 4 / 24], [0, 2 / 24, 8 / 24]),
        # Every frame has a key: what runs between them is of no matter.
        ("x1 1 x2 1.5 x3 1.25", [0, 1 / 24, 2 / 24], [0, 0.5 / 24, 0.25 / 24]),
        ("K x1 1 x2 1.5 L x3 3 x9 3", [0, 1 / 24, 2 / 24, 8 / 24], [0, 0.5 / 24, 2 / 24, 2 / 24]),
    ],
)
def test_nuke(tmp_path, curve, outputs, inputs) -> None:
    warp = read(tmp_path, NUKE.format(curve), "a.nk", rate=24)
    np.testing.assert_allclose(warp.output_times, outputs, atol=1e-12)
    np.testing.assert_allclose(warp.input_times, inputs, atol=1e-12)


@pytest.mark.parametrize(
    ("curve", "said"),
    [
        ("x1 1 x25 13", r"a\.nk:3: from frame 1 to 25 the curve is no line \(smooth\).*Interpolation > Linear"),
        ("L x1 1 K x25 13", r"the curve is no line \(constant\)"),
        ("L x1 1 s0.5 x25 13", r"handles of its own"),
        ("L x1 1 x25 13 t2", r"handles of its own"),
        ("C x1 1 x25 13", r"\(cubic\)"),
        ("L x1 1 xnan 13", r"a\.nk:3: expected a finite number, found 'nan'"),
        ("L x1 1 x5 what", r"a\.nk:3: expected a number, found 'what'"),
        ("L x5 1 x1 2", r"a\.nk:3: output times must increase"),
        ("L x5 1", r"a\.nk:3: a retime curve needs two or more keys"),
        ("", r"a\.nk:3: a retime curve needs two or more keys"),
    ],
)
def test_what_only_nuke_can_draw_is_refused(tmp_path, curve, said) -> None:
    with pytest.raises(FormatError, match=said):
        read(tmp_path, NUKE.format(curve), "a.nk", rate=24)


def test_a_script_without_a_curve(tmp_path) -> None:
    for text in ("Blur {\n size 3\n}\n", "TimeWarp {\n lookup 12\n}\n", ""):
        with pytest.raises(FormatError, match="expected a Nuke script with a TimeWarp with a curve"):
            read(tmp_path, text, "a.nk", rate=24)


@pytest.mark.parametrize(
    "other", ["curve+5 L x1 1 x25 25", "curve*2 L x1 1 x25 25", '"curve + 5" L x1 1 x25 25', "frame/2"]
)
def test_what_nuke_works_out_of_the_keys_is_no_key(tmp_path, other) -> None:
    with pytest.raises(FormatError, match=r"a\.nk:3: the node's lookup is an expression.*generate a key"):
        read(tmp_path, NUKE.replace("curve {}", "{}").format(other), "a.nk", rate=24)


@pytest.mark.parametrize("curve", ["L x1 1 x9 x25 25", "L x1 1 x25 25 x26"])
def test_a_key_of_nuke_without_a_value(tmp_path, curve) -> None:
    with pytest.raises(FormatError, match=r"a\.nk:3: the key at x(9|26) has no value"):
        read(tmp_path, NUKE.format(curve), "a.nk", rate=24)


def test_a_disabled_node_is_told(tmp_path) -> None:
    node = NUKE.format("L x1 1 x25 25")
    with pytest.warns(RetimeWarning, match="the node is disabled"):
        warp = read(tmp_path, node.replace(" name", " disable true\n name"), "a.nk", rate=24)
    assert warp.slopes.tolist() == [1.0]
    # That another node is, is of no matter.
    assert read(tmp_path, f"{node}Blur {{\n disable true\n}}\n", "a.nk", rate=24) == warp


def test_of_several_the_named_one(tmp_path) -> None:
    two = NUKE.format("L x1 1 x25 25") + NUKE.format("L x1 1 x25 49").replace("Ramp", "Fast")
    assert read(tmp_path, two, "a.nk", rate=24, item="Fast").slopes.tolist() == [2.0]
    with pytest.raises(OptionError, match="there are 2 curves, Ramp, Fast: name the one"):
        read(tmp_path, two, "a.nk", rate=24)
    with pytest.raises(OptionError, match="is called Slow; there is Ramp, Fast"):
        read(tmp_path, two, "a.nk", rate=24, item="Slow")


# Maya.


def maya(tmp_path, attributes: str, **options):
    return read(tmp_path, MAYA.format(attributes), "a.ma", **options)


def test_maya_counts_in_the_unit_of_its_file(tmp_path) -> None:
    warp = maya(tmp_path, '\tsetAttr ".tan" 2;\n' + KTV)
    np.testing.assert_allclose(warp.output_times, [0, 1, 2])
    np.testing.assert_allclose(warp.input_times, [0, 2, 2])
    assert unit_of(Fraction(24000, 1001)) == "23.976fps"


def test_maya_s_keys_may_come_in_parts(tmp_path) -> None:
    parts = '\tsetAttr -s 3 ".ktv[0:1]"  1 1 26 \n\t\t51;\n\tsetAttr ".ktv[2]" 51 51;\n\tsetAttr ".tan" 2;\n'
    assert maya(tmp_path, parts) == maya(tmp_path, '\tsetAttr ".tan" 2;\n' + KTV)


def hermite(u, p0, p1, m0, m1):
    return (
        (2 * u**3 - 3 * u**2 + 1) * p0 + (u**3 - 2 * u**2 + u) * m0 + (-2 * u**3 + 3 * u**2) * p1 + (u**3 - u**2) * m1
    )


@pytest.mark.parametrize("tolerance", [0.01, 1e-3, 1e-5])
def test_fixed_and_flat_tangents_are_drawn_by_lines(tmp_path, tolerance) -> None:
    # From a slope of 2 (fixed) to one of 0 (flat), over a second.
    curve = (
        '\tsetAttr ".tan" 2;\n\tsetAttr ".wgt" no;\n\tsetAttr -s 2 ".ktv[0:1]"  1 1 26 26;\n'
        '\tsetAttr -s 2 ".kot[0:1]"  1 2;\n\tsetAttr -s 2 ".kit[0:1]" 2 3;\n'
        '\tsetAttr -s 2 ".kox[0:1]" 0.4472136 1;\n\tsetAttr -s 2 ".koy[0:1]" 0.8944272 0;\n'
    )
    warp = maya(tmp_path, curve, tolerance=tolerance)
    u = np.linspace(0, 1, 5001)
    off = np.abs(warp(u) - hermite(u, 0.0, 1.0, 2.0, 0.0)).max()
    assert off <= tolerance * (1 + 1e-6)
    assert len(warp.output_times) < 3 / np.sqrt(tolerance)


def test_weighted_tangents_are_handles(tmp_path) -> None:
    curve = (
        '\tsetAttr ".tan" 1;\n\tsetAttr ".wgt" yes;\n\tsetAttr -s 2 ".ktv[0:1]"  1 1 26 26;\n'
        '\tsetAttr -s 2 ".kox[0:1]" 1.5 1;\n\tsetAttr -s 2 ".koy[0:1]" 0 0;\n'
        '\tsetAttr -s 2 ".kix[0:1]" 1 1.5;\n\tsetAttr -s 2 ".kiy[0:1]" 0 0;\n'
    )
    warp = maya(tmp_path, curve, tolerance=1e-4)
    u = np.linspace(0, 1, 501)
    x = 3 * (1 - u) ** 2 * u * 0.5 + 3 * (1 - u) * u**2 * 0.5 + u**3
    y = 3 * (1 - u) * u**2 + u**3
    np.testing.assert_allclose(warp(x), y, atol=1.01e-4)


@pytest.mark.parametrize(
    ("attributes", "said"),
    [
        ('\tsetAttr ".tan" 18;\n' + KTV, r"a\.ma:11: the tangent of key 0 is auto: .*Tangents > Fixed"),
        ('\tsetAttr ".tan" 9;\n' + KTV, "is spline"),
        (KTV, "the tangent of key 0 is not said in the file"),
        ('\tsetAttr ".tan" 5;\n' + KTV, "key 0 is stepped, and a warp can't jump"),
        ('\tsetAttr ".tan" 1;\n' + KTV, "fixed, but without its direction"),
        ('\tsetAttr ".tan" 2;\n\tsetAttr -s 3 ".ktv[0:2]"  1 1 26 51 51;\n', r"a\.ma:11: expected pairs"),
        (
            '\tsetAttr ".tan" 2;\n\tsetAttr -s 3 ".ktv[0:2]"  1 1 26 51 26 51;\n',
            r"a\.ma:11: output times must increase",
        ),
        ('\tsetAttr ".tan" 2;\n\tsetAttr -s 3 ".ktv[1:2]"  1 1 26 51;\n', "not numbered"),
        (
            '\tsetAttr ".tan" 2;\n\tsetAttr -s 9 ".ktv[0:8]"  1 1 26 51 51 51;\n',
            r"a\.ma:11: \.ktv\[0:8\] is of 9 keys, found 3: is the file cut off",
        ),
        (f'\tsetAttr ".tan" 2;\n{KTV}\tsetAttr -s 3 ".kot[0:2]" 18;\n', r"\.kot\[0:2\] is of 3 keys, found 1"),
        ('\tsetAttr ".tan" 2;\n\tsetAttr ".ktv[0:1]"  1 1 26 inf;\n', r"a\.ma:11: expected a finite number"),
        (
            f'\tsetAttr ".tan" 1;\n\tsetAttr ".wgt" no;\n{KTV}\tsetAttr -s 2 ".kox[0:1]" 5e-324 1;\n'
            '\tsetAttr -s 2 ".koy[0:1]" 0.9 0;\n',
            r"a\.ma:12: the tangent of key 0 is all but upright",
        ),
        ('\tsetAttr ".tan" 2;\n', "two or more keys"),
        ('\tsetAttr ".tan" "2;\n', r"a text in quotes does not end"),
    ],
)
def test_what_maya_alone_knows_is_refused(tmp_path, attributes, said) -> None:
    with pytest.raises(FormatError, match=said):
        maya(tmp_path, attributes)


def test_a_curve_that_goes_on_beyond_its_keys_is_warned_of(tmp_path) -> None:
    with pytest.warns(RetimeWarning, match="holds its ends"):
        maya(tmp_path, '\tsetAttr ".tan" 2;\n\tsetAttr ".pst" 1;\n' + KTV)


def test_what_is_no_scene(tmp_path) -> None:
    with pytest.raises(FormatError, match=r"begins with //Maya ASCII"):
        read(tmp_path, "createNode animCurveTT;", "a.ma")
    with pytest.raises(FormatError, match="expected a Maya scene with a curve from time to time"):
        read(tmp_path, "//Maya ASCII\n", "a.ma")
    with pytest.raises(FormatError, match=r"Maya's time units \(currentUnit -t\).*, found 'eons'"):
        read(tmp_path, MAYA.format(KTV).replace("-t pal", "-t eons"), "a.ma")
    with pytest.raises(OptionError, match="says itself how it counts"):
        maya(tmp_path, KTV, rate=24)


# FCPXML.

FCPXML = """<?xml version="1.0" encoding="UTF-8"?>
<!DOCTYPE fcpxml>
<fcpxml version="1.11"><project><sequence><spine>
<asset-clip name="Shot 1" duration="20s"><timeMap>{}</timeMap></asset-clip>
</spine></sequence></project></fcpxml>
"""


def test_the_example_of_apple_s_reference(tmp_path) -> None:
    # Half speed forward, then half speed backward.
    points = "".join(
        f'<timept time="{t}" value="{v}" interp="linear"/>' for t, v in (("0s", "0s"), ("10s", "5s"), ("20s", "0s"))
    )
    warp = read(tmp_path, FCPXML.format(points), "a.fcpxml")
    assert (warp.output_times.tolist(), warp.input_times.tolist()) == ([0, 10, 20], [0, 5, 0])
    assert warp.name == "a"


def test_the_time_of_a_map_s_last_frame_is_no_hold(tmp_path) -> None:
    times = ("0s", "0s"), ("23/24s", "1s"), ("1s", "1s")
    text = FCPXML.format("".join(f'<timept time="{t}" value="{v}" interp="linear"/>' for t, v in times))
    assert read(tmp_path, text, "a.fcpxml").output_end == 1.0
    known = text.replace("<project>", '<resources><format id="r1" frameDuration="1/24s"/></resources><project>')
    assert read(tmp_path, known, "a.fcpxml").output_end == pytest.approx(23 / 24)
    held = known.replace('"23/24s"', '"22/24s"')
    assert read(tmp_path, held, "a.fcpxml").output_end == 1.0


@pytest.mark.parametrize(
    ("points", "said"),
    [
        ('<timept time="0s" value="0s"/>', r'a\.fcpxml:4: a timept with interp="smooth2" is a spline'),
        ('<timept time="0s" value="0s" interp="smooth"/>', 'interp="smooth"'),
        ('<timept time="0" value="0s" interp="linear"/>', r"a\.fcpxml:4: time: expected rational seconds .*found '0'"),
        ('<timept time="0s" value="1/0s" interp="linear"/>', r"value: expected rational seconds"),
        ('<timept time="0s" interp="linear"/>', r"value: expected rational seconds.*found None"),
        ("", r"a\.fcpxml:4: a retime curve needs two or more keys"),
        ("<timept", r"a\.fcpxml:4:\d+: not XML"),
    ],
)
def test_maps_that_are_none(tmp_path, points, said) -> None:
    with pytest.raises(FormatError, match=said):
        read(tmp_path, FCPXML.format(points), "a.fcpxml")


def test_a_disabled_clip_is_told(tmp_path) -> None:
    points = "".join(f'<timept time="{t}s" value="{t}s" interp="linear"/>' for t in (0, 1))
    with pytest.warns(RetimeWarning, match="the clip is disabled"):
        warp = read(tmp_path, FCPXML.format(points).replace("<asset-clip", '<asset-clip enabled="0"'), "a.fcpxml")
    assert warp.slopes.tolist() == [1.0]


def test_entities_are_not_expanded_and_no_other_file_is_opened(tmp_path) -> None:
    (tmp_path / "secret").write_text("0s")
    bomb = '<!DOCTYPE fcpxml [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;">]><fcpxml>&b;</fcpxml>'
    outside = f'<!DOCTYPE fcpxml [<!ENTITY a SYSTEM "file://{tmp_path}/secret">]><fcpxml>&a;</fcpxml>'
    for text in (bomb, outside):
        with pytest.raises(FormatError, match="declares types or entities of its own"):
            read(tmp_path, text, "a.fcpxml")
    with pytest.raises(FormatError, match="not XML: undefined entity"):
        read(tmp_path, "<fcpxml>&a;</fcpxml>", "a.fcpxml")
    elsewhere = f'<!DOCTYPE fcpxml SYSTEM "file://{tmp_path}/secret"><fcpxml/>'
    with pytest.raises(FormatError, match="expected FCPXML with a clip"):
        read(tmp_path, elsewhere, "a.fcpxml")


def test_depth_and_other_documents_are_refused(tmp_path) -> None:
    with pytest.raises(FormatError, match="100 inside each other"):
        read(tmp_path, "<a>" * 200, "a.fcpxml")
    with pytest.raises(FormatError, match="expected a document of fcpxml, found 'xmeml'"):
        read(tmp_path, "<xmeml/>", "a.fcpxml")
    with pytest.raises(FormatError, match="not XML"):
        read(tmp_path, "", "a.fcpxml")
    with pytest.raises(FormatError, match="not XML"):
        read(tmp_path, '<?xml version="1.0" encoding="klingon"?><fcpxml/>', "a.fcpxml")


# OpenTimelineIO.


def otio(pieces, kind: str = "Video") -> str:
    def moment(value):
        return {"OTIO_SCHEMA": "RationalTime.1", "rate": 24.0, "value": value}

    children = []
    for start, length, speed in pieces:
        if start is None:
            children.append(
                {"OTIO_SCHEMA": "Gap.1", "source_range": {"start_time": moment(0), "duration": moment(length)}}
            )
            continue
        effects = [] if speed == 1 else [{"OTIO_SCHEMA": "LinearTimeWarp.1", "time_scalar": speed}]
        children.append(
            {
                "OTIO_SCHEMA": "Clip.1",
                "source_range": {"start_time": moment(start), "duration": moment(length)},
                "effects": effects,
                "media_reference": {
                    "OTIO_SCHEMA": "ExternalReference.1",
                    "target_url": "a.mov",
                    "available_range": None,
                },
            }
        )
    track = {"OTIO_SCHEMA": "Track.1", "kind": kind, "name": "V1", "children": children}
    return json.dumps({"OTIO_SCHEMA": "Timeline.1", "tracks": {"OTIO_SCHEMA": "Stack.1", "children": [track]}})


def test_pieces_of_a_timeline(tmp_path) -> None:
    warp = read(tmp_path, otio([(0, 24, 1), (24, 24, 0), (24, 25, -0.5)]), "a.otio")
    np.testing.assert_allclose(warp.output_times, [0, 1, 2, 3])
    np.testing.assert_allclose(warp.input_times, [0, 1, 1, 0.5])


def test_pieces_on_whole_frames_meet_as_near_as_they_can(tmp_path) -> None:
    with pytest.warns(RetimeWarning, match=r"meet up to 0\.3 frames apart"):
        warp = read(tmp_path, otio([(0, 11, 1.3), (14, 12, 1)]), "a.otio")
    np.testing.assert_allclose(warp.input_times * 24, [0, 14, 25])


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (otio([(0, 24, 1), (48, 24, 1)]), "piece 2 of the track begins 24 frames from where the one before it ends"),
        (otio([(0, 24, 1), (None, 24, 1)]), "piece 2 of the track is a Gap"),
        (otio([(0, 0, 1)]), "lasts 0 s"),
        (otio([(0, 1, 1)]), "two or more keys"),
        (otio([(None, 24, 1)]), "the track has no clip"),
        (otio([(0, 24, 1)], "Audio"), "with a video track"),
        (otio([(0, 24, 1)]).replace("LinearTimeWarp.1", "TimeEffect.1").replace("a.mov", "b.mov"), None),
        (otio([(0, 24, 2)]).replace("LinearTimeWarp.1", "TimeEffect.1"), "curve is not in the file"),
        (otio([(0, 24, 1)]).replace('"rate": 24.0', '"rate": 0'), "no time counts 0"),
        (otio([(0, 24, 1)]).replace('"value": 24', '"value": "24"'), "value: expected a number"),
        (otio([(0, 24, 1)]).replace('"value": 24', '"value": NaN'), "NaN"),
        (otio([(0, 24, 1)]).replace('"Clip.1"', '"Clip.1", "enabled": false'), "piece 1 of the track is switched off"),
        ("[]", "expected an OpenTimelineIO timeline"),
        ("{", "not JSON"),
    ],
)
def test_timelines_that_are_no_warp(tmp_path, text, said) -> None:
    if said is None:
        assert read(tmp_path, text, "a.otio").slopes.tolist() == [1.0]
        return
    with pytest.raises(FormatError, match=said):
        read(tmp_path, text, "a.otio")


@pytest.mark.parametrize("kind", ["Track.1", "Stack.1"])
@pytest.mark.parametrize(
    ("field", "value", "said"),
    [
        (
            "effects",
            [{"OTIO_SCHEMA": "LinearTimeWarp.1", "time_scalar": 2.0}],
            "has a time effect, and a warp is read from",
        ),
        ("effects", [{"OTIO_SCHEMA": "FreezeFrame.1"}], "has a time effect, and a warp is read from"),
        ("enabled", False, "is switched off"),
        ("source_range", (12, 24), "shows a part of its clips alone"),
        ("source_range", (0, 47), "shows a part of its clips alone"),
    ],
)
def test_what_is_done_to_all_clips_at_once_is_no_warp_of_a_clip(tmp_path, kind, field, value, said) -> None:
    def moment(number):
        return {"OTIO_SCHEMA": "RationalTime.1", "rate": 24.0, "value": number}

    def changed(value) -> str:
        if field == "source_range":
            value = {"start_time": moment(value[0]), "duration": moment(value[1])}
        document = json.loads(otio([(0, 24, 1), (24, 24, 2)]))
        stack = document["tracks"]
        (stack if kind == "Stack.1" else stack["children"][0])[field] = value
        return json.dumps(document)

    with pytest.raises(FormatError, match=f"a\\.otio: the {kind[:5].lower()} '.*' {said}"):
        read(tmp_path, changed(value), "a.otio")
    # What changes nothing is no matter.
    plain = {"effects": [{"OTIO_SCHEMA": "Effect.1"}], "enabled": True, "source_range": (0, 48)}[field]
    assert read(tmp_path, changed(plain), "a.otio") == read(tmp_path, otio([(0, 24, 1), (24, 24, 2)]), "a.otio")


def test_gaps_before_the_first_clip_add_up(tmp_path) -> None:
    warp = read(tmp_path, otio([(None, 24, 1), (None, 12, 1), (0, 25, 1)]), "a.otio")
    assert warp.output_times.tolist() == pytest.approx([1.5, 2.5])


def test_an_effect_that_is_switched_off_does_nothing(tmp_path) -> None:
    text = otio([(0, 24, 2)]).replace('"LinearTimeWarp.1"', '"LinearTimeWarp.1", "enabled": false')
    assert read(tmp_path, text, "a.otio").slopes.tolist() == pytest.approx([1.0])


def test_two_clips_are_no_warp(tmp_path) -> None:
    text = otio([(0, 24, 1), (24, 24, 1)])
    with pytest.raises(FormatError, match=r"piece 2 of the track shows other media, 'b\.mov'"):
        read(tmp_path, "b.mov".join(text.rsplit("a.mov", 1)), "a.otio")


# Lottie.


def lottie(*keys, rate=24) -> str:
    layer = {"ty": 0, "nm": "walk", "refId": "c", "tm": {"a": 1, "k": list(keys)}}
    return json.dumps({"fr": rate, "layers": [layer], "assets": [{"id": "c", "layers": []}]})


def key(t, s, o=(0, 0), i=(1, 1), **more):
    return {"t": t, "s": [s], "o": {"x": [o[0]], "y": [o[1]]}, "i": {"x": [i[0]], "y": [i[1]]}, **more}


def test_lottie_s_lines_holds_and_curves(tmp_path) -> None:
    warp = read(tmp_path, lottie(key(0, 0), key(24, 2, h=1), key(48, 2), {"t": 72, "s": 1}), "a.json")
    assert (warp.output_times.tolist(), warp.input_times.tolist()) == ([0, 1, 2, 3], [0, 2, 2, 1])
    eased = read(tmp_path, lottie(key(0, 0, (0.42, 0), (0.58, 1)), key(24, 1)), "a.json", tolerance=1e-4)
    u = np.linspace(0, 1, 301)
    x = 3 * (1 - u) ** 2 * u * 0.42 + 3 * (1 - u) * u**2 * 0.58 + u**3
    np.testing.assert_allclose(eased(x), 3 * (1 - u) * u**2 + u**3, atol=1.01e-4)
    old = read(tmp_path, lottie({**key(0, 0), "e": [2]}, {"t": 24}), "a.json")
    assert old.input_times.tolist() == [0, 2]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (lottie(key(0, 0, h=1), key(24, 2)), "key 0 holds and then jumps from 0 to 2 s"),
        (lottie(key(0, 0), key(0, 2)), "output times must increase"),
        (lottie(key(0, 0)), "two or more keys"),
        (lottie(key(0, 0, (1.5, 0), (0.5, 1)), key(24, 2)), "key 0: a handle reaches beyond"),
        (lottie(key(0, 0), key(True, 2)), "key 1, t: expected a number, found True"),
        (lottie(key(0, 0), {"t": 24}), "key 1, s: expected a number, found None"),
        (lottie(key(0, 0), key(24, 2), rate=0), "fr: no composition has 0"),
        (lottie(key(0, 0), key(24, 10**400)), "whole number has too many|a time can be"),
        ('{"fr": 24, "layers": [{"tm": {"a": 0, "k": 3}}]}', "holds one moment"),
        ('{"fr": 24, "layers": []}', "layer with a time remap"),
        ('{"format": "retime-warp"}', "expected a composition of Lottie.*a warp of retime already"),
        (
            json.dumps(
                {"fr": 24, "layers": [{"tm": {"a": 1, "k": [key(0, 0), key(24, 2)], "x": "var $bm_rt = time;"}}]}
            ),
            "has an expression.*Convert Expression to Keyframes",
        ),
    ],
)
def test_remaps_that_are_no_warp(tmp_path, text, said) -> None:
    with pytest.raises(FormatError, match=said):
        read(tmp_path, text, "a.json")


def test_a_curve_needs_an_error_that_is_allowed(tmp_path) -> None:
    eased = lottie(key(0, 0, (0.42, 0), (0.58, 1)), key(24, 1))
    with pytest.raises(FormatError, match="allow an error"):
        read(tmp_path, eased, "a.json", tolerance=0)
    with pytest.raises(FormatError, match="too steep"):
        drawn(np.array([0.0, 1, 0, 1]), np.array([0.0, 0, 1e7, 1e7]), 1e-9, {})
    with pytest.raises(OptionError, match="the tolerance must be"):
        read(tmp_path, eased, "a.json", tolerance=-1)


# ffmpeg.


def test_a_file_of_filters_is_one_line_without_comments(tmp_path) -> None:
    # ffmpeg would take a comment for a filter's name.
    export_curve(Warp([0.0, 1.0, 2.0], [0.0, 0.5, 3.0]), tmp_path / "a.txt", "ffmpeg", rate=24)
    assert (tmp_path / "a.txt").read_text() == (
        "settb=AVTB,trim=start=0:end=3.020833333333,tpad=stop=-1:stop_mode=clone,setpts='PTS-0.020833333333/TB',"
        "setpts='max(0,if(lt(T,0.5),0+(T-0)*2,1+(T-0.5)*0.40000000000000002))/TB',"
        "fps=24:start_time=0:round=up,trim=end_frame=49\n"
    )


# All of them.


def test_whose_curve_it_is_is_told_by_the_ending_or_by_the_user(tmp_path) -> None:
    with pytest.raises(FormatError, match=r"none of \.nk \(nuke\), .*name the host"):
        read(tmp_path, "", "a.dat")
    with pytest.raises(OptionError, match="a curve for houdini can be written, not read; read are nuke"):
        read(tmp_path, "", "a.chan", host="houdini")
    assert read(tmp_path, "0,0\n1,1\n", "a.dat", host="csv").slopes.tolist() == [1.0]
    with pytest.raises(OptionError, match="--start would have no effect"):
        read(tmp_path, "", "a.fcpxml", start=3)


@pytest.mark.parametrize("option", [{"rate": 24}, {"start": 1}, {"rate": 24, "start": 1}])
def test_a_table_that_is_read_as_seconds_is_not_told_to_count_frames(tmp_path, option) -> None:
    # Frames without a line of names would be taken for seconds, without a word.
    said = ", ".join(f"--{name}" for name in option)
    with pytest.raises(OptionError, match=f"{said} would have no effect.*output_frame,input_frame"):
        read(tmp_path, "1,1\n25,49\n", "a.csv", **option)
    named = read(tmp_path, "output_frame,input_frame\n1,1\n25,49\n", "a.csv", rate=24, start=1)
    assert (named.output_times.tolist(), named.input_times.tolist()) == ([0.0, 1.0], [0.0, 2.0])


@pytest.mark.parametrize(
    ("name", "text", "rate", "said"),
    [
        ("a.nk", NUKE.format("L x1001 1001 x1025 1060"), 24, r"at frame 1001, 41\.67 s after frame 1.*--start 1001\)"),
        ("a.framecurve.txt", "101\t130\n125\t170\n", 25, r"at frame 101, 4 s after frame 1.*--start 101\)"),
        ("a.csv", "output_frame,input_frame\n86400,86410\n86500,86600\n", 24, r"--start 86400\)"),
    ],
)
def test_a_curve_far_from_a_first_frame_that_nobody_named_is_told(tmp_path, name, text, rate, said) -> None:
    host = {"a.framecurve.txt": "framecurve"}.get(name)
    with pytest.warns(FormatWarning, match=said):
        late = read(tmp_path, text, name, host=host, rate=rate)
    start = int(said.split("--start ")[1].rstrip("\\)"))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        named = read(tmp_path, text, name, host=host, rate=rate, start=start)
        # What is said is done, be it odd.
        read(tmp_path, text, name, host=host, rate=rate, start=1)
    assert named.output_start == pytest.approx(0.0, abs=1e-9)
    np.testing.assert_allclose(np.diff(named.input_times), np.diff(late.input_times))


def test_a_curve_near_the_first_frame_is_read_without_a_word(tmp_path) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        read(tmp_path, NUKE.format("L x1 1 x49 97"), "a.nk", rate=24)
        # It shows the clip from its beginning, only later.
        read(tmp_path, NUKE.format("L x101 1 x149 97"), "a.nk", rate=24)
        read(tmp_path, "10,10\n12,14\n", "a.csv")


@pytest.mark.parametrize("name", [host.name for host in HOSTS if host.imports])
def test_options_that_a_curve_has_no_use_for_are_refused(tmp_path, name) -> None:
    host = host_named(name)
    place = tmp_path / f"a{host.suffixes[0]}"
    export_curve(Warp([0.0, 1.0, 2.0], [0.0, 2.0, 2.0]), place, name, rate=24)
    told = {} if host.says_rate or name == "csv" else {"rate": 24}
    assert float(import_curve(place, name, **told)(2.0)) == pytest.approx(2.0)
    if host.bends:
        import_curve(place, name, tolerance=0.1, **told)
    else:
        with pytest.raises(OptionError, match="--tolerance would have no effect"):
            import_curve(place, name, tolerance=0.1, **told)
    with pytest.raises(OptionError, match="is called other; there is" if host.takes_item else "--item would have no"):
        import_curve(place, name, item="other", **told)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.ma", "//Maya ASCII\ncreateNode animCurveTT;\n" + '\\"' * 200_000),
        ("a.ma", "//Maya ASCII\n" + "x " * 500_000),
        ("a.ma", "//Maya ASCII\ncreateNode animCurveTT;\n" + 'setAttr ".pre" 0;\n' * 100_000),
        ("a.nk", NUKE.format("L " + "x1 1 " * 300_000)),
        ("a.nk", "TimeWarp {\n" * 100_000),
        ("a.nk", " lookup {{curve" * 100_000),
        ("a.fcpxml", "<fcpxml>" + "<timeMap/>" * 200_000 + "</fcpxml>"),
        ("a.fcpxml", "<fcpxml>" + "x" * 5_000_000),
        ("a.json", '{"fr": 24, "layers": [' + ",".join(['{"tm": 1}'] * 100_000) + "]}"),
    ],
    ids=range(9),
)
def test_long_nonsense_is_refused_soon(tmp_path, name, text) -> None:
    begun = time.monotonic()
    with pytest.raises((FormatError, OptionError)):
        read(tmp_path, text, name, **({"rate": 24} if name == "a.nk" else {}))
    # Reading that grows with the square of the length would take minutes.
    assert time.monotonic() - begun < 20
