r"""Drag of a fluid on a body around a node: parachutes, wind on a structure, a body in water.

With the velocity w of the stream, a direction times a function of time or a formula of signals, and the velocity v of
the node,

.. math::  F = \tfrac12 \rho\, c_d A\, |w - v|\,(w - v)

The power of the force, F.v, is the power that the stream gives, F.w, minus the dissipated power, F.(w - v).
"""

import numpy as np

from mecano.constraints.along_coordinate.demand import law_of, on_demand
from mecano.element_interface import Display, Kind, Output, named, record
from mecano.jit.kernel import kernel
from mecano.maths.vector import add_vec, dot, norm, put, vec
from mecano.schema import DIRECTION, DRIVE, NODE, NUMBER, Field, positive

RECORD = record(factor=(), stream=3, law="i")
AIR = 1.225  # kg/m3, at sea level in the standard atmosphere


def _functions(speed):
    """Return ``residual`` and ``observe`` for a speed of the stream (p, at) -> [m/s]."""

    @kernel
    def force(p, at):
        w = speed(p, at) * vec(p.stream, 0)
        u = w - vec(at.v, 0)
        return p.factor * norm(u) * u, w

    @kernel
    def residual(p, at, f):
        add_vec(f, 0, -1.0, force(p, at)[0])

    @kernel
    def observe(p, at, F, y, e):
        D, w = force(p, at)
        lost = dot(D, w - vec(at.v, 0))
        put(y, 0, D)
        y[3] = lost
        e[2], e[3] = lost, dot(D, w)

    return named(residual, observe)


def prepare(d, nodes, context):
    """Return the record: (1/2) rho c_d A, unit vector and speed of the stream."""
    direction = np.zeros(3) if d["direction"] is None else np.asarray(d["direction"], float)
    return {
        "factor": 0.5 * d["density"] * d["coefficient"] * d["area"], "law": law_of(d["speed"], context),
        "stream": direction / max(np.linalg.norm(direction), np.finfo(float).tiny),
    }  # fmt: skip


def check(d, nodes):
    """Return an error for a stream without speed or direction."""
    if (d["direction"] is None) != (d["speed"] is None):
        return ["'direction' and 'speed' of the stream belong together; without both the fluid is at rest"]
    return []


DRAG = on_demand(
    Kind(
        name="drag", section="loads", doc=__doc__, display=Display(force="force"), dtype=RECORD, layout=("x0",),
        in_fluid=True,
        fields=(
            Field("node", NODE, "-", "node that it acts on"),
            Field("area", NUMBER, "m2", "area A across the stream", check=positive),
            Field("coefficient", NUMBER, "-", "c_d", check=positive),
            Field("density", NUMBER, "kg/m3", "rho of the fluid; air at sea level when absent", AIR, positive),
            Field("direction", DIRECTION, "-", "direction of the stream, inertial, made a unit vector", None),
            Field("speed", DRIVE, "m/s", "speed of the stream; at rest when absent", None),
        ),
        outputs=(
            Output("force", "N", "drag on the node, inertial", (3,)),
            Output("dissipated_power", "W", "power dissipated in the fluid"),
        ),
        cases=({"direction": (0.3, -1.0, 0.5)}, {"density": 1e3, "speed": None}),
        **named(prepare, check),
    ),
    _functions, "speed",
)  # fmt: skip
