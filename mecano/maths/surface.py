r"""A ground surface and the point of a disc nearest to it.

The surface is a plane (point P0, unit normal n0), raised by a profile H(sigma), the height above the plane
as a function of the distance sigma along a unit direction d in it: P = P0 + sigma d + tau (n0 x d) + H
n0.

A disc of centre x and unit axis a touches it at C = x + r c. The unit vector c points from the centre to
the lowest point of the rim; normal n and point P are evaluated *at C*:

    c = -(n - s a)/q,   s = n.a,   q = sqrt(1 - s^2),   r = (x - P).n / q,   sigma = d.(C - P0)

The last equation is implicit in sigma. Then C lies on the surface and in the plane of the disc, and C - x is
normal to their intersection: r is the (stationary) distance of the centre from the ground in that plane.
Therefore the first variation is the same on a plane and on a profile,

    dr = n . (dx + dtheta x r c)/q,

and the curvature of the profile enters only the second variation. The contact is single and sigma unique
as long as the radius of curvature of concave parts of the profile is larger than r.
"""

from typing import NamedTuple

from mecano.jit.kernel import kernel
from mecano.maths.dual import at_least, sqrt
from mecano.maths.vector import EYE, Mat3, cross, dot, outer, skew

LEAST_Q = 1e-3  # a disc flat on the ground (q = 0) has no lowest point: this bound keeps all values finite
LEAST_MARGIN = 0.05  # of 1 - r/(radius of curvature): keeps values finite where the profile is too concave


class Contact(NamedTuple):
    """The point of a disc nearest to the ground; 3-vectors in the inertial frame."""

    n: tuple  # unit normal at C
    dn: tuple  # dn/dsigma [1/m]
    c: tuple  # unit vector, centre to C
    s: float  # n.a
    q: float  # |n - s a|
    r: float  # distance of C from the centre [m]
    arm: tuple  # r c [m]


class Block(NamedTuple):
    """Derivatives of a contact with respect to three variables: 3x3, 3, 3x3."""

    n: tuple
    s: tuple
    arm: tuple


@kernel
def profile_normal(n0, d, H1, H2):
    """Return the unit normal n and dn/dsigma [1/m] of a profile with slope H1 and second derivative H2 [1/m]."""
    length2 = 1.0 + H1 * H1
    length = sqrt(length2)
    n = (n0 - H1 * d) / length
    return n, -H2 / (length2 * length) * (d + H1 * n0)


@kernel
def foot_residual(n0, d, a, z, delta, H, H1, H2):
    """Return d.(r c) - delta, which is zero at the contact, and its derivative with respect to delta.

    ``delta`` [m] is sigma minus that of the centre, ``z`` [m] the height of the centre above the plane; H, H1, H2 are
    evaluated at sigma. Written with the normal N = n0 - H1 d, which is not of unit length.
    """
    N = n0 - H1 * d
    M = N - dot(N, a) * a
    Q2 = at_least(dot(M, M), LEAST_Q * LEAST_Q)
    height, dM, da = z - H + H1 * delta, dot(d, M), dot(d, a)
    value = -height * dM / Q2 - delta
    slope = (height * H2 * (1.0 - da * da) - H2 * delta * dM - 2.0 * H2 * height * dM * dM / Q2) / Q2 - 1.0
    return value, slope


@kernel
def disc_contact(n, dn, height, a):
    """Return the Contact of a disc with unit axis ``a`` and its centre ``height`` = (x - P).n [m] above the ground."""
    s = dot(n, a)
    m = n - s * a
    q = at_least(sqrt(dot(m, m)), LEAST_Q)
    c = -m / q
    r = height / q
    return Contact(n, dn, c, s, q, r, r * c)


@kernel
def disc_variation(d, a, g):
    """Return derivatives of the Contact ``g`` of a disc of axis ``a``: (Block by dx, Block by the inertial dtheta).

    They include the implicit derivative of sigma along the profile's direction ``d``; da = dtheta x a.
    """
    # dc = C_n dn + C_a da
    C_a = (outer(a, g.n) + g.s * EYE) / g.q + outer(g.s / g.q**2 * g.c, g.n)
    bend = dot(a, g.dn)
    turn = (bend * (a + g.s / g.q * g.c) - g.dn) / g.q  # C_n dn/dsigma
    r_x = g.n / g.q
    r_t = g.r / g.q * cross(g.c, g.n)
    margin = 1.0 / max(1.0 - g.r * dot(d, turn), LEAST_MARGIN)
    along = dot(d, g.c)
    sigma_x = margin * (d + along * r_x)
    sigma_t = margin * (along * r_t + g.r * cross(a, C_a.T @ d))
    swing = -g.r * _times_skew(C_a, a)
    slide = g.r * turn
    by_x = Block(outer(g.dn, sigma_x), bend * sigma_x, outer(g.c, r_x) + outer(slide, sigma_x))
    by_t = Block(
        outer(g.dn, sigma_t),
        bend * sigma_t + cross(a, g.n),
        swing + (outer(g.c, r_t) + outer(slide, sigma_t)),
    )
    return by_x, by_t


@kernel
def directions(a, g):
    """Return driving direction t = a x n/q and lateral direction l = n x t at the Contact ``g``; ``a`` is the axis."""
    t = cross(a, g.n) / g.q
    return t, cross(g.n, t)


@kernel
def directions_variation(a, g, t, by, da):
    """Return derivatives (dt, dl), 3x3, of the directions by the variables of the Block ``by``; ``da``, 3x3, of a."""
    turn = -(skew(g.n) @ da) + skew(a) @ by.n
    dt = turn / g.q + outer(g.s / g.q**2 * t, by.s)
    return dt, -(skew(t) @ by.n) + skew(g.n) @ dt


@kernel
def _times_skew(A, a):
    """Return A hat(a): row i is A_i x a."""
    return Mat3(cross(A[0], a), cross(A[1], a), cross(A[2], a))
