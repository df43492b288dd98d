"""Products of matrices in one thread: those that NumPy would find, whatever the shapes."""

from __future__ import annotations

import numpy as np
import pytest

from retime.kernels import compiled_available

pytestmark = pytest.mark.skipif(not compiled_available(), reason="the compiled kernels were not built")


@pytest.mark.parametrize("shape", [(1, 1, 1), (9000, 93, 26), (93, 12_000, 93), (5, 300_000, 2), (3, 0, 2), (0, 4, 2)])
def test_products_in_pieces_are_those_of_whole_matrices(shape: tuple[int, int, int]) -> None:
    from retime.kernels.compiled import _products

    n, depth, m = shape
    generator = np.random.default_rng(n)
    rows, columns = generator.standard_normal((n, depth)), generator.standard_normal((depth, m))
    size = np.abs(rows) @ np.abs(columns)
    assert (np.abs(_products(rows, columns) - rows @ columns) <= 1e-12 * size).all()
