r"""Stiffness of a beam element that gives the exact end displacements of linear statics. NumPy, once per element.

Between its ends an unloaded beam carries the wrench :math:`n' = ad^*_f n` along the strain-free helix
:math:`f = h_0/L`, so its section flexibility counts where the bending moment is, not in the middle only. With the
wrench conjugate to h as unknown, :math:`n(s) = N(s) p`, the flexibility of the element is

.. math::  F_e = \int_0^L N^T C^{-1} N \,ds = L C^{-1} + \tfrac{L^3}{12} A^T C^{-1} A + \dots

the residual bending flexibility of MacNeal (1978) for a straight beam. It removes shear locking: the stiffness of
a slender straight element is that of the cubic beam.
"""

import numpy as np
from scipy.linalg import expm

POINTS, WEIGHTS = np.polynomial.legendre.leggauss(8)  # exact to round-off up to half a turn


def hat(a):
    """Matrix (3, 3) of b -> a x b."""
    return np.array([[0.0, -a[2], a[1]], [a[2], 0.0, -a[0]], [-a[1], a[0], 0.0]])


def adjoint(h):
    """ad_h (6, 6) of a screw h = (u, phi), acting on twists (velocity, angular velocity)."""
    out = np.zeros((6, 6))
    out[:3, :3] = out[3:, 3:] = hat(h[3:])
    out[:3, 3:] = hat(h[:3])
    return out


def element_stiffness(C, h0):
    """K_e (6, 6) [N/m, N, N m] from the section stiffness C (6, 6) and the strain-free screw h0 (6,) [m, rad]."""
    X, length = adjoint(h0), np.linalg.norm(h0[:3])
    stations = 0.5 * (POINTS + 1.0)
    T = sum(0.5 * w * expm(-s * X) for s, w in zip(stations, WEIGHTS, strict=True))  # twist of the end = T dh
    compliance, F = np.linalg.inv(C), np.zeros((6, 6))
    for s, w in zip(stations, WEIGHTS, strict=True):
        N = np.linalg.solve(T, expm(-s * X)).T  # wrench at the distance s L before the end
        F += 0.5 * w * length * N.T @ compliance @ N
    K = np.linalg.inv(F)
    return 0.5 * (K + K.T)
