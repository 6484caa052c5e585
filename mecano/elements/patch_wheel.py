"""What the wheels with a flexible patch have in common: deck fields, outputs, energies, events, samples, warnings."""

from numba import njit

from mecano.constraints.disc import carried_axis
from mecano.constraints.ground import LEAN, check_axle, check_ground, lean_of, normal_and_level, prepare_ground, touch
from mecano.constraints.tire_patch import BOW, PSI, Y
from mecano.contract import Output
from mecano.elements.lateral_force import lateral_energy, lateral_energy_rate
from mecano.elements.lateral_law import FORMS, check_lateral, prepare_lateral
from mecano.elements.tire_law import check_tire_law, elastic_energy, elastic_force, prepare_tire_law
from mecano.maths.surface import directions
from mecano.maths.vec import add, add_vec, dot, mat, mul, put, scale, sub, vec
from mecano.schema import DIRECTION, GROUND, NODE, NUMBER, TIRE_LAW, Field, mapping

INITIAL = mapping(
    Field("y", NUMBER, "m", "lateral displacement of the patch", 0.0),
    Field("psi", NUMBER, "rad", "torsion of the patch, where the lateral law has a rate of psi", 0.0),
)
FIELDS = (
    Field("node", NODE, "-", "centre of the wheel; its rotation spins with the wheel"),
    Field("axis", DIRECTION, "-", "spin axis at the start, inertial; rolling forward turns right-handed"),
    Field("tire_law", TIRE_LAW, "-", "radius, radial force, friction and lateral law of the tyre"),
    Field("ground", GROUND, "-", "ground it rolls on"),
    Field("initial", INITIAL, "-", "the patch at the start", {}),
)
SCALARS = ("y", "psi", "bow")
OUTPUTS = (
    Output("height", "m", "height of the centre over the ground, along the normal at the contact"),
    Output("loaded_radius", "m", "distance from the centre to the contact in the wheel plane; the radius in the air"),
    Output("deformation", "m", "radial deformation w of the tyre; zero in the air"),
    Output("radial_force", "N", "radial force F_r in the plane of the wheel"),
    Output("normal_force", "N", "normal force N of the ground on the wheel"),
    Output("longitudinal_force", "N", "force of the ground on the wheel, along t = a x n/|a x n|"),
    Output("lateral_force", "N", "force of the ground on the wheel, along l = n x t (upright: the axis)"),
    Output("contact_force", "N", "force of the ground on the wheel, inertial", (3,)),
    Output("longitudinal_slip", "m/s", "patch velocity v_C along t; in the air, of the lowest point of the rim"),
    Output("lateral_slip", "m/s", "patch velocity v_C along l; in the air, of the lowest point of the rim"),
    Output("spin_rate", "rad/s", "angular velocity of the wheel along its axis"),
    Output("contact_point", "m", "contact, inertial; in the air, the lowest point of the rim", (3,)),
    Output("friction_coefficient", "-", "tangential over normal force; zero in the air"),
    Output("y", "m", "lateral displacement of the patch against the wheel plane, along -a"),
    Output("psi", "rad", "torsion of the patch: rotation of its rolling direction about n"),
    Output("bow", "m", "curvature of the contact line of a string: its second Legendre coefficient; else zero"),
    Output("tire_force", "N", "force F of the lateral law along y"),
    Output("tire_moment", "N m", "moment M of the lateral law along psi"),
    Output("aligning_moment", "N m", "aligning moment on the wheel about n"),
    Output("y_rate", "m/s", "rate of y"),
    Output("psi_rate", "rad/s", "rate of psi"),
    Output("bow_rate", "m/s", "rate of bow"),
    Output("divergence", "-", "braking force over that at which y grows on its own (Moreland: kap C K)"),
    LEAN,
)


@njit
def put_patch(p, laws, contact, k, q, v, radial, force, grip, slip_power, law, y, e):
    """Write OUTPUTS and energies of the Patch ``k``.

    radial [N] F_r; ``force`` (3,) [N] of the ground on the wheel in the ground; ``grip`` friction coefficient at work;
    ``slip_power`` [W] what friction dissipates; ``law`` the Lateral.
    """
    # an accepted step that ends at the lift-off is within the tolerance of w = 0, on either side
    touching = contact and radial > 0.0
    t, l = directions(k.a, k.g)
    w = max(0.0, p.radius - k.g.r) if contact else 0.0
    y[0] = k.g.r * k.g.q
    y[1] = k.g.r if contact else p.radius
    y[2] = w
    y[10] = dot(k.v_C, t)
    y[11] = dot(k.v_C, l)
    y[12] = dot(k.omega, k.a)
    put(y, 13, vec(q, 0))
    add_vec(y, 13, 1.0, k.rho if contact else scale(p.radius, k.g.c))
    y[17] = q[Y]
    y[18] = q[PSI]
    y[19] = q[BOW]
    y[27] = lean_of(k.g)
    for i in range(3):
        y[23 + i] = v[Y + i]
    N, f = 0.0, add(mul(mat(p.A0), vec(q, Y)), mul(mat(p.A1_air), vec(v, Y)))
    if touching:
        N = radial / k.g.q
        y[3] = radial
        y[4] = N
        y[5] = dot(force, t)
        y[6] = dot(force, l)
        put(y, 7, add(force, scale(N, k.g.n)))
        y[16] = grip
        y[26] = y[5] / p.A0[1, 0] if p.A0[1, 0] < 0.0 else 0.0
    if contact:
        f = law.f
        put(y, 20, (f[0], f[1], law.turn))
        elastic, _ = elastic_force(p, laws, w)
        e[1] = elastic_energy(p, laws, w)
        e[2] = slip_power + (N * k.g.q - elastic) * k.w1
    e[1] += lateral_energy(p, q[Y], q[PSI])
    lost = dot(f, vec(v, Y)) - lateral_energy_rate(p, q[Y], q[PSI], v[Y], v[PSI])
    if contact:
        lost -= law.turn * dot(k.g.n, k.omega)
    e[2] += max(lost, 0.0)
    e[3] = max(-lost, 0.0)


@njit
def event_values(p, m, mode, t, laws, q, v, a, R, g):
    """Write w for the touch-down, -w for the lift-off [m]."""
    axis = mul(mat(R[0]), vec(p.axis, 0))
    contact = touch(p, laws, sub(vec(q, 0), scale(q[Y], axis)), axis)
    g[0] = p.radius - contact.r
    g[1] = contact.r - p.radius


def prepare(d, nodes, context):
    """Record: axis in the node's frame, ground, tyre law."""
    return {
        "axis": carried_axis(d, nodes),
        **prepare_ground(d["ground"], context),
        **prepare_tire_law(d["tire_law"], context),
        **prepare_lateral(d["tire_law"]["lateral"], context),
        "start": [d["initial"].get("y", 0.0), d["initial"].get("psi", 0.0), 0.0],
    }


def start(p):
    """y, psi and bow at the start."""
    return p["start"]


def check(d, nodes):
    """Texts on an unusable ground or tyre law, a wheel that lies flat or starts below the ground."""
    law = d["tire_law"]
    texts = check_ground(d["ground"]) + check_tire_law(law) + check_lateral(law["lateral"])
    return texts + check_axle(d["ground"], nodes[0][0], d["axis"])


def limits(d):
    """The range of the radial law, braking at which the patch gives way sideways on its own."""
    valid, law = d["tire_law"]["valid_deformation"], d["tire_law"]
    found = [] if valid is None else [("deformation", valid, f"the radial law holds up to {valid:g} m only")]
    return found if law["lateral"] is None else [*found, ("divergence", 1.0, DIVERGENT)]


DIVERGENT = (
    "braking exceeds what the torsional stiffness of the tyre bears: its patch runs away sideways; a greater "
    "'torsional_stiffness' is needed"
)


STRING = {
    "cornering_stiffness": 2e3, "relaxation_length": 2.0, "contact_length": 3.0, "torsional_stiffness": 300.0,
    "least_speed": 1.0,
}  # fmt: skip
MATRICES = {"stiffness": [900.0, 50.0, -80.0, 300.0], "damping": [30.0, -2.0, 4.0, 20.0]}


def _sample(rng, profile, eps, mode, form):
    """(values, nodes, mode) of a large wheel near the origin, on a plane or a profile, with one form of lateral law."""
    wave = (("sine", {"amplitude": 0.3, "frequency": 0.03, "phase": 1.0, "offset": 0.0}),)
    growing = (("linear", {"slope": 1e-5, "offset": 0.5}),)
    falling = (("exponential", {"start": 1.0, "limit": 0.2, "rate": 0.2, "origin": 0.0}),)
    normal, level = normal_and_level(rng)
    ground = {"plane": {"point": -8.0 * normal, "normal": normal}, "profile": None}
    if profile:
        ground["profile"] = {"direction": rng.normal(size=3), "height": wave}
    lateral = {
        **dict.fromkeys(FORMS), form: MATRICES if form == "matrices" else STRING,
        "stiffness_by_load": growing, "stiffness_by_speed": falling,
        "damping_by_load": growing, "damping_by_speed": falling, "aligning_moment": [20.0, -30.0, 4.0, 5.0],
        "relaxation_in_air": 0.01,
    }  # fmt: skip
    tire_law = {
        "radius": 12.0, "radial": (("polynomial", {"coefficients": [0.0, 2e3, 3e2, -4.0, 0.5]}),),
        "radial_damping": 0.02, "friction": falling, "friction_by_speed": falling, "slip_regularization": eps,
        "valid_deformation": None, "lateral": lateral,
    }  # fmt: skip
    lean = level + rng.uniform(-0.5, 0.5) * normal
    return {"axis": lean, "tire_law": tire_law, "ground": ground}, 1, mode


def sample(rng):
    """Large wheels that touch the ground from near the origin: plane, profile, air; with all forms of lateral law."""
    cases = (
        (False, 0.05, "contact", "matrices"), (True, 50.0, "contact", "matrices"), (True, 0.05, "air", "matrices"),
        (True, 0.05, "contact", "string"), (False, 50.0, "contact", "straight_tangent"),
    )  # fmt: skip
    return [_sample(rng, *case) for case in cases]
