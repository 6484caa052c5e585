r"""A ground surface and the point of a torus that is deepest in it: tyres with a rounded tread.

The torus has the centre x, the unit axis a, a middle circle of the radius R and a tread of the radius e around it. M is
the point of the middle circle that is nearest to the ground, P the point of the ground below it along the normal n at P
(surface.py):

    M = x + R c,   c = -(n - s a)/q,   M - P = (n.(M - P)) n

The tread is pressed in along n by w, and touches the ground at C = P:

    w = e - n.(M - P),   C - x = R c - (e - w) n

The distance of M from the ground is stationary for both points, so that the first variation is

    dw = -n.(dx + dtheta x R c) = -n.(dx + dtheta x (C - x))

On a profile the position of P along it is implicit, as that of the contact of a disc.
"""

from mecano.constraints.ground import touch_on_profile
from mecano.jit.kernel import kernel
from mecano.maths.dual import at_least, sqrt
from mecano.maths.surface import LEAST_Q, Contact
from mecano.maths.vector import dot


@kernel
def torus_contact(p, n, height, a):
    """Return the Contact of a torus of unit axis ``a`` with a plane of unit normal n; its r is the radius minus w.

    The record ``p`` has the ``radius`` [m], that of the middle circle plus the ``crown`` radius [m]; ``height`` [m]: of
    the centre.
    """
    s = dot(n, a)
    m = n - s * a
    q = at_least(sqrt(dot(m, m)), LEAST_Q)
    c, middle = -m / q, p.radius - p.crown
    w = middle * q - (height - p.crown)
    return Contact(n, c, s, q, p.radius - w, middle * c - (p.crown - w) * n)


@kernel
def _residual(p, n0, d, a, z, delta, H, H1, H2):
    """Return (M - P).(d + H1 n0), which is zero at the contact, and its derivative by the place of P.

    P is at the distance ``delta`` [m] along the profile from the centre, whose height above the plane is z [m].
    """
    middle, N = p.radius - p.crown, n0 - H1 * d
    m = N - dot(N, a) * a
    Q = at_least(sqrt(dot(m, m)), LEAST_Q)
    c = -m / Q
    along, up, da = dot(d, c), dot(n0, c), dot(d, a)
    above = z + middle * up - H
    turned_along = H2 / Q * (1.0 - da * da - along * along)
    turned_up = -(H2 / Q) * (da * dot(n0, a) + along * up)
    residual = middle * along - delta + H1 * above
    return residual, middle * (turned_along + H1 * turned_up) - 1.0 + H2 * above - H1 * H1


touch_torus = touch_on_profile(_residual, torus_contact)
