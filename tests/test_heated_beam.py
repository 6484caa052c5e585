"""Heated beams: free expansion and bending, held ends, and the vibration of a boom in the sun."""

import numpy as np
import pytest
from equilibria import Equilibrium, Path
from scipy.integrate import quad
from scipy.optimize import brentq
from time_runs import RecordedRun, input_deck

from mecano.errors import ConvergenceError, DeckError

EA, LENGTH = 2e6, 2.0
PEAK = 0.04747  # m, of the tip in linear theory
MEMBER = """
    mecano: 1
    gravity: none
    nodes: {{left: {{position: [0, 0, 0], fixed: true}}, right: {{position: [2, 0, 0]{fixed}}}}}
    sections: {{s: {{type: stiffness, EA: 2.0e6, GA2: 1.0e6, GA3: 1.0e6, GJ: 400, EI2: 300, EI3: 300,
      mass_per_length: 1, rotary_inertia: [1.0e-3, 1.0e-3, 1.0e-3]}}}}
    elements: {{rod: {{type: beam, nodes: [left, right], section: s, mesh: 8, up: [0, 0, 1], thermal: {thermal}}}}}
    static: {{over: time, end: 1, steps: 8}}
"""


def heated(thermal, fixed=""):
    return Path(MEMBER.format(thermal=thermal, fixed=fixed))


def test_a_free_beam_becomes_longer():
    path = heated("{strain: {linear: {slope: 0.01}}}")
    np.testing.assert_allclose(path.positions("right")[-1], [LENGTH * 1.01, 0, 0], atol=1e-12)


def test_a_free_beam_bends_to_an_arc():
    """Exact for any number of elements: the free shape is a helix. Its curvature is a formula."""
    path = heated("{curvature_2: 0.8*time}")
    angle = 0.8 * LENGTH
    x, z = np.sin(angle) / 0.8, -(1 - np.cos(angle)) / 0.8  # about axis 2 = y: x turns to -z
    np.testing.assert_allclose(path.positions("right")[-1], [x, 0, z], atol=1e-9)


def test_a_hot_beam_that_buckles_on_its_path_is_to_be_heated_slowly():
    """The forces that fade press the beam with EA eps = 20 kN, a hundred times its buckling load, though it is free."""
    with pytest.raises(ConvergenceError, match="; over: time, with heating, .* that grow by laws of time"):
        heated("{strain: 0.01, curvature_2: 0.6, curvature_3: -0.8}")
    path = heated("{strain: 0.01*time, curvature_2: 0.6*time, curvature_3: -0.8*time}")
    angle = 1.0 * LENGTH  # of an arc with the curvature 1/m, towards -(0.8, 0.6) in the section
    side = 1 - np.cos(angle)
    end = 1.01 * np.array([np.sin(angle), -0.8 * side, -0.6 * side])
    np.testing.assert_allclose(path.positions("right")[-1], end, atol=1e-9)


def test_heating_is_by_formulas_or_by_laws():
    with pytest.raises(DeckError, match="'thermal' has formulas and laws of time: a law can be a signal, a 'curve' of"):
        heated("{curvature_2: 0.8*time, strain: {linear: {slope: 1}}}")


def test_the_direction_of_a_thermal_curvature_is_not_left_to_the_inertial_axes():
    """A round boom that is placed in other axes would bend in another direction of its own."""
    straight = "elements.boom={type: beam, nodes: [satellite, tip], section: tube, thermal: {strain: 1.0e-4}}"
    input_deck("boom_in_sun", "elements.boom.up=null", straight)
    with pytest.raises(DeckError, match="missing 'up': the direction of axis 3, towards which 'thermal' bends"):
        input_deck("boom_in_sun", "elements.boom.up=null")


def test_a_held_beam_is_pressed():
    """N = -EA alpha dT, below the buckling strain 4 pi^2 EI/(EA L^2) = 1.5e-3."""
    end = Equilibrium(MEMBER.format(thermal="{strain: 1.0e-3}", fixed=", fixed: true") + "    loads: {}\n")
    assert end.output("elements/rod.4/force")[0] == pytest.approx(-EA * 1e-3, rel=1e-12)


@pytest.mark.parametrize("by", ["law", "formula"])
def test_a_free_beam_with_its_shear_centre_aside_bends_to_an_arc(by):
    """Heating deforms the line of nodes; on a line aside the same arc has another length."""
    C = np.diag([2e6, 1e6, 1e6, 400.0, 300.0, 300.0])
    C[3, 3] += 1e6 * 0.03**2
    C[2, 3] = C[3, 2] = 1e6 * 0.03
    values = {"law": ("{linear: {slope: 0.01}}", "{linear: {slope: 0.8}}"), "formula": ("0.01*time", "0.8*time")}
    strain, curvature = values[by]
    section = f"{{type: matrix, stiffness: {C.tolist()}, mass: {np.eye(6).tolist()}}}"
    text = MEMBER.format(thermal=f"{{strain: '{strain}', curvature_3: '{curvature}'}}".replace("'", ""), fixed="")
    start, end = text.index("{type: stiffness"), text.index("}}\n    elements")
    path = Path(text[:start] + section + text[end + 1 :])
    angle = 0.8 * LENGTH
    x, y = np.sin(angle) * 1.01 / 0.8, (1 - np.cos(angle)) * 1.01 / 0.8
    np.testing.assert_allclose(path.positions("right")[-1], [x, y, 0], atol=1e-9)


def deflections(t, curvature, tau, section, damping):
    """Deflection of the tip of a cantilever with the thermal curvature c (1 - exp(-t/tau)), by its modes.

    w = k x^2/2 + sum q_n phi_n with q_n'' + damping w_n^2 q_n' + w_n^2 q_n = -k''(t) <x^2/2, phi_n>; w at rest first.
    """
    stiffness, mass, length = section
    tip, r = 0.5 * curvature * length**2 * (1 - np.exp(-t / tau)), 1 / tau
    for n in range(6):
        b = brentq(lambda b: np.cos(b) + 1 / np.cosh(b), n * np.pi + 0.1, (n + 1) * np.pi) / length
        s = (np.cosh(b * length) + np.cos(b * length)) / (np.sinh(b * length) + np.sin(b * length))

        def mode(x, b=b, s=s):
            return np.cosh(b * x) - np.cos(b * x) - s * (np.sinh(b * x) - np.sin(b * x))

        part = quad(lambda x, mode=mode: 0.5 * x * x * mode(x), 0, length)[0]
        share = part / quad(lambda x, mode=mode: mode(x) ** 2, 0, length)[0]
        w = b * b * np.sqrt(stiffness / mass)
        decay = 0.5 * damping * w * w
        damped = np.sqrt(w * w - decay * decay)
        driven = share * curvature * r * r / (r * r - 2 * decay * r + w * w)
        sine = (-share * curvature * r + driven * r - decay * driven) / damped
        free = np.exp(-decay * t) * (sine * np.sin(damped * t) - driven * np.cos(damped * t))
        tip = tip + (driven * np.exp(-r * t) + free) * mode(length)
    return tip


def test_a_boom_comes_into_the_sun():
    """The linear theory of Bernoulli beams; shear, rotary inertia and large rotations are the difference."""
    m = RecordedRun(input_deck("boom_in_sun"))
    outer, inner = 15e-3, 14.5e-3
    section = (130e9 * np.pi * (outer**4 - inner**4) / 4, 8300 * np.pi * (outer**2 - inner**2), 5.0)
    expected = deflections(m.time, 17e-6 * 4 / 30e-3, 0.15, section, 2e-4)
    assert expected.max() == pytest.approx(PEAK, abs=2e-5)
    np.testing.assert_allclose(m["nodes/tip/position"][:, 2], expected, atol=1e-4)  # measured 7.5e-5 m
    balance = m["energy/balance"]
    assert np.ptp(balance) < 1e-3 * m["energy/potential"].max()
