"""Which parts are run."""

from __future__ import annotations

import pytest

from retime.errors import OptionError
from study.run import PARTS, chosen_parts


def test_parts_are_chosen_by_name_in_the_studys_order() -> None:
    assert chosen_parts(None) == PARTS
    assert chosen_parts("signals, v4,V1") == ("V1", "V4", "signals")
    with pytest.raises(OptionError, match="no part 'V9'; it has V1, V2"):
        chosen_parts("V1,V9")
    with pytest.raises(OptionError, match="no part of the study is named"):
        chosen_parts(" , ")
