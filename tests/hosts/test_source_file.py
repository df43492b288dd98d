"""Files of clips, as documents for other programs name them."""

from __future__ import annotations

import pytest

from retime import Warp, export_curve
from retime.hosts.source_file import address, file_name_of, name_of


@pytest.mark.parametrize(
    ("source", "where", "name", "file_name"),
    [
        ("walk.mov", "./walk.mov", "walk", "walk.mov"),
        ("takes/a b#1?.mov", "./takes/a%20b%231%3F.mov", "a b#1?", "a b#1?.mov"),
        (
            "/shots/\u6620\u753b 50%.mov",
            "file:///shots/%E6%98%A0%E7%94%BB%2050%25.mov",
            "\u6620\u753b 50%",
            "\u6620\u753b 50%.mov",
        ),
        (r"C:\shots\a b.mov", "file:///C:/shots/a%20b.mov", "a b", "a b.mov"),
        ("D:/shots/a.mov", "file:///D:/shots/a.mov", "a", "a.mov"),
        (r"\\farm\shots\a b.mov", "file://farm/shots/a%20b.mov", "a b", "a b.mov"),
        ("file:///shots/a%20b.mov", "file:///shots/a%20b.mov", "a b", "a b.mov"),
        ("https://farm/take%201.mov?v=2", "https://farm/take%201.mov?v=2", "take 1", "take 1.mov"),
        ("a:b", "./a%3Ab", "a:b", "a:b"),
        ("/", "file:///", "/", "/"),
        ("https://farm", "https://farm", "https://farm", "https://farm"),
    ],
)
def test_addresses_and_names(source, where, name, file_name) -> None:
    assert (address(source), name_of(source), file_name_of(source)) == (where, name, file_name)


@pytest.mark.parametrize(("host", "ending"), [("fcpxml", ".fcpxml"), ("premiere", ".xml"), ("otio", ".otio")])
def test_a_clip_on_windows_is_named_by_its_file_alone(tmp_path, host, ending) -> None:
    place = tmp_path / f"a{ending}"
    export_curve(Warp([0.0, 1.0], [0.0, 2.0]), place, host, rate=24, item=r"C:\shots\a b.mov")
    text = place.read_text()
    assert "retimed a b" in text
    assert ("C:\\\\shots" if host == "otio" else "file:///C:/shots/a%20b.mov") in text
