"""Says why tests are missing, where they are."""

from __future__ import annotations

from importlib.util import find_spec

import pytest


def test_the_server_can_be_tested() -> None:
    missing = [package for package in ("starlette", "uvicorn", "websockets") if find_spec(package) is None]
    if missing:
        pytest.skip(f"the server's tests were left out: they need the extra edit ({', '.join(missing)} not installed)")
    from retime.server.app import Editor

    assert Editor.__doc__
