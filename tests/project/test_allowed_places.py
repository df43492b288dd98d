"""Where the editor may read and write."""

from __future__ import annotations

import pytest

from retime.errors import OptionError
from retime.project.allowed_places import AllowedPlaces


def test_places_are_compared_part_by_part_with_links_followed(tmp_path) -> None:
    inside, beside = tmp_path / "clips", tmp_path / "clips2"
    for folder in (inside, beside):
        folder.mkdir()
        (folder / "a.bvh").touch()
    (inside / "way_out").symlink_to(beside)
    (inside / "a_link.bvh").symlink_to(beside / "a.bvh")
    places = AllowedPlaces([inside], [beside / "named.bvh"])
    assert places.find("a.bvh") == inside / "a.bvh"
    assert places.find(inside / "new.bvh") == inside / "new.bvh"
    assert places.find(beside / "named.bvh", reading=True) == beside / "named.bvh"
    for path in (
        beside / "a.bvh",
        beside / "named.bvh",
        "../clips2/a.bvh",
        "way_out/a.bvh",
        "a_link.bvh",
        "/etc/passwd",
        "~root/a.bvh",
        "a\0.bvh",
        "~nobody knows/a.bvh",
    ):
        with pytest.raises(OptionError, match=r"outside the folders|no path"):
            places.find(path)


def test_a_refusal_says_what_to_type(tmp_path) -> None:
    here, one, two = (tmp_path / name for name in ("here", "my clips", "more"))
    places = AllowedPlaces([here], command=["retime", "edit", "--project", "p.retime"])
    with pytest.raises(OptionError) as found:
        places.find(one / "a.bvh", beside=[one / "b.bvh", here / "c.bvh", two / "d.bvh"])
    assert str(found.value).endswith(f"type: retime edit --project p.retime --folder '{one}' --folder {two}")
    # Of a folder it is the folder itself, not the one that it is in; what is no path does not stand in the way.
    with pytest.raises(OptionError, match=f"--folder {two}$"):
        places.find(two, beside=["a\0.bvh", "~nobody knows/a.bvh"])
    with pytest.raises(OptionError, match=r"os\.chdir"):
        AllowedPlaces([here]).find(one / "a.bvh")
