r"""Heated beam: the strain-free shape of a beam changes with time.

A uniform heating :math:`\Delta T` elongates the free beam by :math:`\alpha \Delta T`; a linear variation of the
temperature across the section bends it, with the curvatures :math:`\kappa_2 = \alpha\, \partial T/\partial z` and
:math:`\kappa_3 = -\alpha\, \partial T/\partial y`. The free shape of an element of length L is a helix, the screw

.. math::  u_0(t) = u_0 + L\, \varepsilon(t)\, a_1, \qquad \varphi_0(t) = \varphi_0 + L\, (\kappa_2 a_2 + \kappa_3 a_3)

in section axes and along the line of nodes, exact for straight beams; the stiffness is that of the unheated beam. Where
the ends are held the beam is stressed, and V = 1/2 e.K e receives from the surroundings the power
:math:`-p \cdot (\dot u_0, \dot\varphi_0)`. Damping acts on the rate of the deformation. The heating is a law of time or
a signal: a ``lag`` whose input is the illumination of the beam makes it depend on its own motion.
"""

import numpy as np

from mecano.constraints.along_coordinate.demand import check_alike, law_of
from mecano.element_interface import with_fields
from mecano.elements.members.beam_elastic import add_elastic, add_free_derivative
from mecano.elements.members.beam_inertia import add_inertia
from mecano.jit.kernel import kernel
from mecano.laws.law_table import evaluate_curve
from mecano.maths.vector import Vec3, dot, mat, vec
from mecano.schema import CONTINUOUS_DRIVE, Field, mapping

CURVES = ("strain", "curvature_2", "curvature_3")
NONE = 0.0, (("constant", {"value": 0.0}),)  # as a default is given, or read from a deck
INPUT = 12  # local index of the first signal
HEATING = mapping(
    Field("strain", CONTINUOUS_DRIVE, "-", "elongation alpha dT of the free beam", 0.0),
    Field("curvature_2", CONTINUOUS_DRIVE, "1/m", "alpha dT/dz, curvature about axis 2", 0.0),
    Field("curvature_3", CONTINUOUS_DRIVE, "1/m", "-alpha dT/dy, curvature about axis 3", 0.0),
)
THERMAL = Field("thermal", HEATING, "-", "change of the strain-free shape with the temperature; none when absent", None)


def heating(d):
    """Return the three values of ``thermal`` in the order of CURVES."""
    return [d["thermal"][name] for name in CURVES]


def check_heating(d):
    """Return errors in the values of a beam with ``thermal``."""
    bends = any(value not in NONE for value in heating(d)[1:])
    lost = ["missing 'up': the direction of axis 3, towards which 'thermal' bends the beam"]
    return [*check_alike("thermal", heating(d)), *(lost if bends and d["up"] is None else [])]


def thermal_record(dtype):
    """Return the dtype of the record of a beam with the curves of its heating."""
    return with_fields(dtype, length=(), **dict.fromkeys(CURVES, "i"))


def thermal_values(d, values, context):
    """Return the values of this record from those of the beam."""
    length = np.linalg.norm(values["u0"] - values["shift"] @ values["phi0"])
    return {**values, "length": length, **{name: law_of(d["thermal"][name], context) for name in CURVES}}


@kernel
def of_laws(p, at):
    """Return the heating by laws of time, and its rates."""
    strain, strain_rate, _ = evaluate_curve(at.laws, p.strain, at.t)
    k_2, rate_2, _ = evaluate_curve(at.laws, p.curvature_2, at.t)
    k_3, rate_3, _ = evaluate_curve(at.laws, p.curvature_3, at.t)
    return strain, k_2, k_3, strain_rate, rate_2, rate_3


@kernel
def of_signals(p, at):
    """Return the heating by signals, and its rates."""
    q, v = at.q, at.v
    return q[INPUT], q[INPUT + 1], q[INPUT + 2], v[INPUT], v[INPUT + 1], v[INPUT + 2]


@kernel
def _bent(p, k_2, k_3):
    """Return the changes of u0 and phi0 by the curvatures."""
    turned = p.length * (mat(p.axes) @ Vec3(0.0, k_2, k_3))
    return mat(p.shift) @ turned, turned


@kernel
def _free_shape(p, strain, k_2, k_3):
    """Return u0, phi0 of the heated beam."""
    shifted, turned = _bent(p, k_2, k_3)
    return vec(p.u0, 0) + (p.length * strain) * vec(p.along, 0) + shifted, vec(p.phi0, 0) + turned


@kernel
def _add_forces(p, at, heating, f, K, C, M):
    """Add elastic forces from the free shape, damping, inertia and weight; return u0, phi0."""
    strain, k_2, k_3, _, _, _ = heating
    u0, phi0 = _free_shape(p, strain, k_2, k_3)
    add_elastic(p, at, u0, phi0, f, K, C)
    add_inertia(p, at, f, K, C, M)
    return u0, phi0


@kernel
def force_by_laws(p, at, f, K, C, M):
    """Add the forces of a beam that is heated by laws of time."""
    _add_forces(p, at, of_laws(p, at), f, K, C, M)


@kernel
def force_by_signals(p, at, f, K, C, M):
    """Add the forces of a beam that is heated by signals, and their derivatives by these."""
    u0, phi0 = _add_forces(p, at, of_signals(p, at), f, K, C, M)
    along = vec(p.along, 0)
    add_free_derivative(p, at, u0, phi0, (p.length * along, 0.0 * along), INPUT, K)
    add_free_derivative(p, at, u0, phi0, _bent(p, 1.0, 0.0), INPUT + 1, K)
    add_free_derivative(p, at, u0, phi0, _bent(p, 0.0, 1.0), INPUT + 2, K)


def observed(observe_from, heating_of):
    """Return ``observe`` of a beam with this heating; ``observe_from`` is that of a beam with a given free shape."""

    @kernel
    def observe(p, at, F, y, e):
        strain, k_2, k_3, strain_rate, rate_2, rate_3 = heating_of(p, at)
        u0, phi0 = _free_shape(p, strain, k_2, k_3)
        p_u, p_phi = observe_from(p, at, u0, phi0, y, e)
        shifted, turned = _bent(p, rate_2, rate_3)
        e[3] = -dot(p_u, (p.length * strain_rate) * vec(p.along, 0) + shifted) - dot(p_phi, turned)

    return observe
