"""Vectors and matrices of three dimensions as nested tuples: values, no heap, quick to compile.

A 3-vector is ``(a0, a1, a2)``, a 3x3 matrix a tuple of three rows. ``vec`` and ``mat`` read them from
arrays; the ``add_*`` functions add them into arrays.
"""

import math

from mecano.compiled.kernel import kernel

ZERO = (0.0, 0.0, 0.0)
EYE = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


@kernel
def vec(a, i):
    """The 3-vector a[i:i+3] of a flat array."""
    return (a[i], a[i + 1], a[i + 2])


@kernel
def mat(A):
    """The 3x3 matrix of an array (3, 3)."""
    return (
        (A[0, 0], A[0, 1], A[0, 2]),
        (A[1, 0], A[1, 1], A[1, 2]),
        (A[2, 0], A[2, 1], A[2, 2]),
    )


@kernel
def add(a, b):
    """a + b for 3-vectors."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


@kernel
def sub(a, b):
    """a - b for 3-vectors."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


@kernel
def scale(s, a):
    """s a for a 3-vector."""
    return (s * a[0], s * a[1], s * a[2])


@kernel
def dot(a, b):
    """a . b"""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel
def cross(a, b):
    """a x b"""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


@kernel
def norm(a):
    """|a|"""
    return math.sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2])


@kernel
def mul(A, v):
    """A v"""
    return (dot(A[0], v), dot(A[1], v), dot(A[2], v))


@kernel
def tmul(A, v):
    """A^T v"""
    return (
        A[0][0] * v[0] + A[1][0] * v[1] + A[2][0] * v[2],
        A[0][1] * v[0] + A[1][1] * v[1] + A[2][1] * v[2],
        A[0][2] * v[0] + A[1][2] * v[1] + A[2][2] * v[2],
    )


@kernel
def transpose(A):
    """A^T"""
    return (
        (A[0][0], A[1][0], A[2][0]),
        (A[0][1], A[1][1], A[2][1]),
        (A[0][2], A[1][2], A[2][2]),
    )


@kernel
def matmul(A, B):
    """A B"""
    return (tmul(B, A[0]), tmul(B, A[1]), tmul(B, A[2]))


@kernel
def madd(A, B):
    """A + B for 3x3 matrices."""
    return (add(A[0], B[0]), add(A[1], B[1]), add(A[2], B[2]))


@kernel
def mscale(s, A):
    """s A for a 3x3 matrix."""
    return (scale(s, A[0]), scale(s, A[1]), scale(s, A[2]))


@kernel
def outer(a, b):
    """a b^T"""
    return (scale(a[0], b), scale(a[1], b), scale(a[2], b))


@kernel
def skew(a):
    """hat(a): the matrix of v -> a x v."""
    return ((0.0, -a[2], a[1]), (a[2], 0.0, -a[0]), (-a[1], a[0], 0.0))


@kernel
def cross_columns(A, b):
    """A hat(b) for a 3x3 matrix A: its rows crossed with b."""
    return (cross(A[0], b), cross(A[1], b), cross(A[2], b))


@kernel
def add_vec(out, i, s, a):
    """out[i:i+3] += s a"""
    out[i] += s * a[0]
    out[i + 1] += s * a[1]
    out[i + 2] += s * a[2]


@kernel
def put(out, i, a):
    """out[i:i+3] = a"""
    out[i] = a[0]
    out[i + 1] = a[1]
    out[i + 2] = a[2]


@kernel
def add_mat(out, i, j, s, A):
    """out[i:i+3, j:j+3] += s A"""
    out[i, j] += s * A[0][0]
    out[i, j + 1] += s * A[0][1]
    out[i, j + 2] += s * A[0][2]
    out[i + 1, j] += s * A[1][0]
    out[i + 1, j + 1] += s * A[1][1]
    out[i + 1, j + 2] += s * A[1][2]
    out[i + 2, j] += s * A[2][0]
    out[i + 2, j + 1] += s * A[2][1]
    out[i + 2, j + 2] += s * A[2][2]


@kernel
def add_row(out, i, j, s, a):
    """out[i, j:j+3] += s a"""
    out[i, j] += s * a[0]
    out[i, j + 1] += s * a[1]
    out[i, j + 2] += s * a[2]


@kernel
def add_col(out, i, j, s, a):
    """out[i:i+3, j] += s a"""
    out[i, j] += s * a[0]
    out[i + 1, j] += s * a[1]
    out[i + 2, j] += s * a[2]
