r"""Stiffness of a beam element that gives the exact end displacements of linear statics. NumPy, once per element.

Between its ends an unloaded beam carries the wrench :math:`n' = ad^*_f n` along the strain-free helix
:math:`f = h_0/L`, so its section flexibility acts where the bending moment is, not only in the middle. With the
wrench conjugate to h as unknown, :math:`n(s) = N(s) p`, the flexibility of the element is

.. math::  F_e = \int_0^L N^T C^{-1} N \,ds = L C^{-1} + \tfrac{L^3}{12} A^T C^{-1} A + \dots

the residual bending flexibility of MacNeal (1978) for a straight beam. It removes shear locking: the stiffness of
a slender straight element is that of the cubic beam.

Strains are those of the line of shear centres, about which the sections turn: a twist tilts the line of nodes of a
section whose shear centre lies aside, but no section against its line.
"""

from functools import lru_cache

import numpy as np

from mecano.constraints.triads import hat

POINTS, WEIGHTS = np.polynomial.legendre.leggauss(8)  # exact to round-off up to half a turn
STRAIGHT = 1e-9  # rad: an element with a smaller rotation between its ends is straight


def adjoint(h):
    """Return ad_h (6, 6) of a screw h = (u, phi), acting on twists (velocity, angular velocity)."""
    out = np.zeros((6, 6))
    out[:3, :3] = out[3:, 3:] = hat(h[3:])
    out[:3, 3:] = hat(h[:3])
    return out


def elastic_constants(C, h0):
    """Return K_uu, K_up, K_pp, D, shift (3, 3) and section flexibility F (6, 6), in end axes.

    C (6, 6): section stiffness, h0 (6,): strain-free screw, both of the line of nodes, as is F; the others belong to
    that of shear centres, u + shift phi. Cached, since many elements of a model are equal.
    """
    return _elastic_constants(C.tobytes(), h0.tobytes())


@lru_cache(maxsize=1000)
def _elastic_constants(C, h0):
    C, h0 = np.frombuffer(C).reshape(6, 6), np.frombuffer(h0)
    F = np.linalg.inv(C)
    shift = -hat(shear_center(F))
    back = np.eye(6)
    back[:3, 3:] = -shift
    K, C = back.T @ element_stiffness(C, h0) @ back, back.T @ C @ back
    bending = bending_shares(C, K, np.linalg.norm(h0[:3]))
    return K[:3, :3], K[:3, 3:], K[3:, 3:], line_form(bending), shift, F


def shear_center(F):
    """Return the shear centre of a section (3,) [m] from its node; F (6, 6): its flexibility.

    A torque alone shears the line of nodes by F_23 and F_33 per F_44, where it turns about this point.
    """
    return np.array([0.0, -F[2, 3], F[1, 3]]) / F[3, 3]


def element_stiffness(C, h0):
    """Return K_e (6, 6) [N/m, N, N m] for section stiffness C (6, 6) and strain-free screw h0 (6,) [m, rad]."""
    length, weights = np.linalg.norm(h0[:3]), 0.5 * WEIGHTS
    carried = _exponentials(h0, 0.5 * (POINTS + 1.0))
    T = np.tensordot(weights, carried, 1)  # twist of the end = T dh
    N = np.linalg.solve(T, carried).transpose(0, 2, 1)  # wrenches at the distances s L before the end
    F = length * np.tensordot(weights, N.transpose(0, 2, 1) @ np.linalg.inv(C) @ N, 1)
    K = np.linalg.inv(F)
    return 0.5 * (K + K.T)


def _exponentials(h0, stations):
    """Return exp(-s ad_h) for each s: the adjoint matrices of the rotations R by -s phi and displacements p.

    The series of a straight element ends after the square.
    """
    if np.abs(h0[3:]).max() < STRAIGHT:
        s, X = stations[:, None, None], adjoint(h0)
        return np.eye(6) - s * X + 0.5 * s**2 * (X @ X)
    theta = np.linalg.norm(h0[3:])
    n, t = -h0[3:] / theta, theta * stations[:, None, None]
    N, sine, versine = hat(n), np.sin(t), 2.0 * np.sin(0.5 * t) ** 2
    R = np.eye(3) + sine * N + versine * (N @ N)
    p = (sine * np.eye(3) + versine * N + (t - sine) * np.outer(n, n)) @ (-h0[:3] / theta)
    out = np.zeros((len(stations), 6, 6))
    out[:, :3, :3] = out[:, 3:, 3:] = R
    out[:, :3, 3:] = np.cross(p[:, None], R.transpose(0, 2, 1)).transpose(0, 2, 1)  # p x R, by columns
    return out


def bending_shares(C, K, length):
    """Return the shares of bending in the tilts along axes 2 and 3 (2,); the rest is shear.

    They are 1 - K_22 L/(GA), or 1/(1 + 12 EI/(GA L^2)) in textbooks.
    """
    return 1.0 - np.clip(length * np.diag(K)[1:3] / np.diag(C)[1:3], 0.0, 1.0)


def line_form(bending):
    """Return D (3, 3) [-], section axes: an element bent in an S shape by the tilts u/length is u . D u/(2 length)
    longer than its component along the beam.

    With the share r of bending in the tilt: 2 r - 4/5 r^2.
    """
    return np.diag([0.0, *(2.0 * bending * (1.0 - 0.4 * bending))])
