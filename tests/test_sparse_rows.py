"""Sparse matrices by rows are those of scipy.sparse."""

import numpy as np
import scipy.sparse as sp

from mecano.maths.sparse_rows import sparse_rows


def test_entries_at_one_place_are_added_and_the_product_is_that_of_scipy():
    rng = np.random.default_rng(5)
    n, nnz = 40, 300
    rows, columns, values = rng.integers(0, n, nnz), rng.integers(0, n, nnz), rng.normal(size=nnz)
    rows[rows == 7] = 8  # an empty row
    expected, found = sp.csr_matrix((values, (rows, columns)), shape=(n, n)), sparse_rows(rows, columns, values, n)
    assert len(found.values) == expected.nnz < nnz
    np.testing.assert_array_equal(found.starts, expected.indptr)
    np.testing.assert_array_equal(found.columns, expected.indices)
    np.testing.assert_allclose(found.values, expected.data, rtol=1e-14)
    assert 7 not in found.filled and len(found.filled) == n - 1
    x = rng.normal(size=n)
    np.testing.assert_allclose(found @ x, expected @ x, rtol=1e-12)


def test_a_matrix_without_entries():
    none = sparse_rows([], [], [], 3)
    np.testing.assert_array_equal(none.starts, np.zeros(4))
    np.testing.assert_array_equal(none @ np.ones(3), np.zeros(3))
