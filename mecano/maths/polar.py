"""The rotation nearest to a matrix, on tuples."""

from mecano.jit.kernel import kernel
from mecano.maths.vector import Mat3, cross, dot

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

    Newton's iteration X <- (X + X^-T)/2, of second order (Higham 1986), from B scaled to det X about 1.
    """
    det = dot(B[0], cross(B[1], B[2]))
    X = abs(det) ** (-1.0 / 3.0) * B
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
