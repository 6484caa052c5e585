"""A small vocabulary of kinds and law terms, and a deck that uses all of it, for the tests of decks."""

from types import SimpleNamespace

import numpy as np

from mecano.deck.source import Source
from mecano.deck.read import deck_of
from mecano.elements.contract import Kind, Output
from mecano.errors import DeckError
from mecano.schema import (
    CURVE, DIRECTION, GROUND, INERTIA, INTEGER, LAW, NODE, NODE_PAIR, NODES, NUMBER, NUMBERS, POINTS, TEXT, TIRE_LAW,
    VECTOR, Field, choice, positive,
)  # fmt: skip


def check_spring(d, nodes):
    """Zero length is refused."""
    (x_a, _), (x_b, _) = nodes
    return ["'nodes' are at the same place: the spring has no direction"] if np.allclose(x_a, x_b) else []


def check_hinge(d, nodes):
    """The stop axis must not be parallel to the axis."""
    if d["stop_axis"] is not None and np.allclose(np.cross(d["axis"], d["stop_axis"]), 0):
        return ["'stop_axis' must not be parallel to 'axis'"]
    return []


BODY = Kind(
    name="body",
    section="elements",
    doc="A rigid body.\n",
    fields=(
        Field("node", NODE, "-", "node that carries the body"),
        Field("mass", NUMBER, "kg", "mass", check=positive),
        Field("inertia", INERTIA, "kg m2", "inertia about the centre of mass", (1.0, 1.0, 1.0)),
        Field("center_of_mass", VECTOR, "m", "centre of mass from the node", (0.0, 0.0, 0.0)),
        Field("attached", NODES, "-", "further nodes that move with the body", ()),
        Field("count", INTEGER, "-", "how many", 1, positive),
    ),
    outputs=(Output("velocity", "m/s", "velocity of the centre of mass", (3,)),),
)
SPRING = Kind(
    name="spring",
    section="elements",
    doc="A spring and damper between two nodes.",
    fields=(
        Field("nodes", NODE_PAIR, "-", "its ends"),
        Field("law", LAW, "N", "force of extension and rate"),
        Field("scale", CURVE, "-", "factor, a curve of time", 1.0),
    ),
    check=check_spring,
)
WHEEL = Kind(
    name="wheel",
    section="elements",
    doc="A wheel.",
    fields=(
        Field("node", NODE, "-", "centre"),
        Field("axis", DIRECTION, "-", "spin axis"),
        Field("tire_law", TIRE_LAW, "-", "tyre"),
        Field("ground", GROUND, "-", "ground"),
    ),
)
HINGE = Kind(
    name="hinge",
    section="joints",
    doc="A hinge.",
    fields=(
        Field("nodes", NODE_PAIR, "-", "the two nodes"),
        Field("axis", DIRECTION, "-", "hinge axis"),
        Field("stop_axis", DIRECTION, "-", "direction of the stop", None),
        Field("frame", choice("inertial", "material"), "-", "frame of the axis", "inertial"),
    ),
    check=check_hinge,
)
FORCE = Kind(
    name="force",
    section="loads",
    doc="A force.",
    fields=(Field("node", NODE, "-", "node"), Field("value", CURVE, "N", "force, a curve of time")),
)
FAKE_KINDS = {kind.name: kind for kind in (BODY, SPRING, WHEEL, HINGE, FORCE)}


def increasing(points):
    """Check: x increases."""
    for i in range(1, len(points)):
        if not points[i][0] > points[i - 1][0]:
            return f"must have strictly increasing x: point {i + 1} has {points[i][0]} after {points[i - 1][0]}"
    return None


def term(name, role, *fields, check=lambda values: []):
    """A term of a law as the deck sees it."""
    return SimpleNamespace(name=name, role=role, fields=fields, doc=f"The term {name}.", check=check)


def some_points(values):
    """Points must be there."""
    return [] if values["points"] else ["one of 'points' and 'file' must be given"]


def ordered(values):
    """The stops must leave room."""
    return [] if values["lower"] < values["upper"] else ["'lower' must be less than 'upper'"]


FAKE_TERMS = {
    t.name: t
    for t in (
        term("constant", "curve", Field("value", NUMBER, "unit of the value", "the value")),
        term("polynomial", "curve", Field("coefficients", NUMBERS, "-", "ascending powers")),
        term(
            "table",
            "curve",
            Field("points", POINTS, "-", "points [x, y]", None, increasing),
            Field("file", TEXT, "-", "CSV file in place of 'points'", None),
            Field("interpolation", choice("cubic", "linear"), "-", "between the points", "cubic"),
            check=some_points,
        ),
        term("damper", "force", Field("coefficient", NUMBER, "N s/m", "force per rate", check=positive)),
        term(
            "stop",
            "force",
            Field("lower", NUMBER, "m", "lower stop", float("-inf")),
            Field("upper", NUMBER, "m", "upper stop", float("inf")),
            check=ordered,
        ),
    )
}

VALID = """\
mecano: 1
title: "A wheel on a leg"
parameters: {sink: 3.05, mass: 82.0, steps: 4}
gravity: [0, 0, -9.81]
nodes:
  top: {position: [0, 0, 2.1], fixed: true}
  knee:
    position: [0.0, 0.0, 1.0]
    orientation: [0, 0.1, 0]
  axle: {position: [0.25, 0, 0.3225]}
elements:
  leg: {type: body, node: knee, mass: 7e1, inertia: [2.0e3, 2e3, 2000], attached: [top], count: $steps}
  hub: {type: body, node: axle, mass: $mass, inertia: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}
  absorber: {type: spring, nodes: [knee, axle], law: oleo, scale: {polynomial: {coefficients: [1, 0.5]}}}
  wheel: {type: wheel, node: axle, axis: [0, 1, 0], tire_law: nose, ground: runway}
joints:
  pin: {type: hinge, nodes: [top, knee], axis: [0, 1, 0], stop_axis: [1, 0, 0]}
  held: {type: hinge, nodes: [ground, axle], axis: [0, 1, 0]}
loads:
  push: {type: force, node: top, value: {table: {points: [[0, 0], [1, 1e3]]}}}
laws:
  oleo:
    polynomial: {coefficients: [0, 7e10]}
    damper: {coefficient: 1.19e4}
    stop: {upper: 0.3}
  smooth: 0.8
tire_laws:
  nose: {radius: 0.3225, friction: smooth}
grounds:
  runway:
    plane: {point: [0, 0, 0], normal: [0, 0, 1]}
    profile: {direction: [1, 0, 0], height: {polynomial: {coefficients: [0, 0.01]}}}
initial:
  velocities:
    - {nodes: all, velocity: [60, 0, -$sink]}
    - {nodes: [axle], angular_velocity: [0, 186, 0]}
time:
  end: 4.0
  step: 1e-3
  adaptive: {tolerance: 1e-4}
output: {every: 5e-3}
"""


def fake_sections():
    """The real sections, with two fields of tire laws."""
    from dataclasses import replace

    from mecano.deck.sections import SECTIONS
    from mecano.schema import mapping, named

    tire = mapping(
        Field("radius", NUMBER, "m", "radius", check=positive), Field("friction", CURVE, "-", "curve of the slip")
    )
    return tuple(replace(field, type=named(tire)) if field.name == "tire_laws" else field for field in SECTIONS)


def read_fake(text, file="deck.yaml", overrides=()):
    """A Deck of a text in the vocabulary of this module."""
    return deck_of(Source(file, text), "", overrides, FAKE_KINDS, fake_sections(), FAKE_TERMS)


def problems_of(text, overrides=(), file="deck.yaml"):
    """["line:column message; hint"] of the problems of a text that must be refused, by place."""
    try:
        read_fake(text, file, overrides)
    except DeckError as error:
        problems = sorted(error.problems, key=lambda p: (p.mark.file, p.mark.line, p.mark.column))
        return [f"{p.mark.line}:{p.mark.column} {p.message}" + (f"; {p.hint}" if p.hint else "") for p in problems]
    raise AssertionError("the deck was accepted")
