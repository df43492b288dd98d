"""Every test of scores and paths runs on each backend that is there."""

from __future__ import annotations

import pytest

from retime.kernels import BACKENDS, Backend, backend, compiled_available


@pytest.fixture(params=BACKENDS)
def kernels(request: pytest.FixtureRequest) -> Backend:
    if request.param == "compiled" and not compiled_available():
        pytest.skip("the compiled kernels were not built")
    return backend(request.param)


@pytest.fixture
def both() -> tuple[Backend, Backend]:
    if not compiled_available():
        pytest.skip("the compiled kernels were not built")
    return backend("compiled"), backend("numpy")
