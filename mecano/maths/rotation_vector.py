r"""The rotation vector between two frames, its variation and the derivatives of the variation, on tuples.

With :math:`R_2 = R_1 \exp(\hat\varphi)` and material variations :math:`\delta\Theta_i` of both frames
(:math:`\delta\Theta_1` in the axes of :math:`R_1`),

.. math::  \delta\varphi = H \delta\Theta_2 - H^T \delta\Theta_1, \qquad
    H = T^{-1}(\varphi) = I + \tfrac12 \hat\varphi + c\, \hat\varphi^2, \qquad
    c = \frac{1 - \frac\theta2 \cot\frac\theta2}{\theta^2}, \quad \theta = |\varphi| < 2\pi

``c1`` and ``c2`` below are :math:`c'/\theta` and :math:`c_1'/\theta`.
"""

from mecano.jit.kernel import kernel
from mecano.maths.dual import everywhere, select, sqrt, tan
from mecano.maths.vector import EYE, Mat3, Vec3, cross, dot, outer, skew

SERIES = 1.0  # squared angle [rad2] below which eleven terms of the series are exact to round-off
A1, A2, A3, A4 = 1.0 / 12.0, 1.0 / 720.0, 1.0 / 30240.0, 1.0 / 1209600.0  # |B_2k|/(2k)!
A5, A6, A7 = 1.0 / 47900160.0, 691.0 / 1307674368000.0, 1.0 / 74724249600.0
A8, A9 = 3617.0 / 10670622842880000.0, 43867.0 / 5109094217170944000.0
A10, A11 = 174611.0 / 802857662698291200000.0, 77683.0 / 14101100039391805440000.0


@kernel
def inverse_coefficients(t2):
    """Return c, c1 and c2 for t2 = theta^2; theta < 2 pi."""
    is_small = t2 < SERIES
    c = A7 + t2 * (A8 + t2 * (A9 + t2 * (A10 + t2 * A11)))
    c = A1 + t2 * (A2 + t2 * (A3 + t2 * (A4 + t2 * (A5 + t2 * (A6 + t2 * c)))))
    c1 = 12.0 * A7 + t2 * (14.0 * A8 + t2 * (16.0 * A9 + t2 * (18.0 * A10 + t2 * 20.0 * A11)))
    c1 = 2.0 * A2 + t2 * (4.0 * A3 + t2 * (6.0 * A4 + t2 * (8.0 * A5 + t2 * (10.0 * A6 + t2 * c1))))
    c2 = 120.0 * A7 + t2 * (168.0 * A8 + t2 * (224.0 * A9 + t2 * (288.0 * A10 + t2 * 360.0 * A11)))
    c2 = 8.0 * A3 + t2 * (24.0 * A4 + t2 * (48.0 * A5 + t2 * (80.0 * A6 + t2 * c2)))
    if everywhere(is_small):
        return c, c1, c2
    t = sqrt(t2)
    s = 1.0 / t2
    cot = 1.0 / tan(0.5 * t)
    square = 1.0 + cot * cot
    g = 1.0 - 0.5 * t * cot
    g1 = 0.25 * square - 0.5 * cot / t
    g2 = (0.25 * square + 0.5 * cot / t - 0.25 * square * cot * t) * s
    return (
        select(is_small, c, g * s), select(is_small, c1, (g1 - 2.0 * g * s) * s),
        select(is_small, c2, (g2 - 4.0 * g1 * s + 8.0 * g * s * s) * s),
    )  # fmt: skip


@kernel
def inverse_tangent(phi, c):
    """Return H, 3x3."""
    return add_half(phi) + c * square_hat(phi)


@kernel
def add_half(phi):
    """Return I + hat(phi)/2."""
    return Mat3(
        Vec3(1.0, -0.5 * phi[2], 0.5 * phi[1]),
        Vec3(0.5 * phi[2], 1.0, -0.5 * phi[0]),
        Vec3(-0.5 * phi[1], 0.5 * phi[0], 1.0),
    )


@kernel
def square_hat(phi):
    """Return hat(phi)^2 = phi phi^T - theta^2 I."""
    xx, yy, zz = phi[0] * phi[0], phi[1] * phi[1], phi[2] * phi[2]
    xy, xz, yz = phi[0] * phi[1], phi[0] * phi[2], phi[1] * phi[2]
    return Mat3(Vec3(-yy - zz, xy, xz), Vec3(xy, -xx - zz, yz), Vec3(xz, yz, -xx - yy))


@kernel
def first_derivative(phi, z, half, c, c1):
    """Return d(H z)/dphi with half = -1/2, d(H^T z)/dphi with half = 1/2; 3x3, column j is the derivative by phi_j."""
    zz = dot(phi, z) * phi
    twice = zz - dot(phi, phi) * z  # phi x (phi x z)
    along = c1 * twice - 2.0 * c * z
    d = c * dot(phi, z)
    u = half * z
    cz = c * z
    return Mat3(
        Vec3(d + phi[0] * cz[0] + along[0] * phi[0], -u[2] + phi[0] * cz[1] + along[0] * phi[1],
         u[1] + phi[0] * cz[2] + along[0] * phi[2]),
        Vec3(u[2] + phi[1] * cz[0] + along[1] * phi[0], d + phi[1] * cz[1] + along[1] * phi[1],
         -u[0] + phi[1] * cz[2] + along[1] * phi[2]),
        Vec3(-u[1] + phi[2] * cz[0] + along[2] * phi[0], u[0] + phi[2] * cz[1] + along[2] * phi[1],
         d + phi[2] * cz[2] + along[2] * phi[2]),
    )  # fmt: skip


@kernel
def second_form(phi, p, y, c, c1, c2):
    """Return the second derivative of p . H y by phi, 3x3 symmetric."""
    py, fy, fp = dot(p, y), dot(phi, y), dot(phi, p)
    t2 = dot(phi, phi)
    q = fy * fp - t2 * py  # p . phi x (phi x y)
    slope = fp * y + fy * p - 2.0 * py * phi
    w = c1 * slope + 0.5 * c2 * q * phi
    u = c * p
    d = c1 * q - 2.0 * c * py
    xx = d + 2.0 * (u[0] * y[0] + w[0] * phi[0])
    yy = d + 2.0 * (u[1] * y[1] + w[1] * phi[1])
    zz = d + 2.0 * (u[2] * y[2] + w[2] * phi[2])
    xy = u[0] * y[1] + u[1] * y[0] + w[0] * phi[1] + w[1] * phi[0]
    xz = u[0] * y[2] + u[2] * y[0] + w[0] * phi[2] + w[2] * phi[0]
    yz = u[1] * y[2] + u[2] * y[1] + w[1] * phi[2] + w[2] * phi[1]
    return Mat3(Vec3(xx, xy, xz), Vec3(xy, yy, yz), Vec3(xz, yz, zz))


@kernel
def inverse_tangent_rate(phi, rate, c, c1):
    """Return dH/dt for dphi/dt = rate, 3x3."""
    F, W = skew(phi), skew(rate)
    both = F @ W + W @ F
    return 0.5 * W + (c * both + c1 * dot(phi, rate) * square_hat(phi))


@kernel
def second_derivative(phi, rate, y, c, c1, c2):
    """Return d/dphi [d(H y)/dphi rate], 3x3, for fixed rate and y."""
    f, fy, ry = dot(phi, rate), dot(phi, y), dot(rate, y)
    twice = cross(phi, cross(phi, y))
    mixed = fy * rate + ry * phi - 2.0 * f * y
    out = (c * ry + c1 * f * fy) * EYE
    out = out + outer(c * rate + c1 * f * phi, y)
    out = out + outer(c1 * mixed + (c2 * f * twice - 2.0 * c1 * f * y), phi)
    return out + outer(c1 * twice - 2.0 * c * y, rate)
