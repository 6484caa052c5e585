"""Vectors and matrices in three dimensions with operators: passed by value, without heap memory, fast to compile.

``a + b``, ``s * a``, ``a / s``, ``A @ b``, ``A @ B``, ``A.T``; ``dot``, ``cross``, ``norm``. Components are numbers or
Duals. ``vec`` and ``mat`` read from arrays; the ``add_*`` functions add to arrays.
"""

import operator
from typing import NamedTuple

from mecano.jit.kernel import kernel
from mecano.jit.methods import Generic, algebraic, attribute, method
from mecano.maths.dual import NUMBER, Dual, number, select, sqrt, value

SCALAR = (NUMBER, Dual)


@algebraic
class Vec3(NamedTuple):
    """A vector (3,)."""

    x: float
    y: float
    z: float


@algebraic
class Mat3(NamedTuple):
    """A matrix (3, 3), by rows."""

    x: Vec3
    y: Vec3
    z: Vec3


ZERO = Vec3(0.0, 0.0, 0.0)
EYE = Mat3(Vec3(1.0, 0.0, 0.0), Vec3(0.0, 1.0, 0.0), Vec3(0.0, 0.0, 1.0))


def _by_components(kind):
    """Define sums, differences and multiples of vectors, or of matrices by their rows."""

    @method(operator.add, kind, kind)
    def _(a, b):
        return kind(a[0] + b[0], a[1] + b[1], a[2] + b[2])

    @method(operator.sub, kind, kind)
    def _(a, b):
        return kind(a[0] - b[0], a[1] - b[1], a[2] - b[2])

    @method(operator.neg, kind)
    def _(a):
        return kind(-a[0], -a[1], -a[2])

    @method(operator.mul, SCALAR, kind)
    def _(a, b):
        return kind(a * b[0], a * b[1], a * b[2])

    @method(operator.mul, kind, SCALAR)
    def _(a, b):
        return kind(a[0] * b, a[1] * b, a[2] * b)

    @method(operator.truediv, kind, SCALAR)
    def _(a, b):
        return (1.0 / b) * a


_by_components(Vec3)
_by_components(Mat3)


@method(value, Vec3)
def _(a):
    return Vec3(value(a[0]), value(a[1]), value(a[2]))


@method(select, NUMBER, Vec3, Vec3)
def _(condition, a, b):
    return Vec3(*(select(condition, one, other) for one, other in zip(a, b, strict=True)))


@method(operator.matmul, Mat3, Vec3)
def _(a, b):
    return Vec3(_dot(a[0], b), _dot(a[1], b), _dot(a[2], b))


def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@method(operator.matmul, Mat3, Mat3)
def _(a, b):
    columns = b.T
    return Mat3(columns @ a[0], columns @ a[1], columns @ a[2])


@attribute(Mat3, "T")
def transpose(a):
    """Return the transpose."""
    return Mat3(Vec3(a[0][0], a[1][0], a[2][0]), Vec3(a[0][1], a[1][1], a[2][1]), Vec3(a[0][2], a[1][2], a[2][2]))


@kernel
def vec(a, i):
    """Return the Vec3 a[i:i+3] of a flat array."""
    return Vec3(number(a[i]), number(a[i + 1]), number(a[i + 2]))


@kernel
def mat(A):
    """Return the Mat3 of an array (3, 3)."""
    return Mat3(Vec3(A[0, 0], A[0, 1], A[0, 2]), Vec3(A[1, 0], A[1, 1], A[1, 2]), Vec3(A[2, 0], A[2, 1], A[2, 2]))


@Generic
def dot(a, b):
    """Return a . b"""
    return _dot(a, b)


@Generic
def cross(a, b):
    """Return a x b"""
    return Vec3(a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


@Generic
def norm(a):
    """Return |a|"""
    return sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2])


@Generic
def outer(a, b):
    """Return a b^T"""
    return Mat3(a[0] * b, a[1] * b, a[2] * b)


@Generic
def skew(a):
    """Return hat(a), the matrix of v -> a x v"""
    return Mat3(Vec3(0.0, -a[2], a[1]), Vec3(a[2], 0.0, -a[0]), Vec3(-a[1], a[0], 0.0))


@Generic
def cross_columns(A, b):
    """Return A hat(b) for a Mat3 A: its rows crossed with b"""
    return Mat3(cross(A[0], b), cross(A[1], b), cross(A[2], b))


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
def put_matrix(out, A):
    """out[:, :] = A"""
    for i in range(3):
        put(out[i], 0, A[i])


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
