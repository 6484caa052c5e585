r"""Heated beam: the strain-free shape of a beam changes with time.

A uniform heating :math:`\Delta T` elongates the free beam by :math:`\alpha \Delta T`; a linear variation of the
temperature across the section bends it, with the curvatures :math:`\kappa_2 = \alpha\, \partial T/\partial z` and
:math:`\kappa_3 = -\alpha\, \partial T/\partial y`. The free shape of an element of length L is a helix, the screw

.. math::  u_0(t) = u_0 + L\, \varepsilon(t)\, a_1, \qquad \varphi_0(t) = \varphi_0 + L\, (\kappa_2 a_2 + \kappa_3 a_3)

in section axes, exact for straight beams; the stiffness is that of the unheated beam. Where the ends are held the beam
is stressed, and V = 1/2 e.K e receives from the surroundings the power :math:`-p \cdot (\dot u_0, \dot\varphi_0)`.
Damping acts on the rate of the deformation.
"""

import numpy as np

from mecano.element_interface import record
from mecano.elements.members.beam_elastic import add_elastic
from mecano.elements.members.beam_inertia import add_inertia
from mecano.jit.kernel import kernel
from mecano.laws.table import evaluate_curve
from mecano.maths.vector import Vec3, dot, mat, vec
from mecano.schema import CURVE, Field, mapping

THERMAL = Field(
    "thermal",
    mapping(
        Field("strain", CURVE, "-", "elongation alpha dT of the free beam, a function of time [s]", 0.0, argument="s"),
        Field(
            "curvature_2",
            CURVE,
            "1/m",
            "alpha dT/dz: curvature about axis 2, a function of time [s]",
            0.0,
            argument="s",
        ),
        Field(
            "curvature_3",
            CURVE,
            "1/m",
            "-alpha dT/dy: curvature about axis 3, a function of time [s]",
            0.0,
            argument="s",
        ),
    ),
    "-",
    "change of the strain-free shape with the temperature; none when absent",
    None,
)
CURVES = ("strain", "curvature_2", "curvature_3")


def thermal_record(dtype):
    """Return the dtype of the record of a beam with the curves of its heating."""
    own = record(length=(), strain="i", curvature_2="i", curvature_3="i")
    return np.dtype(
        [(name, dtype[name]) for name in dtype.names] + [(name, own[name]) for name in own.names], align=True
    )


def thermal_values(d, values, context):
    """Return the values of this record from those of the beam."""
    length = np.linalg.norm(values["u0"])
    return {**values, "length": length, **{name: context.laws.add(d["thermal"][name]) for name in CURVES}}


@kernel
def free_screw(p, at):
    """Return u0, phi0 of the heated beam, and their rates."""
    strain, strain_rate, _ = evaluate_curve(at.laws, p.strain, at.t)
    k_2, rate_2, _ = evaluate_curve(at.laws, p.curvature_2, at.t)
    k_3, rate_3, _ = evaluate_curve(at.laws, p.curvature_3, at.t)
    L, axes = p.length, mat(p.axes)
    along = vec(p.along, 0)
    u0, phi0 = vec(p.u0, 0) + (L * strain) * along, vec(p.phi0, 0) + L * (axes @ Vec3(0.0, k_2, k_3))
    return u0, phi0, (L * strain_rate) * along, L * (axes @ Vec3(0.0, rate_2, rate_3))


@kernel
def force(p, at, f, K, C, M):
    """Add elastic forces from the free shape, damping, inertia and weight."""
    u0, phi0, _, _ = free_screw(p, at)
    add_elastic(p, at, u0, phi0, f, K, C)
    add_inertia(p, at, f, K, C, M)


def observed(observe_from):
    """Return ``observe`` of a heated beam; ``observe_from`` is that of a beam with a given strain-free screw."""

    @kernel
    def observe(p, at, F, y, e):
        u0, phi0, u_rate, phi_rate = free_screw(p, at)
        p_u, p_phi = observe_from(p, at, u0, phi0, y, e)
        e[3] = -dot(p_u, u_rate) - dot(p_phi, phi_rate)

    return observe
