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
from mecano.maths.vector import cross, dot

LEAST_Q = 1e-3  # a disc flat on the ground (q = 0) has no lowest point: this bound keeps all values finite


class Contact(NamedTuple):
    """The point of a disc nearest to the ground; 3-vectors in the inertial frame."""

    n: tuple  # unit normal at C
    c: tuple  # unit vector, centre to C
    s: float  # n.a
    q: float  # |n - s a|
    r: float  # distance of C from the centre, of a rounded tread that of the middle circle [m]
    arm: tuple  # r c [m], of a rounded tread to the ground


@kernel
def profile_normal(n0, d, H1):
    """Return the unit normal n of a profile with slope H1."""
    return (n0 - H1 * d) / sqrt(1.0 + H1 * H1)


@kernel
def foot_residual(p, n0, d, a, z, delta, H, H1, H2):
    """Return d.(r c) - delta, which is zero at the contact, and its derivative with respect to delta.

    ``delta`` [m] is sigma minus that of the centre, ``z`` [m] the height of the centre above the plane; H, H1, H2 are
    evaluated at sigma. Written with the normal N = n0 - H1 d, which is not of unit length. A disc needs nothing of the
    record ``p``, as a torus (constraints/torus.py) does.
    """
    N = n0 - H1 * d
    M = N - dot(N, a) * a
    Q2 = at_least(dot(M, M), LEAST_Q * LEAST_Q)
    height, dM, da = z - H + H1 * delta, dot(d, M), dot(d, a)
    value = -height * dM / Q2 - delta
    slope = (height * H2 * (1.0 - da * da) - H2 * delta * dM - 2.0 * H2 * height * dM * dM / Q2) / Q2 - 1.0
    return value, slope


@kernel
def disc_contact(p, n, height, a):
    """Return the Contact of a disc with unit axis ``a`` and its centre ``height`` = (x - P).n [m] above the ground."""
    s = dot(n, a)
    m = n - s * a
    q = at_least(sqrt(dot(m, m)), LEAST_Q)
    c = -m / q
    r = height / q
    return Contact(n, c, s, q, r, r * c)


@kernel
def directions(a, g):
    """Return driving direction t = a x n/q and lateral direction l = n x t at the Contact ``g``; ``a`` is the axis."""
    t = cross(a, g.n) / g.q
    return t, cross(g.n, t)
