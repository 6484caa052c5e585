r"""Contact of a ball around node b with a surface fixed in node a: a plane, sphere, cylinder or capsule.

Without ``law`` the contact is rigid: it closes with a shock (docs/shocks.md), rebounds with the coefficient of
``restitution``, and opens where the normal force N, its multiplier, falls to zero. While closed it is held at the gap
of the last step before the shock.

With a law ``law`` of the depth w, by which both bodies overlap, it is elastic, and damped after Hunt and Crossley:

.. math::  N = F(w)\,\max(0, 1 + c\,\dot w)

``friction`` opposes the velocity u of the ball along the surface, :math:`F_t = -\mu(|u|)\,\phi(|u|)\,N u/|u|`, with
:math:`\phi(u) = (u/\epsilon)(2 - u/\epsilon)` below the speed :math:`\epsilon` of the ``regularization``, 1 beyond: a
resting ball creeps. A rigid contact exerts it while it is closed, with its multiplier N; a shock is without friction.
Node a needs an orientation (a body, a beam or the ground), with friction node b, too. A capsule or a box that touches a
plane is a ball at each end or corner, on nodes attached to the body. The surface of a cylinder has no ends; a pin in
a hole is a ball of the radius of the pin ``inside`` of a cylinder.
"""

from dataclasses import replace

import numpy as np

from mecano.constraints.along_coordinate.friction import check_friction, friction_fields
from mecano.constraints.along_coordinate.sense import quantity_sensor
from mecano.constraints.augmented_lagrangian import add_reaction
from mecano.constraints.touching import (
    FIELDS,
    SURFACE_RECORD,
    approach,
    check_surface,
    gap_at_start,
    sliding,
    surface_record,
    touch,
)
from mecano.element_interface import CONTACT as SHOCK
from mecano.element_interface import Display, Event, Kind, Output, Part, Row, record
from mecano.jit.kernel import kernel
from mecano.laws.contact_force import contact_force, elastic_energy, elastic_force
from mecano.laws.friction import friction
from mecano.laws.probe import curve_at
from mecano.maths.dual import at_least
from mecano.maths.vector import ZERO, add_vec, cross, dot, mat, norm, put, vec
from mecano.schema import CURVE, NODE_PAIR, NUMBER, Field, not_negative, share

RECORD = record(law="i", damping=(), restitution=(), coefficient="i", regularization=(), **SURFACE_RECORD)
OPEN, CLOSED = 0, 1
PHASES = ("open", "closed")
ROUNDING = 1e-9  # [m]
MULTIPLIER = 9  # of a rigid contact, after positions and the rotation of a
ROUGH_MULTIPLIER = 12  # of a rigid contact with friction, after positions and rotations
NORMAL = Row("normal force of the contact", "N", "m", unilateral=True)
OPENS = Event("opens", "closed", "open", "the normal force falls to zero")


@kernel
def _normal_force(p, at, touched):
    """Return N of an elastic contact."""
    return contact_force(at.laws, p.law, p.damping, -touched.gap, approach(touched, at))


@kernel
def _friction(p, at, touched, N):
    """Return the friction on the ball [N] and the velocity of sliding [m/s], inertial."""
    u = sliding(touched, at)
    return -(N * friction(at.laws, p.coefficient, p.regularization, norm(u))) * u, u


@kernel
def _add_on_a(f, at, touched, on_b):
    """Add the force opposite to that on the ball, and its moment about node a."""
    add_vec(f, 0, 1.0, on_b)
    add_vec(f, 3, 1.0, mat(at.R[0]).T @ cross(touched.a, on_b))


@kernel
def smooth_residual(p, at, f):
    """Add the normal force of an elastic contact."""
    if at.phase == CLOSED:
        touched = touch(p, at)
        on_b = _normal_force(p, at, touched) * touched.n
        _add_on_a(f, at, touched, on_b)
        add_vec(f, 6, -1.0, on_b)


@kernel
def rough_residual(p, at, f):
    """Add normal force and friction of an elastic contact."""
    if at.phase == CLOSED:
        touched = touch(p, at)
        N = _normal_force(p, at, touched)
        on_b = N * touched.n + _friction(p, at, touched, N)[0]
        _add_on_a(f, at, touched, on_b)
        add_vec(f, 6, -1.0, on_b)
        add_vec(f, 9, -1.0, mat(at.R[1]).T @ cross(touched.b, on_b))


@kernel
def _gradient(at, touched):
    """Return the gradient of the gap by blocks of the local unknowns."""
    return (0, -touched.n), (3, -(mat(at.R[0]).T @ cross(touched.a, touched.n))), (6, touched.n)


@kernel
def rigid_residual(p, at, f):
    """Add the constraint of a rigid contact."""
    if at.phase == OPEN:
        f[MULTIPLIER] -= at.q[MULTIPLIER]
    else:
        touched = touch(p, at)
        Phi = touched.gap - at.m[0]
        add_reaction(f, MULTIPLIER, at.k, at.penalty, Phi, at.q[MULTIPLIER], _gradient(at, touched))


@kernel
def rigid_constraints(p, at, g):
    """Write the gap relative to the held one, and its rate."""
    g[0, 0] = g[0, 1] = 0.0
    if at.phase == CLOSED:
        touched = touch(p, at)
        g[0, 0], g[0, 1] = touched.gap - at.m[0], -approach(touched, at)


@kernel
def _put(p, at, touched, N, F_t, u, y):
    """Write gap, normal force, friction, speed of sliding, force on the ball, contact point, state."""
    y[0], y[1], y[2], y[3] = touched.gap, N, norm(F_t), norm(u)
    put(y, 4, N * touched.n + F_t)
    put(y, 7, vec(at.q, 6) + touched.b)
    y[10] = float(at.phase)


@kernel
def _put_energies(p, at, touched, N, e):
    """Write the elastic energy and the power dissipated by damping."""
    w = -touched.gap
    e[1] = elastic_energy(at.laws, p.law, at_least(w, 0.0))
    e[2] = (N - elastic_force(at.laws, p.law, w)) * approach(touched, at)


@kernel
def observe_smooth(p, at, F, y, e):
    """Write outputs and energies of an elastic contact without friction."""
    touched, N = touch(p, at), 0.0
    if at.phase == CLOSED:
        N = _normal_force(p, at, touched)
        _put_energies(p, at, touched, N, e)
    _put(p, at, touched, N, ZERO, ZERO, y)


@kernel
def observe_rough(p, at, F, y, e):
    """Write outputs and energies of an elastic contact with friction."""
    touched, N = touch(p, at), 0.0
    if at.phase == CLOSED:
        N = _normal_force(p, at, touched)
        _put_energies(p, at, touched, N, e)
    F_t, u = _friction(p, at, touched, N)
    e[2] -= dot(F_t, u)
    _put(p, at, touched, N, F_t, u, y)


@kernel
def observe_rigid(p, at, F, y, e):
    """Write the outputs of a rigid contact."""
    _put(p, at, touch(p, at), at.q[MULTIPLIER], ZERO, ZERO, y)


@kernel
def friction_residual(p, at, f):
    """Add the friction of a rigid contact, whose multiplier is coupled."""
    touched = touch(p, at)
    on_b = _friction(p, at, touched, at_least(at.q[ROUGH_MULTIPLIER], 0.0))[0]
    _add_on_a(f, at, touched, on_b)
    add_vec(f, 6, -1.0, on_b)
    add_vec(f, 9, -1.0, mat(at.R[1]).T @ cross(touched.b, on_b))


@kernel
def observe_rigid_rough(p, at, F, y, e):
    """Write the outputs of a rigid contact with friction, and the power that it dissipates."""
    touched, N = touch(p, at), at_least(at.q[ROUGH_MULTIPLIER], 0.0)
    F_t, u = _friction(p, at, touched, N)
    e[2] = -dot(F_t, u)
    _put(p, at, touched, N, F_t, u, y)


@kernel
def rigid_rough_events(p, at, g):
    """Write the depth [m], and -N [N]."""
    g[0], g[1] = -touch(p, at).gap, -at.q[ROUGH_MULTIPLIER]


@kernel
def elastic_events(p, at, g):
    """Write the depth [m], and the gap."""
    gap = touch(p, at).gap
    g[0], g[1] = -gap, gap


@kernel
def rigid_events(p, at, g):
    """Write the depth [m], and -N [N]."""
    g[0], g[1] = -touch(p, at).gap, -at.q[MULTIPLIER]


@kernel
def commit(p, at, m_out):
    """Write the gap of the last step before the contact."""
    m_out[0] = at.m[0] if at.phase == CLOSED else touch(p, at).gap


def prepare(d, nodes, context):
    """Return the record of one contact."""
    values = {"damping": d["damping"], "restitution": d["restitution"], **surface_record(d, nodes)}
    if d["law"] is not None:
        values["law"] = context.laws.add(d["law"])
    if d["friction"] is not None:
        values["coefficient"] = context.laws.add(d["friction"]["coefficient"])
        values["regularization"] = d["friction"]["regularization"]
    return values


def rigid_rough_parts(d, nodes, context):
    """Return the constraint of a rigid contact, and the friction that it causes."""
    p = prepare(d, nodes, context)
    return [Part(RIGID_PART, (0, 1), p), Part(FRICTION_PART, (0, 1), p, coupled_to=(0,))]


def variant(d):
    """Return the kind of a rigid or elastic contact, with or without friction."""
    if d["law"] is None:
        return CONTACT if d["friction"] is None else RIGID_ROUGH_CONTACT
    return SMOOTH_CONTACT if d["friction"] is None else ROUGH_CONTACT


def check(d, nodes):
    """Return errors in the surface, in the law, and for values that have no effect on this contact."""
    texts = check_surface(d, nodes)
    if d["law"] is None:
        texts += ["'damping' needs 'law': a rigid contact has none"] if d["damping"] else []
        texts += check_friction(d)
        if not texts and (gap := gap_at_start(d, nodes)[0]) < -ROUNDING:
            texts.append(f"the ball starts {-gap:.6g} m within the surface, which is rigid without 'law'")
        return texts
    if d["restitution"]:
        texts.append("'restitution' applies to a rigid contact only; with 'law' give 'damping'")
    at_zero, slope, _ = curve_at(d["law"], 0.0)
    if at_zero != 0.0 or slope < 0.0:
        texts.append("'law' must be zero at zero depth and must not fall there")
    return texts + check_friction(d)


def sample(rng):
    """Return rigid and elastic contacts of all surfaces, open and closed, with and without friction."""
    law = (("power", {"coefficient": 3e2, "exponent": 2.0}),)
    rubbing = {"coefficient": (("constant", {"value": 0.4}),), "regularization": 0.5}
    elastic = {"nodes": ["a", "b"], "law": law, "damping": 0.1}
    rough = {**elastic, "friction": rubbing}
    x, axis = rng.normal(size=3), np.array([0.0, 0.0, 1.0])
    nodes = [(x - [0.0, 0.1, 0.0], np.eye(3)), (x + [0.3, 0.4, 0.6], np.eye(3))]
    surfaces = (
        {"plane": {"normal": axis, "point": x}, "radius": 0.9}, {"sphere": {"radius": 0.5, "center": x}, "radius": 0.5},
        {"cylinder": {"axis": axis, "radius": 0.55, "inside": True, "center": x}, "radius": 0.25},
        {"capsule": {"axis": axis, "length": 0.4, "radius": 0.4, "center": x}, "radius": 0.4},
    )  # fmt: skip
    found = [({**surface, **rough}, nodes, "closed") for surface in surfaces]
    rigid = {"nodes": ["a", "b"], "radius": 0.04}
    found += [({**surface, **rigid}, nodes, phase) for surface in surfaces for phase in PHASES]
    found += [({**surfaces[2], **rigid, "friction": rubbing}, nodes, phase) for phase in PHASES]
    return [*found, ({**surfaces[2], **elastic}, nodes, "closed"), ({**surfaces[0], **rough}, nodes, "open")]


@kernel
def _gap(p, at):
    return touch(p, at).gap


GAP_SENSOR = quantity_sensor("contact_gap_sensor", "Sensor of the gap of a contact.", RECORD, ("x0", "R0", "x1"), _gap)
CONTACT = Kind(
    name="contact",
    section="elements",
    doc=__doc__,
    display=Display("contact", force="force", force_at="point"),
    dtype=RECORD,
    layout=("x0", "R0", "x1"),
    fields=(
        Field("nodes", NODE_PAIR, "-", "node a, which carries the surface, and node b, the centre of the ball"),
        *FIELDS,
        Field("law", CURVE, "N", "normal force, a curve of the depth [m], zero at zero; rigid when absent", None),
        Field("damping", NUMBER, "s/m", "c in the factor max(0, 1 + c dw/dt) on the law", 0.0, not_negative),
        friction_fields(),
        Field(
            "restitution", NUMBER, "-", "of a rigid contact: ratio of the speeds after and before a shock", 0.0, share
        ),
    ),
    outputs=(
        Output("gap", "m", "distance of ball and surface, negative where they overlap"),
        Output("normal_force", "N", "force of the surface on the ball along the normal"),
        Output("friction_force", "N", "magnitude of the friction"),
        Output("sliding_speed", "m/s", "speed of the ball along the surface at the contact; zero without friction"),
        Output("force", "N", "force of the surface on the ball, inertial", (3,)),
        Output("point", "m", "point of the ball nearest to the surface, inertial", (3,)),
        Output("closed", "-", "1 while they touch, 0 else"),
    ),
    multipliers=(NORMAL,),
    phases=PHASES,
    events=(Event("closes", "open", "closed", "the ball reaches the surface; a shock", SHOCK, "restitution"), OPENS),
    memory=("held",),
    prepare=prepare,
    variant=variant,
    check=check,
    residual=rigid_residual,
    constraints=rigid_constraints,
    observe=observe_rigid,
    event_values=rigid_events,
    commit=commit,
    sample=sample,
    measures={"gap": lambda d, nodes, context: Part(GAP_SENSOR, (0, 1), prepare(d, nodes, context))},
)
SMOOTH_CONTACT = replace(
    CONTACT, name="smooth_contact", multipliers=(), memory=(), commit=None, constraints=None, residual=smooth_residual,
    observe=observe_smooth, event_values=elastic_events,
    events=(Event("closes", "open", "closed", "the ball reaches the surface"), OPENS),
)  # fmt: skip
ROUGH_CONTACT = replace(
    SMOOTH_CONTACT, name="rough_contact", layout=("x0", "R0", "x1", "R1"), residual=rough_residual,
    observe=observe_rough,
)  # fmt: skip
RIGID_PART = Kind(
    name="rigid_contact_part", section="", doc="Constraint of a rigid contact with friction.", dtype=RECORD,
    layout=CONTACT.layout, multipliers=CONTACT.multipliers, phases=PHASES, memory=CONTACT.memory, commit=commit,
    residual=rigid_residual, constraints=rigid_constraints,
)  # fmt: skip
FRICTION_PART = Kind(
    name="contact_friction", section="", doc="Friction of a rigid contact.", dtype=RECORD,
    layout=ROUGH_CONTACT.layout, coupled_multipliers=(NORMAL,), residual=friction_residual,
)  # fmt: skip
RIGID_ROUGH_CONTACT = replace(
    CONTACT, name="rigid_rough_contact", layout=ROUGH_CONTACT.layout, multipliers=(), memory=(), commit=None,
    constraints=None, residual=None, parts=rigid_rough_parts, observe=observe_rigid_rough,
    event_values=rigid_rough_events,
)  # fmt: skip
