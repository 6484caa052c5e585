"""Errors and warnings about beams: impossible lines, sections too thick, elements too slender or too long."""

import math

import numpy as np

from mecano.constraints.triads import norm
from mecano.elements.members.beam_line import check_line
from mecano.elements.members.cross_section import constants
from mecano.elements.members.heated_beam import check_heating
from mecano.schema import requirement

MOST_SLENDER = 1e7  # length over radius of gyration: stiffnesses differ by its square, and have 16 digits
MOST_ELEMENTS = 10_000
check_mesh = requirement(lambda n: 1 <= n <= MOST_ELEMENTS, f"must be 1 to {MOST_ELEMENTS}")
LOST = 3e-17  # relative error of the deflection, per element and square of the slenderness of the beam (measured)
INACCURATE = 1e-6  # of the deflection
LARGE = 0.1  # strain: metals yield at 0.2 to 1 %, fibre composites break at 2 %
WIDE = 0.15  # length over width, as STOUT of a rectangle
STOUT = 0.5  # length over radius of gyration: above 1 for a beam, a thousandth of that if the section is given in mm


def check(d, nodes):
    """Return errors for an impossible line (beam_line.py) and for elements whose stiffness is lost in rounding."""
    section = constants(d["section"])
    texts = check_line(d, nodes, section.is_round) or _too_slender(d, nodes, section)
    return texts if d["thermal"] is None or texts else check_heating(d)


def _too_slender(d, nodes, section):
    slenderness = norm(np.subtract(nodes[1][0], nodes[0][0])) * section.slenderness / d["mesh"]
    if slenderness <= MOST_SLENDER:
        return []
    return [
        f"an element is {slenderness:.2g} radii of gyration of its section long, {MOST_SLENDER:g} at most: correct the "
        "places of the nodes or the 'section', or use a cable"
    ]


def start_warnings(d, nodes):
    """Return warnings about a beam that is too thick, or too slender for its numbers or for its elements."""
    section, length = constants(d["section"]), norm(np.subtract(nodes[1].x, nodes[0].x))
    hanging = [] if d["via"] is None else _hanging(d, section, length, nodes[0].gravity)
    return [*_stout(section, length), *_inaccurate(d, length * section.slenderness), *hanging]


def limits(d):
    """Return the largest normal stress or, of a section without a modulus, strain, at which it is large."""
    section = constants(d["section"])
    text = f"strains above {100.0 * LARGE:g} % are beyond its linear law: are the section and the loads in SI units?"
    if not section.E:
        return [("strain", LARGE, text)]
    return [("normal_stress", LARGE * section.E, f"{text} (E = {section.E:g} Pa)")]


def _stout(section, length):
    """Return a warning about a beam shorter than its section is thick, by its stiffness, fibres or rotary inertia."""
    slenderness, width = length * section.slenderness, 2.0 * float(np.abs(section.points).max(initial=0.0))
    doubt = "are the dimensions of the 'section' in m?"
    if slenderness < STOUT:
        return [f"it is {slenderness:.2g} radii of gyration of its section long: {doubt}"]
    if length < WIDE * width:
        return [f"it is {length:.3g} m long and {width:.3g} m wide: {doubt}"]
    radius = float(np.sqrt(np.linalg.eigvalsh(section.J)[-1] / section.mass)) if section.mass else 0.0
    if length >= radius:
        return []
    return [
        f"it is {length:.3g} m long, and the rotary inertia of its section has a radius of gyration of {radius:.3g} m: "
        "are mass and inertia per length in kg/m and kg m?"
    ]


def _hanging(d, section, length, gravity):
    """Return a warning about an arc whose weight, as a tension, may open its elements beyond their length.

    The elongation N L^3 phi^2/(720 EI) of an arc that turns by phi is that of linear statics; it exceeds the difference
    L phi^2/24 of arc and chord if N > 30 EI/L^2.
    """
    weight, bending = section.mass * length * norm(gravity), np.diag(section.C)[4:].min()
    enough = math.ceil(length * math.sqrt(weight / (30.0 * bending)))
    if d["mesh"] >= enough:
        return []
    return [
        f"its weight of {weight:.3g} N exceeds 30 EI/L^2 = {30.0 * bending * (d['mesh'] / length) ** 2:.3g} N, L the "
        f"length of an element: if it hangs, its tension may open the arcs beyond their length; write 'mesh: {enough}' "
        "or more, straight beams, or a line of cables"
    ]


def _inaccurate(d, slenderness):
    """Return a warning about a beam of whose deflections rounding leaves few digits.

    The bending stiffness is smaller than the axial one by the square of the slenderness, and follows from differences
    of the positions of nodes.
    """
    error = LOST * d["mesh"] * slenderness**2
    if error <= INACCURATE:
        return []
    digits = max(0, math.floor(-math.log10(error)))
    return [
        f"it is {slenderness:.2g} radii of gyration of its section long: rounding leaves about {digits} digits of its "
        "deflections; is the 'section' intended? A cable has no bending stiffness to lose"
    ]
