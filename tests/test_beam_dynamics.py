"""Moving beams: decks of inputs/ and published examples against independent answers."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import eigh
from time_runs import RecordedRun, deck, input_deck

from mecano.analyses.modal import modes

THREADS = {  # flexible_pendulum without the shear and the rotary inertia of its section
    "type": "stiffness", "EA": 7853.981633974483, "GA2": 2.7e6, "GA3": 2.7e6, "GJ": 0.0377610413,
    "EI2": 0.04908738521234052, "EI3": 0.04908738521234052, "mass_per_length": 0.08639379797371933,
    "rotary_inertia": "[1e-9, 5e-10, 5e-10]",
}  # fmt: skip


def test_flexible_pendulum():
    """Tip at 1 s: 64 ANCF cable elements of Exudyn 1.9, step 2.5e-4 s, without shear and rotary inertia."""
    section = "{" + ", ".join(f"{key}: {value}" for key, value in THREADS.items()) + "}"
    recorded = RecordedRun(
        input_deck("flexible_pendulum", f"sections.rubber={section}", "elements.rod.mesh=12", "time.step=5e-4")
    )
    np.testing.assert_allclose(recorded["nodes/tip/position"][-1], [-0.999461, 0.0, 0.007782], rtol=0, atol=5e-5)
    recorded = RecordedRun(input_deck("flexible_pendulum"))
    np.testing.assert_allclose(recorded["nodes/tip/position"][-1], [-0.999448, 0.0, 0.007979], rtol=0, atol=5e-5)
    energy = recorded["energy/balance"]
    assert np.abs(energy - energy[0]).max() < 2e-5 * recorded["energy/kinetic"].max()


def test_a_spring_released_suddenly_does_not_cut_long_steps():
    """A stiff, light rod snaps towards its natural angle: nearly I p'' + c p' + k p = k p_0, as a rigid one.

    At the start its first node alone accelerates, 1e5 rad/s2: a prediction from that is of no use over 5 ms.
    """
    k, c, goal = 2.0, 0.5, 1.45
    recorded = RecordedRun(
        deck(f"""
        mecano: 1
        gravity: [0, 0, 0]
        sections: {{tube: {{type: tube, diameter: 0.03, thickness: 1.5e-3, E: 7e10, nu: 0.33, density: 1600}}}}
        nodes: {{a: {{position: [0, 0, 0]}}, b: {{position: [1, 0, 0]}}}}
        elements: {{rod: {{type: beam, nodes: [a, b], section: tube, mesh: 4}}}}
        joints:
          hinge: {{type: hinge, nodes: [ground, a], axis: [0, 1, 0], natural_angle: {goal},
                  turning_law: {{spring: {{stiffness: {k}}}, damper: {{coefficient: {c}}}}}}}
        time: {{end: 0.5, step: 5e-3, rho_inf: 0.6}}
    """)
    )
    assert recorded.run.steps == 100 and recorded.run.rejected == 0
    inertia = 1600 * np.pi * (0.015**2 - 0.0135**2) / 3
    p, q = np.roots([inertia, c, k])

    def angle(t):
        return goal * (1.0 + (q * np.exp(p * t) - p * np.exp(q * t)) / (p - q)).real

    late = recorded.time - 5e-3  # the filter of the first step costs up to a step
    found = recorded["joints/hinge/angle"]
    rising = (recorded.time > 0.05) & (recorded.time < 0.35)
    assert np.all((found > angle(late))[rising]) and np.all((found < angle(recorded.time + 5e-4))[rising])


class SpinUp:
    """The arm of beam_spin_up as a small vibration in the turning frame, stiffened by the centrifugal force.

    EI w'''' + m w_tt - (P w')' - m p_t^2 w = -m p_tt x with P = m p_t^2 (L^2 - x^2)/2, in three modes of
    the arm at rest, themselves in powers x^2 ... x^9.
    """

    EI, m, L = 1.4e4, 1.2, 10.0
    c, f = 0.4 * (7.5 / np.pi) ** 2, 2.0 * np.pi / 15.0

    def __init__(self, n=8, modes=3):
        points, weights = np.polynomial.legendre.leggauss(20)
        s, weights = 0.5 * (points + 1.0), 0.5 * weights * self.L
        k = np.arange(2, 2 + n)[:, None]
        w, slope, bend = s**k, k * s ** (k - 1) / self.L, k * (k - 1) * s ** (k - 2) / self.L**2
        tension = 0.5 * (1.0 - s**2) * self.L**2
        stiffness, shapes = eigh(self.EI * (bend * weights) @ bend.T, self.m * (w * weights) @ w.T)
        self.squares, shapes = stiffness[:modes], shapes[:, :modes].T
        self.tension = self.m * shapes @ (slope * weights * tension) @ slope.T @ shapes.T
        self.drive = -self.m * shapes @ (w * weights) @ (s * self.L)
        self.at_tip = shapes.sum(axis=1)

    def rate(self, t):
        """Angular velocity and acceleration [rad/s, rad/s2]."""
        return 0.4 * t - self.c * self.f * np.sin(self.f * t), 0.4 - self.c * self.f**2 * np.cos(self.f * t)

    def tip(self, times):
        """Deflection of the tip [m]."""
        n = len(self.drive)

        def change(t, y):
            w, a = self.rate(t)
            K = np.diag(self.squares) + w**2 * (self.tension - np.eye(n))
            return np.concatenate([y[n:], a * self.drive - K @ y[:n]])

        found = solve_ivp(change, (0, times[-1]), np.zeros(2 * n), rtol=1e-7, atol=1e-9, t_eval=times)
        return self.at_tip @ found.y[:n]


def test_spin_up():
    """Lag of the tip within 1.5 % of the largest of the linear theory; stretched at full speed (closed form)."""
    recorded = RecordedRun(input_deck("beam_spin_up"))
    t, (x, y, _) = recorded.time, recorded["nodes/tip/position"].T
    angle = 0.2 * t**2 + SpinUp.c * (np.cos(SpinUp.f * t) - 1.0)
    deflection, elongation = y * np.cos(angle) - x * np.sin(angle), x * np.cos(angle) + y * np.sin(angle) - 10.0
    expected = SpinUp().tip(t)
    assert deflection.min() == pytest.approx(-0.574, abs=0.002)
    np.testing.assert_allclose(deflection, expected, rtol=0, atol=0.015 * np.abs(expected).max())
    assert elongation[-1] == pytest.approx(1.2 * 36.0 * 1000.0 / (3 * 2.8e7), rel=2e-3)


class Rod:
    """The rod of flexible_slider_crank as sine waves between ends that move as those of the rigid mechanism.

    m w_tt + EI w'''' - (P w')' - m a_t^2 w = -m (transverse acceleration of the straight rod).
    """

    r, L, w, slider = 0.15, 0.3, 150.0, 0.033377
    m, EI = 7870 * np.pi * 0.003**2, 2e11 * np.pi * 0.006**4 / 64

    def __init__(self, n=4):
        self.k = np.arange(1, n + 1) * np.pi / self.L
        points, weights = np.polynomial.legendre.leggauss(40)
        self.x, self.weights = 0.5 * (points + 1) * self.L, 0.5 * weights * self.L
        self.waves, self.slopes = np.sin(np.outer(self.k, self.x)), self.k[:, None] * np.cos(np.outer(self.k, self.x))

    def kinematics(self, t):
        """Of the straight rod: angle, its rates, accelerations of the big end along and across it, of the slider."""
        s = self.r / self.L * np.sin(self.w * t)
        b = -np.arcsin(s)
        b1 = -self.r / self.L * self.w * np.cos(self.w * t) / np.cos(b)
        b2 = (self.r / self.L * self.w**2 * np.sin(self.w * t) + b1**2 * np.sin(b)) / np.cos(b)
        a = -self.r * self.w**2 * np.array([np.cos(self.w * t), np.sin(self.w * t)])
        along, across = np.array([np.cos(b), np.sin(b)]), np.array([-np.sin(b), np.cos(b)])
        end = a + self.L * (b2 * across - b1**2 * along)
        return b, b1, b2, a @ along, a @ across, end[0]

    def middle(self, times):
        """Deflection of the middle [m], positive to the left of the line from big end to slider."""
        n = len(self.k)

        def change(t, y):
            b, b1, b2, a_along, a_across, a_slider = self.kinematics(t)
            acceleration = a_across + b2 * self.x
            beyond = self.m * (a_along * (self.L - self.x) - 0.5 * b1**2 * (self.L**2 - self.x**2))
            moment = self.m * (a_across * self.L**2 / 2 + b2 * self.L**3 / 3) / self.L  # about the big end
            guide = (moment - self.slider * a_slider * np.sin(b)) / np.cos(b)
            P = -(beyond + self.slider * a_slider * np.cos(b) - guide * np.sin(b))
            K = (self.slopes * self.weights * P) @ self.slopes.T * 2 / (self.m * self.L)
            load = self.waves @ (self.weights * acceleration) * 2 / self.L
            w = y[:n]
            return np.concatenate([y[n:], -load - (self.EI / self.m * self.k**4 - b1**2) * w - K @ w])

        found = solve_ivp(change, (0, times[-1]), np.zeros(2 * n), rtol=1e-8, atol=1e-11, t_eval=times)
        return np.sin(self.k * self.L / 2) @ found.y[:n]


def test_slider_crank():
    """Middle of the rod, in the first two turns; the difference grows with the phase of the first mode."""
    recorded = RecordedRun(input_deck("flexible_slider_crank", "time.step=4e-5"))
    middle, a, b = (recorded[f"nodes/{name}/position"][:, [0, 2]] for name in ("rod.4", "big_end", "small_end"))
    line = (b - a) / np.linalg.norm(b - a, axis=1)[:, None]
    across = np.stack([-line[:, 1], line[:, 0]], axis=1)
    deflection = np.sum((middle - 0.5 * (a + b)) * across, axis=1)
    expected = Rod().middle(recorded.time)
    early = recorded.time < 0.03
    np.testing.assert_allclose(deflection[early], expected[early], rtol=0, atol=0.03 * np.abs(expected).max())
    assert np.abs(deflection).max() == pytest.approx(0.00466, abs=5e-5)


def breathing(times):
    """Radius [m] of the ring of flexible_ring, an exact motion with one degree of freedom."""
    area, i2 = np.pi * 0.1**2 / 4.0, 0.1**2 / 16.0
    m, EA = 1000.0 * area, 1e7 * area
    H = 10.0 * m * (1.0 + i2)

    def change(t, y):
        return [y[1], (H / m) ** 2 * y[0] / (y[0] ** 2 + i2) ** 2 - EA * (y[0] - 1.0) / m]

    return solve_ivp(change, (0, times[-1]), [1.0, 0.0], rtol=1e-10, atol=1e-12, t_eval=times).y[0]


def ring(mesh, *overrides):
    """Run flexible_ring with so many elements in a quarter."""
    quarters = (f"elements.{name}.mesh={mesh}" for name in ("first", "second", "third", "fourth"))
    return RecordedRun(input_deck("flexible_ring", *quarters, *overrides))


def test_ring():
    """Radius against the exact breathing of 19 mm; energy error falls fourfold with half the step."""
    errors, energies = [], []
    for step in (5e-4, 2.5e-4):
        recorded = ring(24, f"time.step={step}", "time.end=0.2")
        radius = np.linalg.norm(recorded["nodes/first.12/position"], axis=1)
        np.testing.assert_allclose(radius, np.linalg.norm(recorded["nodes/west/position"], axis=1), rtol=0, atol=1e-7)
        errors.append(np.abs(radius - breathing(recorded.time)).max())
        energy = recorded["energy/balance"]
        energies.append(np.abs(energy - energy[0]).max())
    assert errors[1] < 1e-4
    assert energies[0] / energies[1] == pytest.approx(4.0, abs=0.02)


@pytest.mark.slow
def test_ring_over_100_turns():
    """The ring turns and bends, the oval mode set going: energy error at h and h/2 without numerical damping."""
    drift = []
    for step in (1e-3, 5e-4):
        recorded = oval_ring(step, end=62.9)
        energy = recorded["energy/balance"]
        drift.append(np.abs(energy - energy[0]).max())
        turned = np.unwrap(np.arctan2(*recorded["nodes/east/position"].T[[1, 0]]))[-1]
        assert turned > 100 * 2 * np.pi * 0.97
    assert drift[0] / drift[1] == pytest.approx(4.0, abs=0.5)


def oval_ring(step, end):
    """Four elements in a quarter; the nodes swing by v = 0.5 m/s (x, -y)/r besides."""

    def set_going(integrator, run):
        system, s = integrator.system, run.motion.copy()
        for i, node in enumerate(system.nodes):
            x = system.numbering.x[i]
            s.v[x : x + 2] += 0.5 * node.x[:2] * [1, -1]
        return integrator.begin(s, step)

    quarters = (f"elements.{name}.mesh=4" for name in ("first", "second", "third", "fourth"))
    return RecordedRun(
        input_deck("flexible_ring", *quarters, f"time.step={step}", f"time.end={end}", "time.rho_inf=1"),
        change=set_going,
    )


SPAGHETTI = {  # reference e2c: x1, y1, x2, y2 of the ends and the energy; twelve cubic elements, three per span
    1.25: (7.048325071325772, 1.041203071203035, 0.03384048624568741, 7.834832764070934, 48.53348943077292),
    2.5: (9.186087131217691, 4.418736953777211, -0.6432718453860622, 4.6276226231677375, 89.36474990050836),
    4.0: (8.732797905831017, 7.914737545954473, 3.735211862384658, -0.5149188356755916, 89.36474990051269),
    6.0: (4.2365819940577785, 7.509531813446165, 11.842066100694145, 1.230520573188391, 89.36474990051454),
    10.0: (13.639556820590572, -0.48572723839851345, 8.598136780066554, 7.759949255978887, 89.3647499005133),
}


def spaghetti(n, step, end):
    """The flying beam of Simo & Vu-Quoc (1986) under smooth loads, in the x-y plane."""
    t = np.linspace(0.0, 2.5, 101)
    rise = [[float(a), float(b)] for a, b in zip(t, np.sin(np.pi * t / 2.5) ** 2, strict=True)]
    points = {scale: [[a, scale * b] for a, b in rise] for scale in (8.0, 80.0)}
    return deck(f"""
        mecano: 1
        gravity: [0, 0, 0]
        sections:
          soft: {{type: stiffness, EA: 1e4, GA2: 1e4, GA3: 1e4, GJ: 500, EI2: 500, EI3: 500, mass_per_length: 1,
                  rotary_inertia: [10, 10, 10]}}
        nodes: {{a: {{position: [6, 0, 0]}}, b: {{position: [0, 8, 0]}}}}
        elements: {{rod: {{type: beam, nodes: [a, b], section: soft, up: [0, 0, 1], mesh: {n}}}}}
        loads:
          push: {{type: force, node: a, direction: [1, 0, 0], value: {{table: {{points: {points[8.0]}}}}}}}
          turn: {{type: moment, node: a, direction: [0, 0, 1], value: {{table: {{points: {points[80.0]}}}}}}}
        time: {{end: {end}, step: {step}, rho_inf: 0.95}}
    """)


def spaghetti_errors(n, step, end):
    """Largest error of the ends [m] at each time of the reference, and of the energy, relative."""
    recorded, errors = RecordedRun(spaghetti(n, step, end)), {}
    for time, (x1, y1, x2, y2, energy) in SPAGHETTI.items():
        if time <= end:
            i = int(np.argmin(np.abs(recorded.time - time)))
            a, b = recorded["nodes/a/position"][i, :2], recorded["nodes/b/position"][i, :2]
            off = np.abs([*(a - [x1, y1]), *(b - [x2, y2])]).max()
            errors[time] = float(off), float(abs(recorded["energy/total"][i] / energy - 1.0))
    return errors


def test_spaghetti():
    errors = spaghetti_errors(8, 0.01, 4.0)
    assert max(off for off, _ in errors.values()) < 5e-3 and max(energy for _, energy in errors.values()) < 1e-2


@pytest.mark.slow
def test_spaghetti_to_the_accuracy_of_the_reference():
    """Order two in the number of elements (rotary inertia is large); references of 8 and 12 elements differ by 8e-5."""
    coarse, fine = spaghetti_errors(48, 1e-3, 10.0), spaghetti_errors(96, 5e-4, 10.0)
    for time, (off, energy) in fine.items():
        assert off < 1.5e-4 and energy < 1e-4
        assert coarse[time][0] / off == pytest.approx(4.0, abs=1.0)


@pytest.mark.parametrize("mesh", [1, 3])
def test_a_disc_on_a_shaft_without_mass(mesh):
    """Overhung by 0.4 m: the flexibility of a cantilever with shear, mass and inertia of the disc; then its drop."""
    L, EI, GA, mass, inertia = 0.4, 2e3, 1e6, 8.0, 0.06
    text = f"""
        mecano: 1
        gravity: [0, 0, -9.81]
        sections:
          shaft: {{type: stiffness, EA: 1.0e8, GA2: {GA}, GA3: {GA}, GJ: 1600, EI2: {EI}, EI3: {EI}, mass_per_length: 0,
                   rotary_inertia: [0, 0, 0]}}
        nodes: {{root: {{position: [0, 0, 0]}}, disc: {{position: [{L}, 0, 0]}}}}
        elements:
          shaft: {{type: beam, nodes: [root, disc], section: shaft, up: [0, 0, 1], mesh: {mesh}}}
          disc: {{type: rigid_body, node: disc, mass: {mass}, inertia: [0.1, {inertia}, {inertia}]}}
        joints: {{clamp: {{type: fixed, nodes: [ground, root]}}}}
        time: {{end: 0.05, step: 0.1 ms, method: radau, adaptive: {{tolerance: 1.0e-6}}}}
    """
    flexibility = np.array([[L**3 / 3, L**2 / 2], [L**2 / 2, L]]) / EI + np.diag([L / GA, 0.0])
    squares, shapes = eigh(np.linalg.inv(flexibility), np.diag([mass, inertia]))
    found = modes(deck(text), None, number=5)[1].values.imag
    wanted = np.sqrt([squares[0], squares[0], 1600 / (L * 0.1), squares[1], squares[1]])  # the third one is torsion
    np.testing.assert_allclose(np.sort(found), wanted, rtol=1e-9)
    recorded = RecordedRun(deck(text))
    sag = flexibility @ [-mass * 9.81, 0.0]
    parts = shapes[0] * (shapes.T @ np.diag([mass, inertia]) @ sag)
    wanted = sag[0] - np.cos(np.outer(recorded.time, np.sqrt(squares))) @ parts
    np.testing.assert_allclose(recorded["nodes/disc/position"][:, 2], wanted, atol=1e-6)
