"""Modes of a hanging chain and of columns under follower forces against closed forms and published values."""

import numpy as np
import pytest
from numpy.polynomial.laguerre import lagroots
from scipy.optimize import bisect, fsolve
from scipy.special import jn_zeros
from small_motions import eigenvalues
from time_runs import deck

from mecano.analyses.modal import modes

G = 9.81


def test_a_chain_swings_with_the_zeros_of_laguerre(verify):
    """Equal masses on equal rods h: w^2 = G/h times the zeros of L_n, in both vertical planes."""
    n, h = 25, 0.1
    found = eigenvalues(
        deck(f"""
    mecano: 1
    gravity: [0, 0, -{G}]
    nodes:
      p$i: {{repeat: {{i: 0..{n}}}, position: [0, 0, -$i*{h}]}}
    elements:
      mass$i: {{repeat: {{i: 1..{n}}}, type: point_mass, node: p$i, mass: 0.2}}
    joints:
      rod$i: {{repeat: {{i: 1..{n}}}, type: rigid_rod, nodes: [p$(i - 1), p$i]}}
      top: {{type: spherical, nodes: [ground, p0]}}
    initial: static
    time: {{end: 1, step: 1 ms}}
    """)
    )
    expected = np.repeat(np.sqrt(G / h * lagroots([0] * n + [1])), 2)
    verify(
        "Modes", f"chain of {n} rods: frequencies [rad/s]", np.sort(found.imag[found.imag > 0.0]), expected,
        "zeros of Laguerre's polynomial", relative=1e-10,
    )  # fmt: skip


def test_a_rope_of_beams_swings_with_the_zeros_of_bessel(verify):
    """w = j_0n/2 sqrt(g/L) of a rope without stiffness; 32 elements and EI = 1e-4 N m2 err in the fourth digit."""
    L = 10.0
    found = eigenvalues(
        deck(f"""
    mecano: 1
    gravity: [0, 0, -{G}]
    sections:
      rope:
        {{type: stiffness, EA: 1 MN, GA2: 1.0e5, GA3: 1.0e5, GJ: 1.0e-4, EI2: 1.0e-4, EI3: 1.0e-4, mass_per_length: 0.5,
         rotary_inertia: [1.0e-6, 1.0e-6, 1.0e-6]}}
    nodes: {{top: {{position: [0, 0, 0]}}, tip: {{position: [0, 0, -{L}]}}}}
    elements: {{rope: {{type: beam, nodes: [top, tip], section: rope, mesh: 32}}}}
    joints: {{top: {{type: spherical, nodes: [ground, top]}}}}
    initial: static
    time: {{end: 1, step: 1 ms}}
    """)
    )
    expected = jn_zeros(0, 2) / 2.0 * np.sqrt(G / L)
    w = np.sort(found.imag[found.imag > 1e-3])
    verify("Modes", "hanging rope: two frequencies [rad/s]", w[[0, 2]], expected, "zeros of J_0", relative=1e-3)


def column(load, damping):
    """A cantilever of EI = 100 N m2 and 2 m under a follower force of ``load`` EI/L^2."""
    return deck(f"""
    mecano: 1
    gravity: none
    sections:
      rod:
        {{type: stiffness, EA: 1.0e8, GA2: 1.0e8, GA3: 1.0e8, GJ: 100, EI2: 100, EI3: 1000, mass_per_length: 2,
         rotary_inertia: [1.0e-8, 1.0e-8, 1.0e-8], damping: {damping}}}
    nodes: {{foot: {{position: [0, 0, 0], fixed: true}}, tip: {{position: [2, 0, 0]}}}}
    elements: {{rod: {{type: beam, nodes: [foot, tip], section: rod, up: [0, 0, 1], mesh: 12}}}}
    loads: {{thrust: {{type: follower_force, node: tip, direction: [-1, 0, 0], value: {load * 100 / 2**2}}}}}
    initial: {{static: {{method: steps}}}}
    time: {{end: 1, step: 1 ms}}
    """)


def determinant(load, frequency, damping):
    """Characteristic determinant of E I (1 + damping s) w'''' + P w'' + m s^2 w = 0 at s = i ``frequency``.

    w = w' = 0 at the foot, w'' = w''' = 0 at the tip; divided by that of Vandermonde, which vanishes for equal roots.
    """
    EI, m, L, s = 100.0, 2.0, 2.0, 1j * frequency
    squares = np.roots([EI * (1.0 + damping * s), load * EI / L**2, m * s**2]).astype(complex)
    r = np.concatenate([np.sqrt(squares), -np.sqrt(squares)])
    rows = np.array([r**0, r, r**2 * np.exp(r * L), r**3 * np.exp(r * L)])
    return np.linalg.det(rows) / np.linalg.det(np.vander(r))


@pytest.mark.parametrize(("damping", "published"), [(0.0, 20.0510), (1e-3, 10.94)])
def test_becks_column_flutters(damping, published):
    """Beck 1952: 20.05 EI/L^2; a little internal damping nearly halves it (Bolotin & Zhinzher 1969: 10.94)."""

    def parts(x):
        value = determinant(*x, damping)
        return [value.real, value.imag]

    critical = fsolve(parts, [published, 9.5])[0] if damping else published
    assert critical == pytest.approx(published, abs=0.001)
    for load in (0.999 * critical, 1.001 * critical):
        _, found, _ = modes(column(load, damping), None, number=8)
        assert found.converged.all()
        fastest = found.values[np.argmax(found.values.real)]
        assert (fastest.real > (0.0 if damping else 0.1)) == (load > critical) and abs(fastest.imag) > 5.0


ROCKET = """
    mecano: 1
    gravity: [-$load, 0, 0] # of axes that move with the centre of mass
    parameters: {load: LOAD}
    sections:
      rod:
        {type: stiffness, EA: 1.0e6, GA2: 1.0e6, GA3: 1.0e6, GJ: 1, EI2: 1.0e4, EI3: 1, mass_per_length: 1,
         rotary_inertia: [2.0e-7, 1.0e-7, 1.0e-7]}
    nodes: {tail: {position: [0, 0, 0]}, nose: {position: [1, 0, 0]}}
    elements: {rod: {type: beam, nodes: [tail, nose], section: rod, up: [0, 0, 1], mesh: 16}}
    joints: {flight: {type: planar, nodes: [ground, tail], axis: [0, 0, 1]}}
    loads: {thrust: {type: follower_force, node: tail, direction: [1, 0, 0], value: $load}}
    initial: {static: {method: steps}}
    time: {end: 1, step: 1 ms}
    """


def leipholz(load):
    """Return the ROCKET as a cantilever that a load along it compresses, which follows it."""
    text = ROCKET.replace("[-$load, 0, 0]", "none").replace("tail: {position", "tail: {fixed: true, position")
    text = text.replace("joints: {flight: {type: planar, nodes: [ground, tail], axis: [0, 0, 1]}}", "")
    old = "type: follower_force, node: tail, direction: [1, 0, 0]"
    return text.replace(old, "type: line_load, line: rod, follows: true, direction: [-1, 0, 0]").replace("LOAD", load)


def flutters_at(free):
    """Return the load at which two frequencies of a beam of unit length, EI and mass meet, from 12 polynomials.

    Free: EI w_xxxx + (load (1 - x) w_x)_x + w_tt = 0, w_xx = w_xxx = 0 at both ends, as the thrust follows the tail.
    Clamped: EI w_xxxx + load (1 - x) w_xx + w_tt = 0.
    """
    x, weights = np.polynomial.legendre.leggauss(40)
    x, weights = 0.5 * (x + 1.0), 0.5 * weights
    w = [np.polynomial.Polynomial.basis(k + (0 if free else 2)) for k in range(12)]
    at = [np.array([f.deriv(n)(x) for f in w]) for n in range(3)]
    M, bending = (at[n] * weights @ at[n].T for n in (0, 2))
    axial = at[0] * weights * (1.0 - x) @ at[2].T
    if free:
        axial = -(at[1] * weights * (1.0 - x) @ at[1].T) - np.outer([f(0.0) for f in w], [f.deriv()(0.0) for f in w])

    def grows(load):
        return np.abs(np.linalg.eigvals(np.linalg.solve(M, bending + load * axial)).imag).max() > 1.0

    return bisect(lambda load: 0.5 - grows(load), 20.0, 150.0, xtol=1e-4)


@pytest.mark.parametrize(
    ("text", "free", "published"), [(lambda load: ROCKET.replace("LOAD", load), True, 109.9), (leipholz, False, 40.05)]
)
def test_a_free_rocket_and_a_column_under_a_load_along_it_flutter(text, free, published):
    """Beal 1965: thrust 109.9 EI/L^2; Leipholz 1962: 40.05 EI/L^3."""
    critical = flutters_at(free)
    assert critical == pytest.approx(published, rel=3e-3)
    for load in (0.999 * critical, 1.001 * critical):
        _, found, _ = modes(deck(text(repr(load))), None, number=8)
        fastest = found.values[np.argmax(found.values.real)]
        assert (fastest.real > 0.01) == (load > critical) and (load < critical or abs(fastest.imag) > 5.0)
