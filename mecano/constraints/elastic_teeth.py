r"""Elastic teeth: a force between two pitch circles, from the transmission error s and its rate.

.. math::  N = \kappa(w)\,F(s, \dot s) + c\,\dot s, \qquad V = \kappa(w)\,U(s), \qquad
           \kappa = 1 + \sum_n a_n \cos(n\,\psi + \varphi_n), \qquad \psi = z\,w/r

F is a spring, or with backlash the law ``stop`` outside the play, damped after Hunt and Crossley by the
``impact_damping``; U is its potential. The viscous ``damping`` c acts within the play, too, as that of the oil
(Kahraman & Singh 1990). The mean travel w of the pitch circles turns the tooth phase :math:`\psi` by :math:`2\pi` for
each tooth. As the stiffness depends on it, V also exerts the force :math:`\kappa'(w)\,U` along w: the energy is that
of an elastic body, to which a varying stiffness gives and takes nothing.
"""

import math

from mecano.constraints.coordinates.coordinate import add_along, rate_of
from mecano.constraints.stop_phases import FAR, put_stop_events
from mecano.constraints.tooth_friction import tooth_friction
from mecano.jit.kernel import kernel
from mecano.laws.law_table import curve_and_slope, law_force, potential
from mecano.maths.dual import chain, value
from mecano.schema import NUMBER, Field, list_of, mapping, not_negative, positive


@kernel
def _stored(p, at, s):
    """Return U [J] and dU/ds [N]."""
    elastic = law_force(at.laws, p.law, s, 0.0)
    return chain(s, potential(at.laws, p.law, value(s)), value(elastic)), elastic


@kernel
def _push(p, at, s, rate, w):
    """Return the force N [N] along s, and the stiffness factor kappa with its slope [1/m]."""
    factor, slope = curve_and_slope(at.laws, p.variation, w)
    return factor * law_force(at.laws, p.law, s, rate) + p.damping * rate, factor, slope


def elastic_teeth(mesh):
    """Return ``residual``, ``put`` (p, at, y, e) of force, error, power and energies, and ``event_values``."""
    travel = mesh.travel

    @kernel
    def residual(p, at, f):
        (s, across), (w, along) = travel(p, at)
        N, _, slope = _push(p, at, s, rate_of(across, at.v), w)
        U, _ = _stored(p, at, s)
        add_along(f, N, across)
        add_along(f, slope * U + tooth_friction(p, N, rate_of(along, at.v)), along)

    @kernel
    def put(p, at, y, e):
        (s, across), (w, along) = travel(p, at)
        s_rate, w_rate = rate_of(across, at.v), rate_of(along, at.v)
        N, factor, _ = _push(p, at, s, s_rate, w)
        U, elastic = _stored(p, at, s)
        y[0], y[1] = -N, s
        y[2] = (N - factor * elastic) * s_rate + tooth_friction(p, N, w_rate) * w_rate
        e[1], e[2] = factor * U, y[2]

    @kernel
    def event_values(p, at, g):
        put_stop_events(g, -p.half_play, p.half_play, travel(p, at)[0][0])

    return residual, put, event_values


TEETH = Field(
    "teeth",
    mapping(
        Field("stiffness", NUMBER, "N/m", "mean force per deflection, along the pitch circle", check=positive),
        Field("damping", NUMBER, "N s/m", "force per rate of the transmission error; within the backlash, too", 0.0,
              not_negative),
        Field("impact_damping", NUMBER, "s/m", "with backlash: damping relative to the elastic force of the flanks",
              0.0, not_negative),
        Field("number", NUMBER, "-", "number of teeth of a, or of the pinion; for 'variation'", None, positive),
        Field("variation", list_of(NUMBER), "-", "amplitudes of the harmonics 1, 2, ... of the tooth passing in the "
              "stiffness, over its mean", ()),
        Field("phases", list_of(NUMBER), "rad", "phases of these harmonics at the start; zero when absent", ()),
    ),
    "-", "elasticity and damping of the teeth; rigid when absent", None,
)  # fmt: skip


def teeth_values(d, radius, context):
    """Return the values of a record from the deck's ``teeth`` and ``backlash``; ``radius`` [m] is the pitch radius."""
    teeth = d["teeth"]
    half = 0.5 * d["backlash"]
    if teeth is None:
        return {"half_play": half}
    stop = {"lower": -half, "upper": half, "damping": teeth["impact_damping"]}
    law = ("stop", {"stiffness": teeth["stiffness"], **stop}) if half else ("spring", {"stiffness": teeth["stiffness"]})
    phases = teeth["phases"] or [0.0] * len(teeth["variation"])
    per_metre = (teeth["number"] or 0.0) / (2.0 * math.pi * radius)
    cosines = (
        ("sine", {"amplitude": a, "frequency": n * per_metre, "phase": phase + 0.5 * math.pi, "offset": 0.0})
        for n, (a, phase) in enumerate(zip(teeth["variation"], phases, strict=True), 1)
    )
    return {
        "half_play": half or FAR,
        "law": context.laws.add((law,)),
        "variation": context.laws.add((("constant", {"value": 1.0}), *cosines)),
        "damping": teeth["damping"],
    }


def check_teeth(d):
    """Return errors in the fields ``teeth``, ``backlash`` and ``restitution`` of a joint."""
    teeth, texts = d["teeth"], []
    if d["restitution"] and (teeth or not d["backlash"]):
        texts.append("'restitution' applies to rigid teeth with 'backlash'; to elastic 'teeth' give 'impact_damping'")
    if teeth is None:
        return texts
    if teeth["impact_damping"] and not d["backlash"]:
        texts.append("'teeth.impact_damping' needs 'backlash'; without play give 'damping'")
    if teeth["variation"] and teeth["number"] is None:
        texts.append("'teeth.variation' needs the 'number' of teeth")
    if sum(map(abs, teeth["variation"])) >= 1.0:
        texts.append("'teeth.variation' must have amplitudes whose sum is less than 1, for a stiffness above zero")
    if teeth["phases"] and len(teeth["phases"]) != len(teeth["variation"]):
        texts.append("'teeth.phases' must be as many as the amplitudes of 'variation'")
    return texts
