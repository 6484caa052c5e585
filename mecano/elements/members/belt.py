r"""Belt or cable over pulleys, on which it does not slip: hoists, block and tackle, belt drives, synchronisation loops.

It runs through ``nodes`` in their order, and from the last one back to the first if it is ``closed``. A node with a
radius is the centre of a pulley, and turns with it: give it a body (its inertia is that of the pulley) and a hinge. A
node with the radius zero is a point, to which the belt is fixed. The radius is positive where the belt turns
counter-clockwise about the ``axis``, negative where it turns clockwise: the sign selects the side of the pulley on
which a rope hangs.

Each span between two nodes is an elastic line along the common tangent of both circles, with the stiffness EA/L of its
length at the start, where its tension is ``pretension``. The belt on the pulleys is carried along: a pulley that turns
by an angle passes its radius times this angle from one span to the next, and the difference of both tensions turns it.

.. math::  T = \frac{EA}{L}\,(\Delta + \tau\dot\Delta), \qquad V = \sum \frac{EA}{2L}\,\Delta^2

A span whose tension falls to zero is slack until it has its length again: both are events. The belt has no mass, and
the stiffness of a span does not change with its length. All pulleys lie nearly in one plane; the belt stays on them.

With ``creep: true`` the belt sticks to each pulley where it runs onto it, and leaves it with the strain of the next
span: a loaded drive creeps. The driven pulley turns at the fraction (EA + T_slack)/(EA + T_tight) of the speed that the
radii imply, with the tensions of the slack and the tight span; the rest is dissipated. The stretch of a span includes
its ``creep``.

Also with ``activate`` the stretch of the spans counts from the start, and includes all turns of the pulleys since; with
``stress_free`` the belt then has its ``pretension``, on pulleys in any position, as in a drive that is engaged. A
``release`` cuts the whole belt. Neither changes velocities at once.
"""

import numpy as np

from mecano.constraints.activation import activate_field, is_stress_free
from mecano.constraints.along_coordinate.trigger import check_trigger, trigger_of
from mecano.constraints.belt_span import BELT_END, BELT_SPAN, CLOSEST, check_tangent, span_kind, span_record
from mecano.constraints.creeping_span import CREEPING_END, CREEPING_SPAN
from mecano.constraints.elastic_line import AXIAL_STIFFNESS, DAMPING
from mecano.constraints.joint_samples import rotation
from mecano.constraints.release import check_release, elastic_release
from mecano.constraints.triads import triad
from mecano.element_interface import Display, Kind, OwnOutput, Part, named
from mecano.schema import BOOLEAN, DIRECTION, NODES, NUMBER, NUMBERS, Field, not_negative


def _spans(d):
    """Return the pairs of indices of the nodes of each span; a point is the second, as the belt runs or against it."""
    n = len(d["nodes"])
    pairs = [(i, i + 1) for i in range(n - 1)] + ([(n - 1, 0)] if d["closed"] else [])
    return [(i, j, 1.0) if d["radii"][i] else (j, i, -1.0) for i, j in pairs]


def _geometry(d, nodes):
    """Yield the nodes of each span and its values of the record at the start; against the belt the sides change."""
    frame = triad(d["axis"])
    for i, j, sense in _spans(d):
        ends = [
            (np.asarray(nodes[k][0], float), frame @ nodes[k][1], nodes[k][1], sense * d["radii"][k]) for k in (i, j)
        ]
        yield (i, j), span_record(*ends)


def parts(d, nodes, context):
    """Return the Parts: one for each span."""
    found, reads = [], tuple(trigger_of(d[name]) for name in ("release", "activate") if d[name] is not None)
    activation = None if d["activate"] is None else is_stress_free(d)
    for number, (ends, values) in enumerate(_geometry(d, nodes), 1):
        stiffness = d["axial_stiffness"] / values["length"]
        more = {"stretch": d["pretension"] / stiffness, "stiffness": stiffness, "damping": d["damping"]}
        kind = span_kind(not d["radii"][ends[1]], d["release"] is not None, activation)
        if d["creep"]:
            kind, more["EA"] = CREEPING_SPAN if d["radii"][ends[1]] else CREEPING_END, d["axial_stiffness"]
            reads = tuple(OwnOutput(f"tension_{other}") for other in _neighbours(d, number - 1))
        found.append(Part(kind, ends, {**values, **more}, label=f"_{number}", reads=reads))
    return found


def _neighbours(d, i):
    """Return the numbers of the spans, from 1, at the other side of each pulley of span i; its own at a drum."""
    n = len(_spans(d))
    found = []
    for end, other in zip(_spans(d)[i][:2], (i - 1, i + 1) if _spans(d)[i][2] > 0.0 else (i + 1, i - 1), strict=True):
        if d["radii"][end]:
            inside = 0 <= other < n
            found.append(1 + (other % n if d["closed"] else other if inside else i))
    return found


def check(d, nodes):
    """Return errors in the number of nodes and radii, for neighbouring points, and for pulleys that overlap."""
    names, radii = d["nodes"], d["radii"]
    if len(names) != len(radii):
        return [f"'radii' must have {len(names)} numbers, one for each node; it has {len(radii)}"]
    if len(names) < 2 or not any(radii):
        return ["'nodes' must name at least two nodes, one of them a pulley; a cable without pulleys is a 'cable'"]
    frame, places = triad(d["axis"]), [x for x, _ in nodes]
    texts = check_release(d, []) + check_trigger("activate", d["activate"])
    texts += [f"'creep' and {name!r} exclude one another" for name in ("release", "activate") if d["creep"] and d[name]]
    for i, j, _ in _spans(d):
        if not radii[i]:
            texts.append(f"'radii': '{names[j]}' and '{names[i]}' are points next to each other: use a 'cable' there")
            continue
        texts += check_tangent(*([values[k] for k in (i, j)] for values in (names, places, radii)), frame)
    return texts


def start_warnings(d, nodes):
    """Return a warning of a closed belt without pretension, which is loose on its pulleys."""
    if not d["closed"] or d["pretension"] > 0.0:
        return []
    return ["it is closed without 'pretension': only its tight spans pull, and the others are slack; is it missing?"]


def end_conditions(d):
    """Return the end conditions of two neighbours that leave no span between them."""
    text = "has no free span left between {!r} and {!r}: they are too close"
    names = [[d["nodes"][k] for k in pair[:2]] for pair in _spans(d)]
    return [(f"closeness_{i}", CLOSEST, text.format(*pair)) for i, pair in enumerate(names, 1)]


def sample(rng):
    """Return a hoist over two pulleys, and a crossed belt drive."""
    places = np.array([[0.0, 0.0, 0.0], [0.4, 0.05, 1.0], [1.4, 0.0, 1.1], [1.8, -0.03, 0.2]])
    nodes = [(x, rotation(rng)) for x in places]
    hoist = {
        "nodes": ["a", "b", "c", "d"], "radii": [0.0, -0.2, -0.15, 0.0], "axis": [0.0, 1.0, 0.0],
        "axial_stiffness": 50.0, "pretension": 20.0, "damping": 0.1,
    }  # fmt: skip
    drive = {**hoist, "nodes": ["b", "c"], "radii": [-0.2, 0.15], "closed": True}
    once = {"time": 0.3, "when": None}
    timed = [{"release": once}, {"activate": {**once, "stress_free": True}}, {"activate": once, "release": once}]
    creeping = [({**given, "creep": True}, on, "") for given, on in ((hoist, nodes), (drive, nodes[1:3]))]
    return [(hoist, nodes, ""), (drive, nodes[1:3], ""), *creeping, *(({**hoist, **more}, nodes, "") for more in timed)]


STRESS_FREE = Field("stress_free", BOOLEAN, "-", "its spans have the pretension when it begins to act", False)
BELT = Kind(
    name="belt",
    section="elements",
    doc=__doc__,
    display=Display("belt"),
    fields=(
        Field("nodes", NODES, "-", "points and centres of pulleys, as the belt runs"),
        Field("radii", NUMBERS, "m", "radius at each node, > 0 counter-clockwise about the axis; 0 at a point"),
        Field("axis", DIRECTION, "-", "axis of all pulleys at the start, inertial"),
        Field("closed", BOOLEAN, "-", "whether it runs from the last node back to the first", False),
        AXIAL_STIFFNESS,
        Field("pretension", NUMBER, "N", "tension of all spans at the start", 0.0, not_negative),
        DAMPING,
        Field("creep", BOOLEAN, "-", "whether the belt creeps on the pulleys, as its strain changes on them", False),
        elastic_release("belt"),
        activate_field("belt", STRESS_FREE),
    ),
    optional=(
        ("nodes", BELT_SPAN, "_1"),
        ("nodes", BELT_END, "_1"),
        ("creep", CREEPING_SPAN, "_1"),
        ("creep", CREEPING_END, "_1"),
    ),
    **named(parts, check, start_warnings, end_conditions, sample),
)
