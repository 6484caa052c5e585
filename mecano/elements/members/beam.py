r"""Beam: geometrically exact, shear-deformable, two nodes; initially straight, curved or twisted.

Strains are those of a helix between the end sections, exact for rigid motions and independent of the path (Sonneville,
Cardona & Bruels 2014); the stiffness is exact for the linear statics of the element, which avoids locking; inertia and
weight are interpolated by cubics. With ``mesh: n`` a beam named leg becomes the elements leg.1 ... leg.n between the
nodes leg.1 ... leg.(n-1), to which other parts of the deck may refer. For its accuracy see docs/beams.md.

Section axes: 1 along the beam from the first node to the second, 3 towards ``up`` at the start, 2 = 3 x 1. They follow
an arc, and ``twist`` turns them about axis 1. Nodes may have any orientation. Section forces are those that the part
behind a section exerts on the part before it: N > 0 is tension, M_2 > 0 stretches the fibres
towards axis 3, M_3 < 0 those towards axis 2. Damping is proportional to the stiffness, with the factor of the section.

Stresses are those of the elastic strains: E (elongation + kappa_2 z - kappa_3 y) in the outer fibres, G twist
torsion_radius in torsion; the von Mises equivalent stress combines both as if at the same point, and omits the shear
stress of the shear forces.
"""

from dataclasses import replace

import numpy as np

from mecano.constraints.along_coordinate.demand import as_formula, is_formula
from mecano.constraints.elastic_line import STRAIN_OF_STEEL
from mecano.constraints.joint_samples import rotation
from mecano.constraints.triads import hat, unit
from mecano.element_interface import POWERS, Display, Kind, Output, named, record
from mecano.elements.members.beam_checks import check, check_mesh, limits, start_warnings
from mecano.elements.members.beam_elastic import (
    add_elastic,
    bent_line,
    end_loads,
    rate_along,
    strain_rates,
    strains,
    stresses,
    unstretched,
)
from mecano.elements.members.beam_flexibility import elastic_constants
from mecano.elements.members.beam_inertia import add_inertia, energies, inertia_record
from mecano.elements.members.beam_line import screw, stations
from mecano.elements.members.beam_section_forces import (
    helix,
    largest_stresses,
    local_strains,
    middle_rotation,
    section_forces,
)
from mecano.elements.members.cross_section import MOST_POINTS, constants
from mecano.elements.members.heated_beam import (
    CURVES,
    THERMAL,
    force_by_laws,
    force_by_signals,
    heating,
    observed,
    of_laws,
    of_signals,
    thermal_record,
    thermal_values,
)
from mecano.jit.kernel import kernel
from mecano.maths.dual import anywhere, at_least
from mecano.maths.vector import dot, mat, put, vec
from mecano.schema import DIRECTION, INTEGER, NODE_PAIR, NUMBER, POINT, SECTION, Field

MOST_RECORDS = 1000  # of a section that are kept
RECORD = record(
    S=(3, 3), K_uu=(3, 3), K_up=(3, 3), K_pp=(3, 3), D=(3, 3), shift=(3, 3), along=3, u0=3, phi0=3,
    damping=(), gravity=3,
    mass=(), eccentric="i", J1=(3, 3), J2=(3, 3), J12=(3, 3), c1=3, t1=3, c2=3, t2=3,
    axes=(3, 3), F_uu=(3, 3), F_up=(3, 3), F_pp=(3, 3),
    E=(), G=(), radius=(), torsion_radius=(), n_points="i", points=(MOST_POINTS, 2),
)  # fmt: skip


# The tangents are written by hand: with dual numbers a step of the deck flexible_pendulum takes 2.5 times as long.
@kernel
def force(p, at, f, K, C, M):
    """Add elastic forces, damping, inertia and weight; see element_interface for the arguments."""
    add_elastic(p, at, vec(p.u0, 0), vec(p.phi0, 0), f, K, C)
    add_inertia(p, at, f, K, C, M)


@kernel
def _at_ends(p, s, g, e_u, e_phi):
    """Return force and moments at both ends, in section axes of node 2 (the first moment in those of node 1)."""
    p_u, p_phi = stresses(p, e_u, e_phi)
    P, _, m_1, m_2 = end_loads(p, s, unstretched(p, p_u, g), p_phi)
    return P, -(mat(p.S).T @ m_1), m_2


@kernel
def observe(p, at, F, y, e):
    """Write section forces, strains, stress, energies."""
    observe_from(p, at, vec(p.u0, 0), vec(p.phi0, 0), y, e)


@kernel
def observe_from(p, at, u0, phi0, y, e):
    """Write outputs and energies for the strain-free screw (u0, phi0); return its generalized forces."""
    s, e_u, e_phi = strains(p, at, u0, phi0)
    line = bent_line(p, s.u, e_u)
    u_rate, phi_rate, _ = strain_rates(p, at, s)
    e_u, u_rate = e_u + line.more * vec(p.along, 0), rate_along(p, u_rate, line.g)
    p_u, p_phi = stresses(p, e_u, e_phi)
    rate_u, rate_phi = stresses(p, u_rate, phi_rate)
    elastic = 0.5 * (dot(e_u, p_u) + dot(e_phi, p_phi))
    dissipated = p.damping * (dot(u_rate, rate_u) + dot(phi_rate, rate_phi))
    N, first, second = _at_ends(p, s, line.g, e_u, e_phi)
    path = helix(s)
    middle = middle_rotation(p, s, path, (N, first), line.length)
    N, M, N_1, N_2, M_1, M_2 = section_forces(p, path, middle, N, first, second)
    strain, curvature = local_strains(p, N, M)
    normal, shear, equivalent = largest_stresses(p, N, M)
    for N_end, M_end in ((N_1, M_1), (N_2, M_2)):
        n_end, s_end, e_end = largest_stresses(p, N_end, M_end)
        normal, shear, equivalent = at_least(normal, n_end), at_least(shear, s_end), at_least(equivalent, e_end)
    if anywhere(p.damping > 0.0):
        total_u, total_phi = e_u + p.damping * u_rate, e_phi + p.damping * phi_rate
        N, first, second = _at_ends(p, s, line.g, total_u, total_phi)
        N, M, N_1, N_2, M_1, M_2 = section_forces(p, path, middle, N, first, second)
    for i, value in ((0, N), (3, M), (6, M_1), (9, M_2), (12, strain), (15, curvature)):
        put(y, i, value)
    kinetic, weight = energies(p, at.q, at.v, mat(at.R[0]), mat(at.R[1]))
    y[18], y[19], y[20] = normal, shear, equivalent
    y[21], y[22] = elastic, kinetic
    e[0] = kinetic
    e[1] = elastic + weight
    e[2] = dissipated
    return p_u, p_phi


def divide(d, nodes):
    """Return the intermediate nodes (x, R) of a member, oriented as its first node, and the values of each element."""
    at, common = stations(d, nodes), {**d, "mesh": 1, "constants": constants(d["section"])}
    inner = [(x, nodes[0][1]) for x, _ in at[1:-1]]
    return inner, [{**common, "stations": pair} for pair in zip(at[:-1], at[1:], strict=True)]


def prepare(d, nodes, context):
    """Return the record of one element; equal elements share one, which must not be changed."""
    (_, A_1), (_, A_2) = ends = d.get("stations") or stations(d, nodes)
    section = d.get("constants") or constants(d["section"])
    S_1, S_2, h0 = nodes[0][1].T @ A_1, nodes[1][1].T @ A_2, screw(*ends)
    damping, gravity = d["section"]["damping"], context.gravity
    key = damping, *(array.tobytes() for array in (gravity, S_1, S_2, h0))
    if key not in section.records:
        if len(section.records) == MOST_RECORDS:
            section.records.clear()
        section.records[key] = _record(section, damping, gravity, S_1, S_2, h0)
    return section.records[key]


def _record(section, damping, gravity, S_1, S_2, h0):
    """Return the record of an element; S_i: section to node axes, h0 (6,): strain-free screw in section axes."""
    c, u, phi = section.center, h0[:3], h0[3:]
    K_uu, K_up, K_pp, D, shift, F = elastic_constants(section.C, h0)
    length, tangent = np.linalg.norm(u), u + hat(phi) @ c
    points = np.zeros((MOST_POINTS, 2))
    points[: len(section.points)] = np.reshape(section.points, (-1, 2))
    return {
        "S": S_1 @ S_2.T, "K_uu": S_2 @ K_uu @ S_2.T, "K_up": S_2 @ K_up @ S_2.T, "K_pp": S_2 @ K_pp @ S_2.T,
        "D": S_2 @ D @ S_2.T, "shift": S_2 @ shift @ S_2.T,
        "along": S_2[:, 0], "u0": S_2 @ (u + shift @ phi), "phi0": S_2 @ phi,
        "damping": damping, "gravity": gravity,
        **inertia_record(section.mass * length, section.J * length, S_1, S_2, c, tangent),
        "axes": S_2, "F_uu": F[:3, :3], "F_up": F[:3, 3:], "F_pp": F[3:, 3:],
        "E": section.E, "G": section.G,
        "radius": section.radius, "torsion_radius": section.torsion_radius,
        "n_points": len(section.points), "points": points,
    }  # fmt: skip


def variant(d):
    """Return the beam whose shape is constant, or the one that is heated by laws or by signals."""
    if d["thermal"] is None:
        return BEAM
    return HEATED_BY_SIGNALS if any(map(is_formula, heating(d))) else HEATED_BEAM


def sample(rng):
    """Return beams: straight; twisted, damped; curved, twisted, full matrices, offset mass, any node orientation."""
    material = {"E": 60.0, "nu": 0.3, "G": None, "density": 0.7, "damping": 0.0}
    tube = {"type": "tube", "diameter": 0.6, "thickness": 0.1, **material}
    plank = {"type": "rectangle", "width": 0.5, "height": 0.3, **material, "damping": 0.2}
    A, B = rng.normal(size=(2, 6, 6))
    c = rng.normal(size=3) * 0.2
    first = -1.3 * np.cross(np.eye(3), c)
    mass = np.block([[1.3 * np.eye(3), first], [first.T, 0.3 * (B @ B.T)[:3, :3] + 0.5 * np.eye(3)]])
    general = {
        "type": "matrix", "stiffness": 5.0 * np.eye(6) + A @ A.T, "mass": mass, "E": 3.0, "G": 1.0,
        "torsion_radius": 0.2, "points": [[0.1, 0.2], [-0.3, 0.1]], "damping": 0.1,
    }  # fmt: skip
    x, axis, across = rng.normal(size=(3, 3))
    axis, across = unit(axis), unit(np.cross(axis, across))
    nodes = [(x, rotation(rng)), (x + 1.4 * axis, rotation(rng))]
    sine = (("sine", {"amplitude": 0.1, "frequency": 0.4, "phase": 0.3, "offset": 0.05}),)
    heat = {"strain": sine, "curvature_2": 0.2, "curvature_3": sine}
    bow = {"via": x + 0.7 * axis + 0.55 * across, "twist": 0.8, "up": across + 0.5 * axis}
    return [
        ({"section": tube}, 2, ""),
        ({"section": plank, "up": across, "twist": -1.1}, nodes, ""),
        ({"section": general, **bow}, nodes, ""),
        ({"section": general, **bow, "thermal": heat}, nodes, ""),
        ({"section": general, **bow, "thermal": {**dict.fromkeys(heat, 0.1), "strain": "1 + 2*command"}}, nodes, ""),
    ]


OUTPUTS = (
    Output("force", "N", "section force (N, V_2, V_3) in the middle, section axes", (3,)),
    Output("moment", "N m", "section moment (T, M_2, M_3) in the middle, section axes", (3,)),
    Output("moment_start", "N m", "section moment at the first node, section axes there", (3,)),
    Output("moment_end", "N m", "section moment at the second node, section axes there", (3,)),
    Output("strain", "-", "elongation and shear strains in the middle", (3,)),
    Output("curvature", "1/m", "twist and curvatures in the middle, beyond those of the free shape", (3,)),
    Output("normal_stress", "Pa", "largest normal stress of the outer fibres, at the ends and in the middle"),
    Output("torsion_stress", "Pa", "largest shear stress of torsion"),
    Output("stress", "Pa", "largest von Mises stress, from the normal stress and the shear stress of torsion"),
    Output("strain_energy", "J", "strain energy"),
    Output("kinetic_energy", "J", "kinetic energy"),
)
BEAM = Kind(
    name="beam", section="elements", doc=__doc__, display=Display("beam", pictures=("beams",), axial="force"),
    dtype=RECORD, layout=("x0", "R0", "x1", "R1"),
    fields=(
        Field("nodes", NODE_PAIR, "-", "its ends"),
        Field("section", SECTION, "-", "cross section"),
        Field("mesh", INTEGER, "-", "number of elements", 1, check_mesh),
        Field("up", DIRECTION, "-", "towards axis 3 of the section at the start; if round, only for 'thermal'", None),
        Field("via", POINT, "m", "point through which it bends as a circular arc; straight when absent", None),
        Field("twist", NUMBER, "rad", "angle by which the section turns about axis 1 from start to end", 0.0),
        THERMAL,
    ),
    outputs=OUTPUTS,
    hidden=dict.fromkeys([output.name for output in OUTPUTS], "read the reaction of a joint at its end, such as fixed")
    | dict.fromkeys(POWERS, "it is part of the 'energy.dissipated' and 'energy.given' of the results"),
    flexible=True,
    strains=(-STRAIN_OF_STEEL, STRAIN_OF_STEEL),
    by_lanes=True,
    **named(variant, prepare, divide, check, start_warnings, limits, force, observe, sample),
)  # fmt: skip
HEATED_BEAM = replace(
    BEAM,
    name="heated_beam", dtype=thermal_record(RECORD),
    prepare=lambda d, nodes, context: thermal_values(d, prepare(d, nodes, context), context),
    force=force_by_laws,
    by_lanes=False,
    observe=observed(observe_from, of_laws),
)  # fmt: skip
HEATED_BY_SIGNALS = replace(
    HEATED_BEAM,
    name="beam_heated_by_signals",
    inputs=CURVES,
    reads=lambda d: list(map(as_formula, heating(d))),
    force=force_by_signals,
    observe=observed(observe_from, of_signals),
)
