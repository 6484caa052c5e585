"""A small set of kinds and law terms, and a deck that uses all of them, for the tests of decks."""

from dataclasses import replace

import numpy as np

from mecano.deck.read import deck_of
from mecano.deck.sections import SECTIONS
from mecano.deck.source import Source
from mecano.element_interface import Kind, Output
from mecano.errors import DeckError
from mecano.schema import (
    CURVE,
    DIRECTION,
    GROUND,
    INERTIA,
    INTEGER,
    LAW,
    NODE,
    NODE_PAIR,
    NODE_VECTOR,
    NODES,
    NUMBER,
    TIRE_LAW,
    Field,
    choice,
    mapping,
    named,
    positive,
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
        Field("center_of_mass", NODE_VECTOR, "m", "centre of mass from the node", (0.0, 0.0, 0.0)),
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
    stop: {upper: 0.3, stiffness: 1e6}
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

# in the vocabulary of mecano
REAL = """\
mecano: 1
gravity: [0, 0, -9.81]
nodes:
  a: {position: [0, 0, 0]}
  b: {position: [0, 0, 0]}
  c: {position: [1, 0, 0]}
elements:
  body: {type: rigid_body, node: a, mass: 2, inertia: [1, 2, 3]}
  arm: {type: rigid_body, node: b, mass: 2, inertia: [1, 1, 1]}
  dot: {type: point_mass, node: c, mass: 3}
  coil: {type: spring_damper, nodes: [b, c], law: {spring: {stiffness: 10}}}
  wheel: {type: wheel, node: a, axis: [0, 1, 0], tire_law: tyre, ground: flat}
joints:
  cross: {type: universal, nodes: [a, b], axis_a: [1, 0, 0], axis_b: [0, 1, 0]}
tire_laws:
  tyre: {radius: 0.3, radial: {linear: {slope: 1e5}}, friction: 0.8, slip_regularization: 0.1}
grounds:
  flat: {plane: {point: [0, 0, -0.3], normal: [0, 0, 1]}}
time: {end: 1, step: 0.01}
"""


def fake_sections():
    """The real sections, with two fields of tyre laws."""
    radius = Field("radius", NUMBER, "m", "radius", check=positive)
    tire = mapping(radius, Field("friction", CURVE, "-", "curve of the slip"))
    return tuple(replace(field, type=named(tire)) if field.name == "tire_laws" else field for field in SECTIONS)


FAKE = {"kinds": FAKE_KINDS, "sections": fake_sections()}


def read_fake(text, file="deck.yaml", overrides=()):
    """The Deck of a text in the vocabulary of this module."""
    return deck_of(Source(file, text), overrides=overrides, **FAKE)


def problems_of(text, overrides=(), file="deck.yaml"):
    """["line:column message; hint"] of the problems of a text that must be refused, by place."""
    try:
        read_fake(text, file, overrides)
    except DeckError as error:
        problems = sorted(error.problems, key=lambda p: (p.mark.file, p.mark.line, p.mark.column))
        return [f"{p.mark.line}:{p.mark.column} {p.message}" + (f"; {p.hint}" if p.hint else "") for p in problems]
    raise AssertionError("the deck was accepted")
