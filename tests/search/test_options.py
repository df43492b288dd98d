"""Options stand once: what else speaks of them agrees with the declaration."""

from __future__ import annotations

import inspect
import re
from typing import Any

import numpy as np
import pytest

from retime.errors import OptionError
from retime.search import options
from retime.search.guided import guided_warp
from retime.search.options import OPTIONS
from retime.search.session import Session

# What guided_warp takes beside options.
DATA = ("motion", "reference", "keys", "locks", "flights")


def test_guided_warp_has_every_option_with_its_default() -> None:
    signature = inspect.signature(guided_warp).parameters
    assert {name: parameter.default for name, parameter in signature.items() if name not in DATA} == {
        option.name: option.default for option in OPTIONS
    }


def test_guided_warp_documents_every_option() -> None:
    documented = re.findall(r"^(\w[\w, ]*) : ", inspect.getdoc(guided_warp) or "", flags=re.M)
    assert [name for names in documented for name in names.split(", ")] == list(
        inspect.signature(guided_warp).parameters
    )


def test_names_and_flags_are_unique() -> None:
    assert len({option.name for option in OPTIONS}) == len(OPTIONS)
    assert len({option.on_command_line for option in OPTIONS}) == len(OPTIONS)


@pytest.mark.parametrize("option", OPTIONS, ids=lambda option: option.name)
def test_a_declaration_is_whole(option: options.Option) -> None:
    assert option.help.endswith(".")
    assert option.label
    assert option.hint
    assert (option.kind == "choice") == bool(option.choices)
    assert option.usual or option.default is not None
    assert option.checked(option.default) == option.default


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"n_neighbors": 0}, "n_neighbors must be at least 1, found 0"),
        ({"n_neighbors": 2.5}, "n_neighbors must be a whole number, found the number 2.5"),
        ({"n_neighbors": "3"}, "n_neighbors must be a whole number, found the text '3'"),
        ({"n_neighbors": True}, "n_neighbors must be a whole number, found "),
        ({"time_scale": -1.0}, "the time scale must be at least 0, found -1.0"),
        ({"time_scale": float("nan")}, "the time scale must be a number, found nan"),
        ({"low_pass": None}, "the low pass must be a number, found None"),
        ({"score": "third"}, "score must be one of joint, conditional; found 'third'"),
        ({"smoothnes": 1}, "there is no option 'smoothnes'; there are "),
        ({"smoothness": 1}, "there is no option 'smoothness'; there are "),
    ],
)
def test_wrong_values_are_refused_by_name(given: dict[str, Any], says: str) -> None:
    with pytest.raises(OptionError, match=re.escape(says)):
        Session(np.sin(np.arange(60.0)), **{"rate": 30, **given})


def test_bounds_of_a_solve_are_checked() -> None:
    session = Session(np.sin(np.arange(60.0)), rate=30)
    for given, name in [({"max_skip": 0}, "max_skip"), ({"loop": 1}, "loop"), ({"smoothness": -1}, "smoothness")]:
        with pytest.raises(OptionError) as caught:
            session.solve(**given)
        assert caught.value.option == name


def test_numpy_numbers_are_numbers() -> None:
    session = Session(np.sin(np.arange(60.0)), rate=30, n_neighbors=np.int64(4), time_scale=np.float32(0.25))
    assert session.solve(length="80%", max_skip=np.int32(6)).max_skip == 6
