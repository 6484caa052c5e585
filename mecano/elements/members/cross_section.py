r"""Cross sections of beams: shapes and stiffnesses, by name in the section ``sections`` of a deck.

Section axes: 1 along the beam, 3 towards ``up`` of the beam, 2 = 3 x 1. Section forces (N, V_2, V_3, T, M_2, M_3)
follow from the strains (elongation, two shears, twist, two curvatures) by the stiffness C (6, 6). Shear stiffnesses
are reduced by the factors of Cowper (1966); the torsion of a rectangle is that of Saint-Venant.
"""

import operator
from collections.abc import Callable
from dataclasses import field
from functools import cached_property
from types import SimpleNamespace

import numpy as np

from mecano.immutable import immutable
from mecano.schema import NUMBER, POINTS, Field, Type, not_negative, positive

MATRIX = Type("matrix", "6 rows of 6 numbers, symmetric")
TRIPLE = Type("vector", "3 numbers, about the axes 1, 2, 3")
MOST_POINTS = 8
SMALLEST = 1e-100  # lower bound of stiffnesses and masses, whose squares must not vanish


@immutable
class Constants:
    """Section constants of a beam, in section axes."""

    C: np.ndarray  # (6, 6) stiffness [N, N m, N m2]
    mass: float  # per length [kg/m]
    J: np.ndarray  # (3, 3) rotary inertia per length about the mass centre [kg m]
    center: np.ndarray  # (3,) mass centre from the node [m]
    E: float = 0.0  # for the stress at the outer fibres [Pa]
    G: float = 0.0
    radius: float = 0.0  # of a round section, with fibres all around [m]
    torsion_radius: float = 0.0  # largest shear stress of torsion over G times twist [m]
    points: tuple = ()  # fibres (y, z) along the axes 2 and 3 [m]

    @cached_property
    def is_round(self):
        """True if they are the same in all directions across the beam, so that 'up' is not needed."""
        return (
            not self.points
            and _unchanged(self.C, TURN_OF_BOTH)
            and _unchanged(self.J, TURN)
            and not np.any(self.center[1:])
        )

    @cached_property
    def slenderness(self):
        """Slenderness of a length of 1 m: that over the least radius of gyration, by the stiffnesses [1/m]."""
        return np.sqrt(self.C[0, 0] / np.diag(self.C)[4:].min())

    @cached_property
    def records(self):
        """Records of elements of this section, by the values on which they depend (beam.py)."""
        return {}


@immutable
class Shape:
    """A kind of section: its deck fields, and the function deck values -> Constants."""

    name: str
    doc: str
    fields: tuple
    constants: Callable
    check: Callable = lambda d: ""
    """deck values -> text: error in their combination, or "" """
    section: str = field(default="sections", repr=False)  # of the deck


def material_check(d):
    """Check that exactly one of G and nu is given."""
    if (d["G"] is None) == (d["nu"] is None):
        return "give either 'G' or 'nu'"
    if d["nu"] is not None and not -1.0 < d["nu"] <= 0.5:
        return "'nu' must lie between -1 and 0.5"
    return ""


MATERIAL = (
    Field("E", NUMBER, "Pa", "modulus of elasticity", check=positive),
    Field("nu", NUMBER, "-", "Poisson's ratio", None),
    Field("G", NUMBER, "Pa", "shear modulus, instead of 'nu'", None, positive),
    Field("density", NUMBER, "kg/m3", "density", check=positive),
)
DAMPING = (Field("damping", NUMBER, "s", "viscous over elastic stiffness", 0.0, not_negative),)
STRESS = (
    Field("E", NUMBER, "Pa", "modulus of elasticity, for the stress in the points", 0.0, not_negative),
    Field("points", POINTS, "m", "outer fibres, from the node along the axes 2 and 3", ()),
    Field("G", NUMBER, "Pa", "shear modulus, for the stress of torsion", 0.0, not_negative),
    Field("torsion_radius", NUMBER, "m", "largest shear stress of torsion over G times twist", 0.0, not_negative),
)


def _moduli(d):
    """Return E, G, Poisson's ratio."""
    G = d["G"] if d["G"] is not None else 0.5 * d["E"] / (1.0 + d["nu"])
    return d["E"], G, 0.5 * d["E"] / G - 1.0


def _homogeneous(d, area, I2, I3, torsion, shear, **fibres):
    """Return Constants of a section of one material; ``torsion`` constant [m4], ``shear`` factors along 2 and 3."""
    E, G, _ = _moduli(d)
    C = np.diag([E * area, shear[0] * G * area, shear[1] * G * area, G * torsion, E * I2, E * I3])
    J = d["density"] * np.diag([I2 + I3, I2, I3])
    return Constants(C, d["density"] * area, J, np.zeros(3), E, G, **fibres)


def _annulus(d, inner):
    """Return Constants of a round section with this inner radius."""
    outer, (_, _, nu) = 0.5 * d["diameter"], _moduli(d)
    m2 = (inner / outer) ** 2
    area, second = np.pi * (outer**2 - inner**2), 0.25 * np.pi * (outer**4 - inner**4)
    square = (1.0 + m2) ** 2
    k = 6.0 * (1.0 + nu) * square / ((7.0 + 6.0 * nu) * square + (20.0 + 12.0 * nu) * m2)
    return _homogeneous(d, area, second, second, 2.0 * second, (k, k), radius=outer, torsion_radius=outer)


def rectangle(d):
    """Return Constants of a rectangle: width along axis 2, height along axis 3."""
    b, h = d["width"], d["height"]
    _, _, nu = _moduli(d)
    k = 10.0 * (1.0 + nu) / (12.0 + 11.0 * nu)
    torsion, lever = _torsion_of_rectangle(max(b, h), min(b, h))
    points = tuple((0.5 * y * b, 0.5 * z * h) for y in (-1, 1) for z in (-1, 1))
    fibres = {"points": points, "torsion_radius": lever}
    return _homogeneous(d, b * h, b * h**3 / 12.0, h * b**3 / 12.0, torsion, (k, k), **fibres)


def _torsion_of_rectangle(a, b):
    """Return torsion constant [m4], max. shear stress over G times twist [m]; sides a >= b (Timoshenko & Goodier)."""
    n = np.arange(1, 60, 2)
    arm = n * np.pi * a / (2.0 * b)
    constant = a * b**3 / 3.0 * (1.0 - 192.0 * b / (np.pi**5 * a) * np.sum(np.tanh(arm) / n**5))
    lever = b * (1.0 - 8.0 / np.pi**2 * np.sum(1.0 / (n**2 * np.cosh(np.minimum(arm, 700.0)))))
    return constant, lever


def _given(d, C, mass, J, center):
    """Return Constants of a section given by numbers."""
    fibres = {"E": d["E"], "G": d["G"], "torsion_radius": d["torsion_radius"]}
    return Constants(C, mass, J, center, points=tuple(map(tuple, d["points"])), **fibres)


def stiffness(d):
    """Return Constants from principal stiffnesses."""
    C = np.diag([d[key] for key in ("EA", "GA2", "GA3", "GJ", "EI2", "EI3")])
    return _given(d, C, d["mass_per_length"], np.diag(d["rotary_inertia"]), np.zeros(3))


def matrix(d):
    """Return Constants from matrices."""
    M = np.asarray(d["mass"])
    mass, first = M[0, 0], M[:3, 3:]
    c = np.array([first[1, 2], first[2, 0], first[0, 1]]) / mass
    return _given(d, np.asarray(d["stiffness"]), mass, M[3:, 3:] - mass * (c @ c * np.eye(3) - np.outer(c, c)), c)


def check_tube(d):
    """Check that the wall fits into the tube."""
    if 2.0 * d["thickness"] >= d["diameter"]:
        return "'thickness' must be less than half of 'diameter'; a solid section is a 'circle'"
    return material_check(d)


def check_given(d):
    """Check the number of points."""
    return f"'points' must contain at most {MOST_POINTS} points" if len(d["points"]) > MOST_POINTS else ""


def check_matrix(d):
    """Check for positive definite matrices, and for the mass matrix of a plane section."""
    for name in ("stiffness", "mass"):
        if np.linalg.eigvalsh(d[name])[0] <= 0.0:
            return f"'{name}' must be positive definite"
    M = np.asarray(d["mass"])
    first = M[:3, 3:]
    if not (np.allclose(M[:3, :3], M[0, 0] * np.eye(3), atol=0.0) and np.allclose(first, -first.T, atol=1e-12)):
        return "'mass' must have the form [[m I, -m hat(c)], [m hat(c), J]] with the mass centre c"
    return check_given(d)


def none_negative(values):
    """Check that all values are >= 0."""
    wrong = [f"[{i}] is {value:g}" for i, value in enumerate(values) if not value >= 0]
    return f"must not be negative, but {' and '.join(wrong)}" if wrong else None


def _length(name, doc):
    return Field(name, NUMBER, "m", doc, check=positive)


SHAPES = {
    shape.name: shape
    for shape in (
        Shape("circle", "Solid round section; shear factor 6 (1 + nu)/(7 + 6 nu), Cowper (1966).",
              (_length("diameter", "diameter"), *MATERIAL, *DAMPING),
              lambda d: _annulus(d, 0.0), material_check),
        Shape("tube", "Hollow round section; shear factor of Cowper (1966), near 1/2 if the wall is thin.",
              (_length("diameter", "outer diameter"), _length("thickness", "wall thickness"), *MATERIAL, *DAMPING),
              lambda d: _annulus(d, 0.5 * d["diameter"] - d["thickness"]), check_tube),
        Shape("rectangle", "Solid rectangle; shear factor 10 (1 + nu)/(12 + 11 nu), Cowper (1966).",
              (_length("width", "width, along axis 2"), _length("height", "height, along axis 3"), *MATERIAL, *DAMPING),
              rectangle, material_check),
        Shape("stiffness", "Section given by its principal stiffnesses; mass centre and shear centre on the node.",
              (Field("EA", NUMBER, "N", "axial stiffness", check=positive),
               Field("GA2", NUMBER, "N", "shear stiffness along axis 2", check=positive),
               Field("GA3", NUMBER, "N", "shear stiffness along axis 3", check=positive),
               Field("GJ", NUMBER, "N m2", "torsional stiffness", check=positive),
               Field("EI2", NUMBER, "N m2", "bending stiffness about axis 2", check=positive),
               Field("EI3", NUMBER, "N m2", "bending stiffness about axis 3", check=positive),
               Field("mass_per_length", NUMBER, "kg/m", "mass per length", check=not_negative),
               Field("rotary_inertia", TRIPLE, "kg m", "rotary inertia per length", check=none_negative),
               *STRESS, *DAMPING),
              stiffness, check_given),
        Shape("matrix", "Section given by matrices, in the order (N, V_2, V_3, T, M_2, M_3).",
              (Field("stiffness", MATRIX, "N, N m, N m2", "section forces from strains"),
               Field("mass", MATRIX, "kg/m, kg, kg m", "mass per length, momenta from velocities"), *STRESS, *DAMPING),
              matrix, check_matrix),
    )
}  # fmt: skip


def check_section(d):
    """Return an error in the combination of the deck values of a section, or None."""
    return SHAPES[d["type"]].check(d) or _out_of_range(constants(d))


def _out_of_range(section):
    """Return a text if stiffnesses of Constants, or a mass that is not zero, overflow or vanish, else None."""
    numbers = np.append(np.diag(section.C), [section.mass] if section.mass else [])
    if (numbers > SMALLEST).all() and (numbers < 1.0 / SMALLEST).all():
        return None
    return f"gives stiffnesses or a mass that overflow or vanish: {', '.join(f'{number:g}' for number in numbers)}"


def constants(d):
    """Return Constants for the deck values of a section; those of the last one are kept, for beams in a row."""
    values = list(d.values())
    if not (len(values) == len(_last.values) and all(map(operator.is_, values, _last.values))):
        _last.values, _last.constants = values, SHAPES[d["type"]].constants(d)
    return _last.constants


_last = SimpleNamespace(values=(), constants=None)  # values of the last section, and its Constants
TURN = np.array([[1.0, 0.0, 0.0], [0.0, np.cos(1.0), -np.sin(1.0)], [0.0, np.sin(1.0), np.cos(1.0)]])  # any, about 1
TURN_OF_BOTH = np.kron(np.eye(2), TURN)  # of forces and of moments


def _unchanged(A, Q):
    """Return True if Q A Q^T equals A within round-off; avoids the overhead of numpy.allclose, once per beam."""
    return bool((np.abs(Q @ A @ Q.T - A) <= 1e-12 * A.max() + 1e-5 * np.abs(A)).all())
