"""Cables against the literature: impacts on long cables, a swinging Atwood machine, an elastic catenary, a pole."""

import math

import numpy as np
import pytest
from equilibria import Path
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, fsolve
from time_runs import RecordedRun, deck

g = 9.81
EA, MASS, PIECES = 1.0e6, 1.0, 100  # [N], [kg/m], pieces of a cable of 1 m
WAVE = math.sqrt(EA / MASS)  # [m/s], of longitudinal waves
SPEED, END = 100.0, 8.0e-4  # [m/s] of a heavy hammer, [s]


def chain(points, more):
    """Return lines of nodes and of cables between them; ``more``: further fields of each cable, by its number."""
    nodes = [f"n{i}: {{position: [{x:.15g}, 0, {z:.15g}]{end}}}" for i, (x, z, end) in enumerate(points)]
    cables = [f"c{i}: {{type: cable, nodes: [n{i}, n{i + 1}], {more}}}" for i in range(len(points) - 1)]
    return "\n  ".join(nodes), "\n  ".join(cables)


def hit(direction):
    """Return the run of a cable along x without tension, whose first node moves at SPEED, and its last strains."""
    points = [(i / PIECES, 0.0, ", fixed: true" if i == PIECES else "") for i in range(PIECES + 1)]
    more = f"axial_stiffness: {EA}, mass_per_length: {MASS}, mass_distribution: lumped, damping: {0.5 / PIECES / WAVE}"
    nodes, cables = chain(points, more)
    velocity = [SPEED * d for d in direction]
    recorded = RecordedRun(deck(
        f"mecano: 1\ngravity: none\nnodes:\n  {nodes}\nelements:\n  {cables}\n"
        f"  hammer: {{type: point_mass, node: n0, mass: 1.0e7}}\n"
        f"initial: {{velocities: [{{nodes: [n0], velocity: {velocity}}}]}}\n"
        f"time: {{end: {END}, step: {0.4 / PIECES / WAVE}}}\n"
    ))  # fmt: skip
    return recorded, np.array([recorded[f"elements/c{i}/strain"][-1] for i in range(PIECES)])


def test_a_cable_is_pulled_at_its_end(verify):
    """Behind the wave the tension is EA v/c (Donnell 1930); before it there is none."""
    _, strains = hit((-1, 0, 0))
    behind, before = slice(5, 60), slice(95, None)  # the wave is at 80
    verify("Cables", "pulled at its end: strain behind the wave", strains[behind].mean(), SPEED / WAVE, "v/c, Donnell",
           relative=1e-4)  # fmt: skip
    assert np.ptp(strains[behind]) < 1e-3 * SPEED / WAVE and np.abs(strains[before]).max() < 0.02 * SPEED / WAVE


def test_a_cable_is_hit_across(verify):
    """Behind a longitudinal wave the strain is e, also behind a kink of the material speed c sqrt(e/(1 + e)).

    Smith, McCrackin & Schiefer, Text. Res. J. 28 (1958) 288: V^2 = c^2 (2 e sqrt(e (1 + e)) - e^2).
    """
    recorded, strains = hit((0, 0, -1))
    e = brentq(lambda e: 2.0 * e * math.sqrt(e * (1.0 + e)) - e * e - (SPEED / WAVE) ** 2, 1e-6, 0.5)
    kink = WAVE * math.sqrt(e / (1.0 + e)) * END
    at = (np.arange(PIECES) + 0.5) / PIECES
    found = [strains[at < 0.7 * kink].mean(), strains[(at > 1.6 * kink) & (at < 0.8 * WAVE * END)].mean()]
    verify(
        "Cables", "hit across: strains before and behind the kink", found, [e, e], "Smith et al. (1958)", relative=2e-3
    )
    z = np.array([recorded[f"nodes/n{i}/position"][-1, 2] for i in range(PIECES + 1)])
    slope, level = np.polyfit(at[: int(0.7 * kink * PIECES)] - 0.5 / PIECES, z[: int(0.7 * kink * PIECES)], 1)
    verify("Cables", "hit across: place of the kink [m]", -level / slope, kink, "Smith et al. (1958)", relative=5e-3)


RADIUS, HEAVY, LIGHT, INERTIA, FREE, TILT = 0.1, 1.2, 1.0, 0.01, 1.0, 1.0
SWINGING = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes:
      heavy: {{position: [-1.1, 0, -2]}}
      left: {{position: [-1, 0, 0]}}
      right: {{position: [0, 0, 0]}}
      light: {{position: [{x}, 0, {z}]}}
    elements:
      heavy: {{type: point_mass, node: heavy, mass: 1.2}}
      light: {{type: point_mass, node: light, mass: 1}}
      left: {{type: rigid_body, node: left, mass: 1, inertia: [0.01, {J}, 0.01]}}
      right: {{type: rigid_body, node: right, mass: 1, inertia: [0.01, {J}, 0.01]}}
      rope: {{type: {rope}, nodes: [heavy, left, right, light], radii: [0, -0.1, -0.1, 0], axis: [0, -1, 0],
             axial_stiffness: 4.0e5, pretension: 10, damping: 1 ms}}
    joints:
      left: {{type: hinge, nodes: [ground, left], axis: [0, 1, 0]}}
      right: {{type: hinge, nodes: [ground, right], axis: [0, 1, 0]}}
    time: {{end: 1.5, step: 1 ms, method: radau, adaptive: {{tolerance: 1.0e-7}}}}
"""


def swinging(inertia):
    """Return the positions (x, z) of the light weight and z of the heavy one after 1.5 s, by SciPy.

    s is the rise of the heavy weight, theta the angle of the swinging rope, r = r_0 + s + R theta its free length:
    (M + m + 2 J/R^2) s'' = m r theta'^2 + g (m cos theta - M), r theta'' = -2 s' theta' - R theta'^2 - g sin theta.
    """

    def rates(_, y):
        s, theta, s1, theta1 = y
        r = FREE + s + RADIUS * (theta - TILT)
        s2 = LIGHT * r * theta1**2 + g * (LIGHT * math.cos(theta) - HEAVY)
        theta2 = -(2.0 * s1 * theta1 + RADIUS * theta1**2 + g * math.sin(theta)) / r
        return s1, theta1, s2 / (HEAVY + LIGHT + 2.0 * inertia / RADIUS**2), theta2

    s, theta, _, _ = solve_ivp(rates, (0.0, 1.5), (0.0, TILT, 0.0, 0.0), rtol=1e-11, atol=1e-12).y[:, -1]
    r = FREE + s + RADIUS * (theta - TILT)
    return [*hanging(r, theta), s - 2.0]


def hanging(r, theta):
    """Return the place (x, z) of a weight on the free length r of a rope that leaves the pulley at the angle theta."""
    return RADIUS * math.cos(theta) + r * math.sin(theta), RADIUS * math.sin(theta) - r * math.cos(theta)


@pytest.mark.parametrize("rope, inertia", [("belt", INERTIA), ("reeved_cable", 0.0)])
def test_a_swinging_atwood_machine(verify, rope, inertia):
    """Pujol et al., Physica D 239 (2010) 1067, with pulleys of finite radius that turn with the rope, or not at all."""
    x, z = hanging(FREE, TILT)
    recorded = RecordedRun(deck(SWINGING.format(x=x, z=z, rope=rope, J=INERTIA)))
    light, heavy = (recorded[f"nodes/{name}/position"][-1] for name in ("light", "heavy"))
    verify("Cables", f"swinging Atwood machine ({rope}): places [m]", [light[0], light[2], heavy[2]], swinging(inertia),
           "Pujol et al. (2010), by SciPy", absolute=2e-4)  # fmt: skip


def test_an_elastic_catenary(verify):
    """A chain of 40 cables 1.2 times as long as its span: sag and tension at its end (Irvine, Cable Structures, 1981).

    x(s) = H s/EA + H/w (asinh(V/H) - asinh((V - w s)/H)), V the vertical force at the end, w the weight per length.
    """
    length, span, stiffness, weight, n = 12.0, 10.0, 2.0e3, 20.0 * g, 40

    def place(H, s):
        V = 0.5 * weight * length
        x = H * s / stiffness + H / weight * (math.asinh(V / H) - math.asinh((V - weight * s) / H))
        z = s / stiffness * (V - 0.5 * weight * s) + (math.hypot(H, V) - math.hypot(H, V - weight * s)) / weight
        return x, z

    (H,) = fsolve(lambda H: place(H[0], length)[0] - span, [500.0])
    line = f"axial_stiffness: {stiffness}, natural_length: {length}, mass_per_length: 20, mesh: {n}, sag: [0, 0, -1]"
    hung = f"nodes:\n  a: {{position: [0, 0, 0], fixed: true}}\n  b: {{position: [{span}, 0, 0], fixed: true}}\n"
    hung += f"elements:\n  c: {{type: cable, nodes: [a, b], {line}}}\n"
    path = Path(deck(f"mecano: 1\ngravity: [0, 0, -9.81]\n{hung}static: {{}}\n"))
    sag = -path.positions(f"c.{n // 2}")[-1, 2]
    verify("Cables", "elastic catenary of 40 cables: sag [m]", sag, place(H, 0.5 * length)[1], "Irvine", relative=5e-4)
    first, second = (path.positions(node)[-1] for node in ("a", "c.1"))
    tension = stiffness * (np.linalg.norm(second - first) / (length / n) - 1.0)
    exact = math.hypot(H, 0.5 * weight * length * (1.0 - 1.0 / n))
    verify("Cables", "elastic catenary of 40 cables: tension at its end [N]", tension, exact, "Irvine", relative=2e-5)


POLE = """
    mecano: 1
    gravity: none
    nodes:
      peg: {position: [0.1, -0.5, 0], fixed: true}
      pole: {position: [0, 0, 0], fixed: true}
      ball: {position: [0.1, 1.5, 0]}
    elements:
      ball: {type: point_mass, node: ball, mass: 0.5}
      rope: {type: reeved_cable, nodes: [peg, pole, ball], radii: [0, 0.1, 0], axis: [0, 0, 1], axial_stiffness: 1 MN}
    joints: {flat: {type: prescribed_position, node: ball, direction: [0, 0, 1], value: 0}}
    initial: {velocities: [{nodes: [ball], velocity: [-2, 0, 0]}]}
    time: {end: 4, step: 2 ms}
"""


def test_a_rope_winds_onto_a_pole(verify):
    """The ball keeps its speed v, and the free length l of the rope falls with dl/dt = -R v/l, as on an involute."""
    run = RecordedRun(deck(POLE))
    x, v = run["nodes/ball/position"], run["nodes/ball/velocity"]
    free = np.sqrt(x[:, 0] ** 2 + x[:, 1] ** 2 - 0.1**2)
    exact = np.sqrt(1.5**2 - 2 * 0.1 * 2 * run.time)
    verify("Cables", "rope that winds onto a pole: free length [m]", free, exact, "closed form", absolute=2e-4)
    np.testing.assert_allclose(np.linalg.norm(v, axis=1), 2.0, rtol=2e-3)
