"""The wheel with radial deformation and slip: kinematics, tangents, power, limits."""

import numpy as np
import pytest
from scipy.optimize import minimize_scalar
from time_runs import RecordedRun, deck

from mecano.analyses.kind_samples import Instance
from mecano.element_interface import Context, Place
from mecano.elements.wheels.wheel import AIR, CONTACT, WHEEL
from mecano.laws.law_table import LawTable
from mecano.laws.probe import curve_at
from mecano.maths import so3, surface
from mecano.maths.vector import Vec3

RADIUS = 0.4
RADIAL = (("polynomial", {"coefficients": [0.0, 1e5, 1e6, -1e6, 1e6]}),)
FRICTION = (("exponential", {"start": 0.8, "limit": 0.3, "rate": 0.2, "origin": 0.0}),)
UP = np.array([0.0, 0.0, 1.0])
NONE = np.zeros(0)

SINE = (("sine", {"amplitude": 0.1, "frequency": 0.15, "phase": 0.4, "offset": 0.05}),)
BUMPS = [[-3.0, 0.1], [-2.0, 0.1], [-1.0, 0.17], [0.0, 0.12], [1.0, 0.2], [2.0, 0.15], [3.0, 0.15]]
TABLE = (("table", {"points": BUMPS, "interpolation": "cubic", "beyond": "hold"}),)
FLAT, SLOPE = UP, np.array([0.3, -0.2, 0.8])
GROUNDS = {"flat": (FLAT, None), "slope": (SLOPE, None), "sine": (SLOPE, SINE), "table": (FLAT, TABLE)}
OFFSET = {}
for _output in WHEEL.outputs:
    _start = sum(int(np.prod(shape)) for _, shape in OFFSET.values())
    OFFSET[_output.name] = (_start, _output.shape)
N_OUTPUTS = sum(int(np.prod(shape)) for _, shape in OFFSET.values())


def turn(psi):
    """Rotation matrix (3, 3) of a rotation vector."""
    return np.array(so3.exp(tuple(map(float, psi))))


def ground_of(normal, height=None, point=(0.2, -0.1, 0.3), direction=(1.0, 0.4, 0.1)):
    profile = None if height is None else {"direction": direction, "height": height}
    return {"plane": {"point": list(point), "normal": list(normal)}, "profile": profile}


def values_of(axis, ground, damping=0.0, eps=0.1, friction=FRICTION, radial=RADIAL):
    tire_law = {
        "radius": RADIUS, "radial": radial, "radial_damping": damping, "friction": friction,
        "friction_by_speed": 1.0, "slip_regularization": eps, "valid_deformation": None, "lateral": None,
    }  # fmt: skip
    return {"node": "axle", "axis": list(axis), "tire_law": tire_law, "ground": ground}


class Wheel:
    """One wheel whose compiled functions are called directly."""

    def __init__(self, values, x=(0.0, 0.0, 1.0), R=None):
        R = np.eye(3) if R is None else R
        table, self.kind = LawTable(), WHEEL.chosen(values)
        prepared = self.kind.prepare(values, [(np.array(x), R)], Context(table, np.zeros(3)))
        record = np.zeros(1, self.kind.dtype).view(np.recarray)
        for name, value in prepared.items():
            record[name][0] = value
        self.record, self.p, self.laws = record, record[0], table.array()

    def at(self, phase):
        """The Instance in a phase."""
        return Instance(self.kind, self.record, (0,), phase, NONE, self.laws, np.zeros((3, 0)), NONE)

    def force(self, x, R, v, phase=CONTACT):
        """f (6,), K, C, M (6, 6)."""
        return self.at(phase).force(0.0, (np.r_[x, 0.0, 0.0, 0.0], v, np.zeros(6), R[None]))

    def residual(self, x, R, v, phase=CONTACT):
        """f (6,) alone, which takes a tenth of the time."""
        return self.at(phase).residual(0.0, (np.r_[x, 0.0, 0.0, 0.0], v, np.zeros(6), R[None]))

    def observe(self, x, R, v, phase=CONTACT):
        """Outputs by name, energies (4,)."""
        y, e = np.zeros(N_OUTPUTS), np.zeros(4)
        state = (np.r_[x, 0.0, 0.0, 0.0], v, np.zeros(6), R[None])
        self.kind.observe(self.p, Place(0.0, phase, 1.0, 1.0, self.laws, NONE, *state), np.zeros(6), y, e)
        return {name: y[i : i + 3] if shape else y[i] for name, (i, shape) in OFFSET.items()}, e

    def deformation(self, x, R):
        """Value w of the touch-down, signed [m]."""
        g = np.zeros(2)
        state = (np.r_[x, 0.0, 0.0, 0.0], np.zeros(6), np.zeros(6), R[None])
        WHEEL.event_values(self.p, Place(0.0, AIR, 1.0, 1.0, self.laws, NONE, *state), g)
        assert g[1] == -g[0]
        return g[0]


def random_state(rng, name, speed=3.0, **options):
    """A wheel that leans and yaws, deformed by some centimetres on the ground ``name``: (Wheel, x, R, v)."""
    normal, height = GROUNDS[name]
    normal = normal / np.linalg.norm(normal)
    ground = ground_of(normal, height)
    level = np.cross(normal, rng.normal(size=3))
    level /= np.linalg.norm(level)
    lean = rng.uniform(-1.0, 1.0)
    R0, R = turn(rng.normal(size=3)), turn(rng.normal(size=3))
    axis_now = np.cos(lean) * level + np.sin(lean) * normal
    wheel = Wheel(values_of(R0 @ R.T @ axis_now, ground, **options), R=R0)
    x = np.array(ground["plane"]["point"]) + rng.uniform(-2, 2) * np.cross(level, normal)
    for _ in range(30):  # to the wanted deformation, along the normal
        x = x + (wheel.deformation(x, R) - rng.uniform(0.02, 0.06)) * normal
    return wheel, x, R, np.r_[speed, speed, speed, 1.0, 1.0, 1.0] * rng.normal(size=6)


def test_no_force_in_the_air():
    wheel, x, R, v = random_state(np.random.default_rng(3), "sine")
    assert not any(array.any() for array in wheel.force(x, R, v, AIR))
    y, e = wheel.observe(x, R, v, AIR)
    assert y["loaded_radius"] == RADIUS and y["deformation"] == 0.0 and not e.any()
    assert not y["contact_force"].any() and y["normal_force"] == y["friction_coefficient"] == 0.0


@pytest.mark.parametrize("name", GROUNDS)
def test_power_identity(name):
    """G_int . qdot = F_fr . v_C + F_r dw/dt (theory: (36), (31)), dw/dt from differences of the geometry."""
    rng = np.random.default_rng(4)
    for _ in range(6):
        wheel, x, R, v = random_state(rng, name, damping=0.1)
        f = wheel.residual(x, R, v)
        h = 1e-5
        ahead = wheel.deformation(x + h * v[:3], R @ turn(h * v[3:]))
        back = wheel.deformation(x - h * v[:3], R @ turn(-h * v[3:]))
        w1 = (ahead - back) / (2 * h)
        y, e = wheel.observe(x, R, v)
        friction = -y["longitudinal_force"] * y["longitudinal_slip"] - y["lateral_force"] * y["lateral_slip"]
        assert f @ v == pytest.approx(friction + y["radial_force"] * w1, rel=1e-7)
        # the same power: stored, and dissipated
        dU = curve_at(RADIAL, y["deformation"])[0] * w1
        assert f @ v == pytest.approx(e[2] + dU, rel=1e-7)


def test_dissipation_is_never_negative():
    rng = np.random.default_rng(6)
    released = 0
    for i in range(80):
        name = list(GROUNDS)[i % 4]
        wheel, x, R, v = random_state(rng, name, speed=10.0, damping=0.5, eps=rng.uniform(0.05, 50.0))
        y, e = wheel.observe(x, R, v)
        released += y["radial_force"] == 0.0
        assert e[2] >= 0.0 and y["radial_force"] >= 0.0 and y["normal_force"] >= 0.0
        assert 0.0 <= y["friction_coefficient"] <= 0.8
    assert 5 < released < 60  # rebounds faster than the tyre follows are among the states


def test_upright_wheel_has_the_vector_of_the_paper():
    """(36) of Cardona, Geradin and Doan 1991 with c = -n: force F_fr - F_r n, moment R^T(-r n x F_fr)."""
    wheel = Wheel(values_of([0.0, 1.0, 0.0], ground_of(UP, point=(0, 0, 0)), eps=0.1))
    x, v = np.array([0.7, 0.2, 0.37]), np.array([12.0, 0.5, -0.3, 0.2, 20.0, 0.1])
    R = turn([0.0, 1.2, 0.0])
    omega = R @ v[3:]
    slip = v[:3] + np.cross(omega, [0.0, 0.0, -0.37])
    slip[2] = 0.0
    speed = np.linalg.norm(slip)
    radial = 1e5 * 0.03 + 1e6 * 0.03**2 - 1e6 * 0.03**3 + 1e6 * 0.03**4
    friction = (0.3 + 0.5 * np.exp(-0.2 * speed)) * radial * slip / speed
    expected = np.r_[friction - radial * UP, R.T @ np.cross(-0.37 * UP, friction)]
    assert np.allclose(wheel.residual(x, R, v), expected, rtol=1e-12, atol=1e-9)
    y, _ = wheel.observe(x, R, v)
    assert y["height"] == pytest.approx(0.37) and y["deformation"] == pytest.approx(0.03)
    assert np.allclose(y["contact_force"], radial * UP - friction)
    assert np.allclose(y["contact_point"], [0.7, 0.2, 0.0])
    # a turns to +y, t = a x n to +x: forward; l = n x t to +y
    assert y["longitudinal_slip"] == pytest.approx(slip[0]) and y["lateral_slip"] == pytest.approx(slip[1])
    assert y["longitudinal_force"] == pytest.approx(-friction[0]) and y["spin_rate"] == pytest.approx(omega[1])


def test_rolling_wheel_does_not_slip():
    wheel = Wheel(values_of([0.0, 1.0, 0.0], ground_of(UP, point=(0, 0, 0))))
    y, e = wheel.observe(np.array([0.0, 0.0, 0.37]), np.eye(3), np.array([3.7, 0, 0, 0, 10.0, 0]))
    assert abs(y["longitudinal_slip"]) < 1e-12 and e[2] < 1e-12


def test_leaning_wheel_is_tipped_by_the_normal_force():
    """Frictionless, leaning by a small angle s: the moment about t is N r s in the direction of the fall."""
    s = 1e-3
    wheel = Wheel(values_of([0.0, 1.0, 0.0], ground_of(UP, point=(0, 0, 0)), friction=0.0))
    R, x = turn([s, 0.0, 0.0]), np.array([0.0, 0.0, 0.37])
    f = wheel.residual(x, R, np.zeros(6))
    y, _ = wheel.observe(x, R, np.zeros(6))
    assert -(R @ f[3:])[0] == pytest.approx(y["normal_force"] * 0.37 * s, rel=1e-5)
    assert y["normal_force"] == pytest.approx(y["radial_force"] / np.cos(s), rel=1e-12)


@pytest.mark.parametrize("name", ["sine", "table"])
def test_contact_is_the_nearest_point_of_the_ground_in_the_plane_of_the_wheel(name):
    rng = np.random.default_rng(7)
    for _ in range(5):
        wheel, x, R, v = random_state(rng, name)
        y, _ = wheel.observe(x, R, v)
        origin, n0, d = wheel.p["point"], wheel.p["normal"], wheel.p["direction"]
        axis, across = R @ wheel.p["axis"], np.cross(n0, d)

        def point(sigma, origin=origin, n0=n0, d=d, axis=axis, across=across, x=x, name=name):
            above = origin + sigma * d + curve_at(GROUNDS[name][1], sigma)[0] * n0
            return above + axis @ (x - above) / (axis @ across) * across

        centre = d @ (x - origin)
        best = minimize_scalar(
            lambda s, point=point, x=x: np.linalg.norm(point(s) - x),
            bounds=(centre - 0.3, centre + 0.3), method="bounded", options={"xatol": 1e-9},
        )  # fmt: skip
        assert y["loaded_radius"] == pytest.approx(best.fun, rel=1e-12)
        assert np.allclose(y["contact_point"], point(best.x), atol=1e-6)


def test_the_slope_of_newtons_iteration_is_exact():
    rng = np.random.default_rng(10)
    n0, d, a, h = Vec3(0.0, 0.0, 1.0), Vec3(1.0, 0.0, 0.0), Vec3(*turn(rng.normal(size=3))[1]), 1e-6

    def residual(delta):
        H, H1, H2 = curve_at(SINE, 0.7 + delta)
        return surface.foot_residual(None, n0, d, a, 0.5, delta, H, H1, H2)

    for delta in rng.uniform(-0.3, 0.3, size=5):
        difference = (residual(delta + h)[0] - residual(delta - h)[0]) / (2 * h)
        assert residual(delta)[1] == pytest.approx(difference, rel=1e-7)


def test_friction_at_vanishing_slip_is_viscous():
    """F_fr -> 2 mu(0) N v_C/eps, finite at rest (theory: (34))."""
    eps = 0.1
    wheel = Wheel(values_of([0.0, 1.0, 0.0], ground_of(UP, point=(0, 0, 0)), eps=eps))
    x, v = np.array([0.0, 0.0, 0.37]), np.array([1e-9, 2e-9, 0.0, 0.0, 0.0, 0.0])
    f, K, C, _ = wheel.force(x, np.eye(3), v)
    normal = -f[2]
    assert np.allclose(f[:2], 2 * 0.8 * normal * v[:2] / eps, rtol=1e-6, atol=0)
    f, K, C, _ = wheel.force(x, np.eye(3), np.zeros(6))
    assert np.array_equal(f[:2], [0.0, 0.0]) and np.isfinite(K).all()
    assert np.allclose(np.diag(C)[:2], 2 * 0.8 * normal / eps)


def test_friction_is_smooth_at_the_regularization_speed():
    wheel = Wheel(values_of([0.0, 1.0, 0.0], ground_of(UP, point=(0, 0, 0)), eps=0.1))
    x, d = np.array([0.0, 0.0, 0.37]), 1e-9
    below, above = (wheel.force(x, np.eye(3), np.array([0.1 + s * d, 0, 0, 0, 0, 0])) for s in (-1.0, 1.0))
    assert np.allclose(below[0], above[0], rtol=1e-6) and np.allclose(below[2], above[2], rtol=0, atol=1e-3)


def test_never_adhesive():
    wheel = Wheel(values_of([0.0, 1.0, 0.0], ground_of(UP, point=(0, 0, 0)), damping=0.5))
    x, rebound = np.array([0.0, 0.0, 0.37]), np.array([1.0, 0.0, 5.0, 0.0, 0.0, 0.0])
    assert not wheel.residual(x, np.eye(3), rebound).any()  # the ground lets go faster than 1/c
    y, e = wheel.observe(x, np.eye(3), rebound)
    assert y["normal_force"] == 0.0
    assert e[2] == pytest.approx(5.0 * curve_at(RADIAL, 0.03)[0])  # what was stored is lost
    y, e = wheel.observe(np.array([0.0, 0.0, RADIUS + 1e-9]), np.eye(3), np.array([1.0, 0, 0.1, 0, 0, 0]))
    assert y["normal_force"] == y["deformation"] == e[1] == e[2] == 0.0 and not y["contact_force"].any()


def test_events_follow_the_deformation():
    wheel = Wheel(values_of([0.0, 1.0, 0.0], ground_of(UP, point=(0, 0, 0))))
    assert wheel.deformation(np.array([0, 0, 0.38]), np.eye(3)) == pytest.approx(0.02)
    assert wheel.deformation(np.array([0, 0, 0.45]), np.eye(3)) == pytest.approx(-0.05)
    assert [(event.name, event.before, event.after) for event in WHEEL.events] == [
        ("touch_down", "air", "contact"), ("lift_off", "contact", "air"),
    ]  # fmt: skip


def test_far_above_a_narrow_hollow_the_clearance_is_finite_and_no_contact():
    narrow = (("sine", {"amplitude": 0.1, "frequency": 0.5, "phase": 0.0, "offset": 0.0}),)
    wheel = Wheel(values_of([0.0, 1.0, 0.0], ground_of(UP, narrow, (0, 0, 0), (1, 0, 0))))
    for height in (0.6, 1.0, 3.0, 30.0):
        for along in np.linspace(0.0, 2.0, 21):
            assert -height - 0.1 < wheel.deformation(np.array([along, 0.0, height]), np.eye(3)) < 0.0


def test_a_wheel_that_lies_flat_stays_finite():
    wheel = Wheel(values_of([0.0, 0.0, 1.0], ground_of(UP, SINE)))
    for psi in ([0.0, 0.0, 0.0], [1e-12, 0.0, 0.0], [1e-4, 1e-4, 0.0]):
        arrays = wheel.force(np.array([0.0, 0.0, 0.7]), turn(psi), np.ones(6))
        y, e = wheel.observe(np.array([0.0, 0.0, 0.7]), turn(psi), np.ones(6))
        assert all(np.isfinite(a).all() for a in arrays) and np.isfinite(e).all()
        assert all(np.isfinite(value).all() for value in y.values())


def changed(values, part, **new):
    return {**values, part: {**values[part], **new}}


def test_check_reports_invalid_wheels():
    good, node = values_of([0.0, 1.0, 0.0], ground_of(UP, SINE)), [(np.array([0.0, 0.0, 1.0]), np.eye(3))]
    corner = (("table", {"points": [[0, 0], [1, 0.1], [2, 0]], "interpolation": "linear", "beyond": "hold"}),)
    stepped = (("step", {"time": 0.0, "rise": 1.0, "from": 0.0, "to": 0.1}),)
    preload = (("polynomial", {"coefficients": [50.0, 1e5]}),)
    low = [(np.array([0.0, 0.0, -0.5]), np.eye(3))]
    assert WHEEL.check(good, node) == []
    assert WHEEL.check({**good, "ground": ground_of(UP, stepped)}, node) == []
    cases = (
        ({**good, "axis": [0.01, 0.0, 1.0]}, node, "lies flat"),
        ({**good, "ground": ground_of(UP)}, low, "0.8 m below the ground"),
        ({**good, "ground": ground_of(UP, corner)}, node, "corner at 0 m"),
        ({**good, "ground": ground_of(UP, SINE, direction=(0, 0, 2))}, node, "along the normal"),
        (changed(good, "tire_law", radial=preload), node, "it is 50 N"),
        (changed(good, "tire_law", radial=-1e5), node, "must be zero at zero"),
        (changed(good, "tire_law", friction=-0.1), node, "friction' must not be negative"),
    )
    for values, nodes, text in cases:
        assert any(text in line for line in WHEEL.check(values, nodes)), text


LATERAL = (
    ", friction: 0.8, slip_regularization: 0.1, "
    "lateral: {relaxation: {cornering_stiffness: 5.0e4, relaxation_length: 0.3}}"
)
FIALA = ", fiala: {cornering_stiffness: 5.0e4, friction: 0.8, contact_length: 0.1, carcass_stiffness: [1.0e5, 1.0e5]}"


@pytest.mark.parametrize(
    ("kind", "more"),
    [("wheel", ", friction: 0.8, slip_regularization: 0.1"), ("flexible_wheel", LATERAL), ("transient_wheel", FIALA)],
)
def test_the_slip_in_the_air_is_that_of_the_lowest_point_of_the_rim(kind, more):
    m = RecordedRun(
        deck(f"""
        mecano: 1
        gravity: none
        nodes: {{hub: {{position: [0, 0, 1.7]}}}}
        elements:
          rim: {{type: rigid_body, node: hub, mass: 10, inertia: [1, 2, 1]}}
          tyre: {{type: {kind}, node: hub, axis: [0, 1, 0], tire_law: law, ground: road}}
        tire_laws: {{law: {{radius: 0.4, radial: {{linear: {{slope: 1.0e5}}}}{more}}}}}
        grounds: {{road: {{plane: {{point: [0, 0, 0], normal: [0, 0, 1]}}}}}}
        initial: {{velocities: [{{nodes: all, velocity: [30, 2, 0], angular_velocity: [0, 50, 0], about: own}}]}}
        time: {{end: 0.01, step: 1 ms}}
        """)
    )
    assert m["elements/tyre/longitudinal_slip"] == pytest.approx(30 - 50 * 0.4, rel=1e-12)
    assert abs(m["elements/tyre/lateral_slip"]) == pytest.approx(2.0, rel=1e-12)
