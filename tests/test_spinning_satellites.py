"""Small motions of what spins or circles freely: satellites, a ring, a string, in axes that turn with them."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from time_runs import deck

from mecano.analyses.modal import modes

S = "Satellites and rings"

SPINNER = """
    mecano: 1
    gravity: none
    nodes: {{hub: {{position: [0, 0, 0]}}, rail: {{position: [0.6, 0, 0]}}, ball: {{position: [0.6, 0, 0]}}}}
    elements:
      hub: {{type: rigid_body, node: hub, mass: 100, inertia: [20, 20, {C}], attached: [rail]}}
      ball: {{type: point_mass, node: ball, mass: 1.5}}
    joints:
      tube: {{type: prismatic, nodes: [rail, ball], axis: [0, 0, 1], sliding_law: {{spring: 10, damper: 1.2}}}}
    initial: {{steady: {{angular_velocity: [0, 0, 3], about: [0, 0, 0]}}}}
    time: {{end: 1, step: 1 ms}}
"""


def of_spinner(C, A=20.0, m=100.0 * 1.5 / 101.5, b=0.6, k=10.0, c=1.2, n=3.0):
    """Eigenvalues of a spinner with a mass in a tube along its axis at the radius b; m: the reduced mass.

    States are the angular velocities across the axis, the place of the mass and its rate.
    """
    I1, I2, I3 = A, A + m * b * b, C + m * b * b
    E = np.array([[I1, 0, 0, 0], [0, I2, 0, -m * b], [0, 0, 1, 0], [0, -m * b, 0, m]])
    F = np.array([[0, n * (I2 - I3), 0, 0], [n * (I3 - I1), 0, m * b * n**2, 0], [0, 0, 0, 1], [-m * n * b, 0, -k, -c]])
    return np.linalg.eigvals(np.linalg.solve(E, F))


def seen(text, rate, number=10_000):
    """Eigenvalues with a positive imaginary part, and real ones, in axes that turn at a rate about z."""
    _, found, _ = modes(deck(text), None, number=number, frame=f"0,0,{rate}")
    return found.values


def nearest(found, wanted):
    """The eigenvalues found nearest to those wanted."""
    wanted = np.asarray(wanted, complex)
    return found[np.argmin(np.abs(found[None] - wanted[:, None]), axis=1)]


@pytest.mark.parametrize(("C", "grows"), [(30.0, False), (14.0, True)])
def test_a_damper_calms_the_nutation_of_an_oblate_body_alone(C, grows, verify):
    wanted = of_spinner(C)
    wanted = wanted[wanted.imag > 0.0]
    name = f"spinner with a nutation damper, C/A = {C / 20:g}: eigenvalues [1/s]"
    verify(S, name, nearest(seen(SPINNER.format(C=C), 3), wanted), wanted, "equations of Euler", relative=1e-8)
    assert (wanted.real.max() > 1e-3) == grows


@pytest.mark.parametrize("inertia", [(60.0, 100.0, 120.0), (110.0, 125.0, 50.0)])
def test_a_satellite_on_its_orbit(inertia, verify):
    """About radius, track and normal it yaws, rolls and pitches.

    With x = (s/n)^2: x^2 + (1 + 3 k + k j) x + 4 k j = 0 for yaw and roll, x = 3 (I_yaw - I_roll)/I_pitch for pitch.
    """
    yaw, roll, pitch = inertia
    k, j = (pitch - yaw) / roll, (pitch - roll) / yaw
    squares = np.append(np.roots([1.0, 1.0 + 3.0 * k + k * j, 4.0 * k * j]), 3.0 * (yaw - roll) / pitch)
    wanted = np.sqrt(squares.astype(complex))
    wanted = 1e-3 * np.where(wanted.imag < 0.0, -wanted, wanted)
    text = f"""
        mecano: 1
        gravity: none
        nodes: {{sat: {{position: [0, 0, 0]}}}}
        elements: {{sat: {{type: rigid_body, node: sat, mass: 200, inertia: {list(inertia)}}}}}
        loads:
          orbit:
            {{type: gravity_gradient, node: sat, mass: 200, inertia: {list(inertia)}, rate: 1.0e-3, normal: [0, 0, 1],
             radial: [1, 0, 0]}}
        initial: {{velocities: [{{nodes: all, angular_velocity: [0, 0, 1.0e-3], about: [0, 0, 0]}}]}}
        time: {{end: 1, step: 1}}
    """
    found = nearest(seen(text, 1e-3), wanted)
    verify(S, f"satellite {inertia} kg m2: eigenvalues [1/s]", found, wanted, "DeBra and Delp 1961", relative=1e-9)


def test_the_waves_of_a_ring_that_spins_split(verify):
    """Bryan 1890: w = w_n -+ 2 n/(n^2 + 1) Omega in its axes; it turns too slowly for its tension to count.

    The mesh has 16 and 11 beams in a wave.
    """
    at = [2.0 * math.pi * i / 64 for i in range(64)]
    place = [f"[{math.cos(x)!r}, {math.sin(x)!r}, 0]" for x in at]
    nodes = ", ".join(f"p{i}: {{position: {place[2 * i]}, orientation: [0, 0, {at[2 * i]!r}]}}" for i in range(32))
    beams = ", ".join(
        f"e{i}: {{type: beam, nodes: [p{i}, p{(i + 1) % 32}], section: s, up: [0, 0, 1], via: {place[2 * i + 1]}}}"
        for i in range(32)
    )
    text = f"""
        mecano: 1
        gravity: none
        sections: {{s: {{type: stiffness, EA: 1.0e7, GA2: 1.0e9, GA3: 1.0e9, GJ: 1.0e4, EI2: 1.0e4, EI3: 1.0e3,
                        mass_per_length: 1, rotary_inertia: [2.0e-6, 1.0e-6, 1.0e-6]}}}}
        nodes: {{{nodes}}}
        elements: {{{beams}}}
        initial: {{steady: {{angular_velocity: [0, 0, 0.5], about: [0, 0, 0]}}}}
        time: {{end: 1, step: 1 ms}}
    """
    frequencies = np.sort(seen(text, 0.5, 24).imag)
    for n in (2, 3):
        wave = n * (n * n - 1) / math.sqrt(n * n + 1) * math.sqrt(1e3)
        pair = frequencies[np.abs(frequencies - wave) < 2.0]
        verify(S, f"ring, n = {n}: mean frequency [rad/s]", pair.mean(), wave, "thin ring", relative=3e-4)
        verify(S, f"ring, n = {n}: splitting [rad/s]", np.ptp(pair), 2.0 * n / (n * n + 1), "Bryan 1890", relative=3e-3)


def test_a_string_that_is_whirled_about_its_end(verify):
    """Across the plane w = Omega sqrt(n (2 n - 1)), in it w = Omega sqrt(n (2 n - 1) - 1), n = 1, 2, 3."""
    text = """
        mecano: 1
        gravity: none
        nodes: {hub: {position: [0, 0, 0]}, p$i: {repeat: {i: 0..40}, position: [$i/40, 0, 0]}}
        elements:
          hub: {type: rigid_body, node: hub, mass: 1, inertia: [1, 1, 1]}
          c$i: {repeat: {i: 1..40}, type: cable, nodes: [p$(i - 1), p$i], axial_stiffness: 1 MN, mass_per_length: 0.5}
        joints:
          root: {type: spherical, nodes: [hub, p0]}
          shaft: {type: hinge, nodes: [ground, hub], axis: [0, 0, 1]}
          drive: {type: prescribed_angle, nodes: [ground, hub], axis: [0, 0, 1], value: 10*time}
        initial: {steady: {angular_velocity: [0, 0, 10], about: [0, 0, 0]}}
        time: {end: 1, step: 1 ms}
    """
    squares = [n * (2 * n - 1) - inside for n in (1, 2, 3) for inside in (0, 1)]
    wanted = 10.0 * np.sqrt(np.array(squares[:1] + squares[2:]))
    found = nearest(seen(text, 10, 16), 1j * wanted).imag
    verify(
        S, "whirled string of 40 cables: frequencies [rad/s]", found, wanted, "polynomials of Legendre", relative=3e-3
    )


def of_dumbbell(across, EI=60.0, mu=0.8, L=3.0, m=0.7, n=15.0, terms=16):
    """Circular frequencies of a beam with a mass at each end that spins about its middle, by Ritz's method.

    ``across``: out of the plane of the rotation, otherwise in it, where the centrifugal force reduces the stiffness.
    """
    x, weights = np.polynomial.legendre.leggauss(2 * terms)
    powers = [np.polynomial.Polynomial.basis(k) for k in range(terms)]
    w, slope, bend = (np.array([p.deriv(d)(x) * (2.0 / L) ** d for p in powers]) for d in (0, 1, 2))
    weights = weights * L / 2.0
    ends = np.array([[p(-1.0), p(1.0)] for p in powers])
    tension = n**2 * (m * L / 2.0 + mu * (L / 2.0) ** 2 * (1.0 - x**2) / 2.0)
    M = mu * (w * weights) @ w.T + m * ends @ ends.T
    K = EI * (bend * weights) @ bend.T + (slope * weights * tension) @ slope.T
    squares = np.sort(np.linalg.eigvals(np.linalg.solve(M, K)).real)[2:6]  # without translation and tilt
    return np.sqrt(squares if across else squares - n**2)


@pytest.mark.parametrize(("mesh", "within"), [(12, 1e-4), (45, 3e-5)], ids=["dense", "sparse"])
def test_a_free_boom_that_spins_bends_and_does_not_flutter(mesh, within, verify):
    """Its drift is a double eigenvalue i n in axes that turn at n, its spin a double zero: rounding splits both.

    Half of each pair would grow.
    """
    text = f"""
        mecano: 1
        gravity: none
        sections: {{s: {{type: stiffness, EA: 1e8, GA2: 1e8, GA3: 1e8, GJ: 1e3, EI2: 60, EI3: 60, mass_per_length: 0.8,
                       rotary_inertia: [1e-6, 0, 0]}}}}
        nodes: {{a: {{position: [-1.5, 0, 0]}}, b: {{position: [1.5, 0, 0]}}, c: {{position: [0, 0, 0]}}}}
        elements:
          left: {{type: beam, nodes: [a, c], section: s, mesh: {mesh}}}
          right: {{type: beam, nodes: [c, b], section: s, mesh: {mesh}}}
          end_$i: {{repeat: {{i: [a, b]}}, type: point_mass, node: $i, mass: 0.7}}
        initial: {{steady: {{angular_velocity: [0, 0, 15], about: [0, 0, 0]}}}}
        time: {{end: 1, step: 1 ms}}
    """
    _, found, _ = modes(deck(text), None, number=14, frame="0,0,15")
    assert found.kinds == ["free"] * 3 + ["oscillation"] * 11
    wanted = np.concatenate([of_dumbbell(True), of_dumbbell(False)])
    seen_ones = nearest(found.values, 1j * wanted).imag
    what = f"spinning boom of {2 * mesh} beams, masses at its ends: frequencies [rad/s]"
    verify(S, what, seen_ones, wanted, "Ritz", relative=within)


PANELS, SPRING, DRAG = 40, 500.0, 0.1  # hinged panels of 1 m and 2 kg; moment per rad, and per rad/s


def of_panels(n=2.0, m=2.0, J=(0.1, 0.2, 0.25)):
    """Eigenvalues of a straight chain of hinged panels that spins about its middle, out of the plane of the rotation.

    Unknowns are the height of the first end and the slopes. Slopes shorten the chain, against the centrifugal forces.
    """
    places = np.arange(PANELS) - (PANELS - 1) / 2.0
    heights = np.tril(np.ones((PANELS, PANELS)), -1) + 0.5 * np.eye(PANELS)
    heights = np.column_stack([np.ones(PANELS), heights])
    slopes, bends = np.eye(PANELS + 1)[1:], np.diff(np.eye(PANELS + 1)[1:], axis=0)
    tension = np.array([places[i + 1 :].sum() + 0.5 * places[i] for i in range(PANELS)])
    M = m * heights.T @ heights + J[1] * slopes.T @ slopes
    K = slopes.T @ ((n**2 * (m * tension + J[2] - J[0]))[:, None] * slopes) + SPRING * bends.T @ bends
    C, one, none = DRAG * bends.T @ bends, np.eye(PANELS + 1), np.zeros((PANELS + 1,) * 2)
    values = np.linalg.eigvals(np.block([[none, one], [-np.linalg.solve(M, K), -np.linalg.solve(M, C)]]))
    values = values[values.imag > 1.1 * n]  # without those of translation and tilt
    return values[np.argsort(np.abs(values))]


def test_a_long_chain_of_panels_spins_freely_about_a_skew_axis(verify):
    """Its double zeros perturb other modes of a large model in proportion to the square of the shift of the solver.

    Its constraints turn with the panels, and hold the same motions at any time.
    """
    R = Rotation.from_rotvec([0.5, 0.3, -0.4]).as_matrix()
    at = [f"[(PLACE)*{x!r}, (PLACE)*{y!r}, (PLACE)*{z!r}]" for x, y, z in [R[:, 0].tolist()]][0]
    middle, left, right = (at.replace("PLACE", f"$i - {PANELS // 2} - {past}") for past in (0.5, 1.0, 0.0))
    axis = (2.0 * R[:, 2]).tolist()
    text = f"""
        mecano: 1
        gravity: none
        nodes:
          p$i: {{repeat: {{i: 1..{PANELS}}}, position: {middle}, orientation: [0.5, 0.3, -0.4]}}
          l$i: {{repeat: {{i: 1..{PANELS}}}, position: {left}}}
          r$i: {{repeat: {{i: 1..{PANELS}}}, position: {right}}}
        elements:
          p$i: {{repeat: {{i: 1..{PANELS}}}, type: rigid_body, node: p$i, mass: 2, inertia: [0.1, 0.2, 0.25],
            attached: [l$i, r$i]}}
        joints:
          h$i: {{repeat: {{i: 2..{PANELS}}}, type: hinge, nodes: [r$(i - 1), l$i], axis: {R[:, 1].tolist()},
            turning_law: {{spring: {SPRING}, damper: {DRAG}}}}}
        initial: {{steady: {{angular_velocity: {axis}, about: [0, 0, 0]}}}}
        time: {{end: 1, step: 1 ms}}
    """
    said, found, _ = modes(deck(text), None, number=8, frame=",".join(map(str, axis)))
    assert "not constant" not in said
    assert found.converged.all() and set(found.kinds) == {"free", "oscillation"}
    wanted = of_panels()
    what = f"chain of {PANELS} hinged panels that spins freely: eigenvalues [1/s]"
    verify(S, what, nearest(found.values, wanted[:2]), wanted[:2], "equations of the slopes", relative=1e-4)
