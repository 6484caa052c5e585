"""The rotation nearest to a matrix, on tuples."""

from mecano.jit.kernel import kernel
from mecano.maths.dual import value
from mecano.maths.vector import EYE, Mat3, Vec3, cross, dot, skew

MOST_ITERATIONS = 50
ROUND_OFF = 1e-30  # of the squared change of an iterate with entries of about 1


@kernel
def inverse(A):
    """Return A^-1 for a 3x3 matrix."""
    a, b, c = cross(A[1], A[2]), cross(A[2], A[0]), cross(A[0], A[1])
    s = 1.0 / dot(A[0], a)
    return Mat3(s * a, s * b, s * c).T


@kernel
def nearest_rotation(B):
    """Return R of the polar decomposition B = R H, H symmetric positive definite, for det B > 0.

    Newton's iteration finds it without slopes, which follow from R^T B = (1 + hat(turn)) H: (tr H - H) turn is twice
    the axial vector of R^T B. Of numbers, this removes round-off.
    """
    R = _iterated(Mat3(value(B[0]), value(B[1]), value(B[2])))
    A = R.T @ B
    H = Mat3(value(A[0]), value(A[1]), value(A[2]))
    turn = inverse((H[0][0] + H[1][1] + H[2][2]) * EYE - H) @ Vec3(
        A[2][1] - A[1][2], A[0][2] - A[2][0], A[1][0] - A[0][1]
    )
    return R + R @ skew(turn)


@kernel
def _iterated(B):
    """Return the rotation nearest to B by X <- (X + X^-T)/2, of second order (Higham 1986), from det X about 1."""
    X = abs(dot(B[0], cross(B[1], B[2]))) ** (-1.0 / 3.0) * B
    for _ in range(MOST_ITERATIONS):
        new = 0.5 * (X + inverse(X).T)
        change = 0.0
        for i in range(3):
            difference = new[i] - X[i]
            change += dot(difference, difference)
        X = new
        if change < ROUND_OFF:
            break
    return X
