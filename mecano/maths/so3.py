r"""Rotations: exponential map, logarithm and tangent operators, on tuples.

``R`` maps material components to inertial ones. An increment is material:
:math:`R \leftarrow R \exp(\hat\Theta)`, and :math:`\delta\Theta_{mat} = T(\Psi)\,\delta\Psi` for
:math:`R = R_0 \exp(\hat\Psi)`. Closed forms with series below 1e-2 rad, both accurate to round-off.
"""

from mecano.jit.kernel import kernel
from mecano.maths.dual import at_least, atan2, everywhere, select, sin, sqrt, tan
from mecano.maths.vector import EYE, Vec3, cross, dot, skew

TINY = 1e-150  # half the angle [rad] below which a rotation has no axis
SERIES = 1e-2  # below this angle [rad] the series of four terms is exact to round-off
F3, F4, F5, F6 = 1.0 / 6.0, 1.0 / 24.0, 1.0 / 120.0, 1.0 / 720.0  # 1/k!, as a division takes as long as four products
F7, F8, F9 = 1.0 / 5040.0, 1.0 / 40320.0, 1.0 / 362880.0
D1, D2, D3 = 1.0 / 12.0, 1.0 / 720.0, 1.0 / 30240.0


@kernel
def coefficients(t2):
    """Return sin(t)/t, (1 - cos t)/t^2, (t - sin t)/t^3 for t2 = t^2."""
    is_small = t2 < SERIES * SERIES
    s = 1.0 - t2 * (F3 - t2 * (F5 - t2 * F7))
    c = 0.5 - t2 * (F4 - t2 * (F6 - t2 * F8))
    b = F3 - t2 * (F5 - t2 * (F7 - t2 * F9))
    if everywhere(is_small):
        return s, c, b
    t = sqrt(t2)
    half = sin(0.5 * t) / (0.5 * t)
    sine = sin(t) / t
    return (
        select(is_small, s, sine), select(is_small, c, 0.5 * half * half), select(is_small, b, (1.0 - sine) / t2)
    )  # fmt: skip


@kernel
def exp(psi):
    """Return the rotation matrix exp(hat(psi)) of the rotation vector psi [rad] (Rodrigues)."""
    s, c, _ = coefficients(dot(psi, psi))
    H = skew(psi)
    return EYE + (s * H + c * (H @ H))


@kernel
def quaternion(R):
    """Return the unit quaternion (w, x, y, z), w >= 0, of R, computed from its largest component for accuracy."""
    t = R[0][0] + R[1][1] + R[2][2]
    by_w = t > at_least(at_least(R[0][0], R[1][1]), R[2][2])
    w = 0.5 * sqrt(at_least(1.0 + t, TINY))
    s = 0.25 / w
    x, y, z = (R[2][1] - R[1][2]) * s, (R[0][2] - R[2][0]) * s, (R[1][0] - R[0][1]) * s
    if everywhere(by_w):
        return w, x, y, z
    other = _from_vector_part(R)
    return select(by_w, w, other[0]), select(by_w, x, other[1]), select(by_w, y, other[2]), select(by_w, z, other[3])


@kernel
def _from_vector_part(R):
    """Return the unit quaternion (w, x, y, z), w >= 0, of R, computed from its largest component among x, y, z.

    ``a`` is this component, ``b`` the next in the order x, y, z, x, ``c`` the one after that.
    """
    by_x, by_y = R[0][0] >= at_least(R[1][1], R[2][2]), R[1][1] >= R[2][2]
    own = _chosen(by_x, by_y, R[0][0], R[1][1], R[2][2])
    others = _chosen(by_x, by_y, R[1][1], R[2][2], R[0][0]), _chosen(by_x, by_y, R[2][2], R[0][0], R[1][1])
    a = 0.5 * sqrt(1.0 + own - others[0] - others[1])
    s = 0.25 / a
    w = _chosen(by_x, by_y, R[2][1] - R[1][2], R[0][2] - R[2][0], R[1][0] - R[0][1]) * s
    xy, yz, zx = R[1][0] + R[0][1], R[2][1] + R[1][2], R[0][2] + R[2][0]
    b, c = _chosen(by_x, by_y, xy, yz, zx) * s, _chosen(by_x, by_y, zx, xy, yz) * s
    sign = select(w < 0.0, -1.0, 1.0)
    return (
        sign * w, sign * _chosen(by_x, by_y, a, c, b), sign * _chosen(by_x, by_y, b, a, c),
        sign * _chosen(by_x, by_y, c, b, a),
    )  # fmt: skip


@kernel
def _chosen(by_x, by_y, of_x, of_y, of_z):
    """Return the value of the largest component."""
    return select(by_x, of_x, select(by_y, of_y, of_z))


@kernel
def log(R):
    """Return the rotation vector [rad] of R, with length in [0, pi]."""
    w, x, y, z = quaternion(R)
    n = sqrt(x * x + y * y + z * z)
    f = select(n > TINY, 2.0 * atan2(n, w) / at_least(n, TINY), 2.0)
    return Vec3(f * x, f * y, f * z)


@kernel
def tangent(psi):
    """Return T(psi), 3x3: material dTheta = T dpsi; T = I - c hat(psi) + b hat(psi)^2."""
    _, c, b = coefficients(dot(psi, psi))
    H = skew(psi)
    return EYE + (-c * H + b * (H @ H))


@kernel
def inverse_coefficient(t2):
    """Return d = (1 - t/2 cot(t/2))/t^2 of an angle t with the square t2, for t < 2 pi; 1/12 for small ones."""
    if t2 < SERIES * SERIES:
        return D1 + t2 * (D2 + t2 * D3)
    t = sqrt(t2)
    return (1.0 - 0.5 * t / tan(0.5 * t)) / t2


@kernel
def tangent_inverse(psi):
    """Return T(psi)^-1, 3x3: dpsi = T^-1 dTheta; I + hat(psi)/2 + d hat(psi)^2, for |psi| < 2 pi."""
    H = skew(psi)
    return EYE + (0.5 * H + inverse_coefficient(dot(psi, psi)) * (H @ H))


@kernel
def tangent_rate(psi, rate):
    """Return dT(psi)/dt rate for the ``rate`` of psi: material acceleration of constant rates of the components."""
    t2 = dot(psi, psi)
    if t2 < SERIES * SERIES:
        d_c, d_b = -1.0 / 24.0 + t2 / 360.0, -1.0 / 120.0 + t2 / 2520.0
    else:
        s, c, b = coefficients(t2)
        d_c, d_b = 0.5 * (s - 2.0 * c) / t2, 0.5 * (c - 3.0 * b) / t2
    turning = 2.0 * dot(psi, rate)
    once = cross(psi, rate)
    return turning * (d_b * cross(psi, once) - d_c * once) + coefficients(t2)[2] * cross(rate, once)
