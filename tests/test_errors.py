"""Errors as people read them."""

from __future__ import annotations

from retime.errors import FormatError, OptionError, OutputExistsError


def test_a_message_of_any_length_is_shown_shortly_with_both_its_ends() -> None:
    for error in (
        OptionError(f"no joint is called {'x' * 100_000}; it has Hips"),
        FormatError(f"no joint {'x' * 9000} Hips"),
    ):
        assert len(str(error)) == 2000
        assert str(error).startswith("no joint")
        assert str(error).endswith("xx; it has Hips") or str(error).endswith("xx Hips")
        assert "xx...xx" in str(error)
    assert str(OptionError("x" * 2000)) == "x" * 2000
    assert str(OutputExistsError("a.bvh")).startswith("a.bvh: exists already")
