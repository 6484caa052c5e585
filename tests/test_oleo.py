"""Oleo-pneumatic struts compared with SciPy and closed forms."""

import numpy as np
import pytest
from equilibria import Equilibrium
from scipy.integrate import solve_ivp
from scipy.interpolate import PchipInterpolator
from scipy.optimize import brentq
from time_runs import INPUTS, RecordedRun, input_deck

from mecano.analyses.dynamic import run
from mecano.analyses.operating_point import operating_point
from mecano.analyses.prepare import prepare, warnings_of
from mecano.errors import DeckError
from mecano.results.reader import open_results
from mecano.solve.modal.linearize import linearize

G, M, M_AXLE, AREA, LENGTH = 9.81, 1000.0, 40.0, 4e-3, 0.8
P1, V1, N, P2, V2, P_A = 1.2e6, 1.45e-3, 1.2, 4e6, 1.5e-4, 101325.0
COMPRESSED, DRAG = 1.4e9 * AREA**2 / 1.5e-3, 860.0 * AREA**3 / (2 * 0.7**2)
ORIFICE = PchipInterpolator([0, 0.1, 0.3], [1.3e-4, 1.1e-4, 0.6e-4])
OPENS = V1 / AREA * (1 - (P1 / P2) ** (1 / N))


def gas_pressure(s):
    """Absolute pressure of both chambers; they hold the same gas from the pressure P2 on."""
    first = P1 * (V1 / (V1 - AREA * s)) ** N
    both = V1 * (P1 / P2) ** (1 / N) + V2
    return np.where(s < OPENS, first, P2 * (both / (V1 + V2 - AREA * s)) ** N)


def flow_speed(F, s):
    """Speed of the piston at which the orifice holds the force F: DRAG/A^2 (|u| + u_0) u = F."""
    area = float(ORIFICE(np.clip(s, 0, 0.3))) if F > 0 else 0.6e-4
    return np.sign(F) * (np.sqrt(0.25e-6 + abs(F) * area**2 / DRAG) - 0.5e-3)


def drop(t, y):
    """Equations of inputs/oleo_drop.yaml."""
    z, z_axle, v, v_axle, oil = y
    s, s_rate = LENGTH - z + z_axle, v_axle - v
    stop = 5e6 * min(s, 0.0) * max(1 - s_rate, 0.0)
    push = (gas_pressure(s) - P_A) * AREA + COMPRESSED * oil + stop
    tyre = 3e5 * (0.3 - z_axle) - 500 * v_axle
    return [v, v_axle, push / M - G, (tyre - push) / M_AXLE - G, s_rate - flow_speed(COMPRESSED * oil, s)]


def test_drop_test_of_second_order():
    """Stroke and compression of the oil; measured 6.3e-7 and 1.5e-7 m, 1e-8 of them from the reference."""
    reference = solve_ivp(drop, (0, 0.5), [1.10088, 0.3, -3, -3, 0], "Radau", rtol=1e-9, atol=1e-11,
                          max_step=1e-3, dense_output=True)  # fmt: skip
    errors = []
    for step in (2e-4, 1e-4):
        m = RecordedRun(input_deck("oleo_drop", "time.end=0.5", f"time.step={step}"))
        z, z_axle, _, _, oil = reference.sol(m.time)
        errors.append(np.abs(m["elements/strut/stroke"] - (LENGTH - z + z_axle)).max())
        assert np.abs(m["elements/strut/oil_compression"] - oil).max() < 3e-8
        assert np.abs(m["elements/strut/gas_pressure"] / gas_pressure(LENGTH - z + z_axle) - 1).max() < 1e-4
    assert errors[0] < 8e-7 and 3.3 < errors[0] / errors[1] < 5
    assert m["energy/balance"] == pytest.approx(m["energy/balance"][0], abs=2e-6 * m["energy/dissipated"][-1])


def test_it_rests_where_the_gas_carries_the_weight():
    """The weight is the load of the static path; the strut begins at its stop."""
    text = (INPUTS / "oleo_drop.yaml").read_text().partition("initial:")[0].replace("-9.81]", "0]")
    push = "loads: {weight: {type: force, node: airframe, direction: [0, 0, -1], value: 9810}}"
    end = Equilibrium(f"{text}\n{push}\nstatic: {{steps: 20}}\n")
    stroke = brentq(lambda s: (gas_pressure(s) - P_A) * AREA - M * G, 0, 0.3)
    assert end.output("elements/strut/stroke")[0] == pytest.approx(stroke, rel=1e-8)  # tolerance of the equilibrium
    assert end.output("elements/strut/oil_pressure")[0] == pytest.approx(M * G / AREA + P_A, rel=1e-8)


@pytest.mark.parametrize(("rate", "u_0"), [(0.0, 1e-3), (1e-12, 1e-3), (-1e-12, 1e-3), (0.0, 4e-4)])
def test_small_motions_about_rest_are_damped_by_the_mean_of_both_orifices(rate, u_0):
    """The damping of the airframe is u_0 times the mean of DRAG/A^2, whatever the sign of a rounded speed."""
    base = operating_point(input_deck("oleo_drop", "initial=static", f"elements.strut.oil.laminar_speed={u_0}"))
    system, s = base.prepared.system, base.state
    i = [node.name for node in system.nodes].index("airframe")
    z = system.numbering.x[i] + 2
    stroke = LENGTH - s.z[z] + s.z[system.numbering.x[[n.name for n in system.nodes].index("axle")] + 2]
    s.v[z] = rate
    lin = linearize(system, s, base.prepared.length, assemble=base.assemble)
    mean = 0.5 * DRAG * (float(ORIFICE(stroke)) ** -2 + 0.6e-4**-2)
    assert lin.C[z, z] == pytest.approx(u_0 * mean, rel=1e-8)  # 1e-12 m/s change it by 1e-9


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ("elements.strut.second_gas.pressure=1 MPa", "higher than 'gas.pressure'"),
        ("elements.strut.oil.rebound_orifice=0", "'oil.rebound_orifice' must have areas greater than zero"),
        (
            "elements.strut.oil.orifice={table: {points: [[0, 1.3e-4], [0.1, 1.0e-4], [0.3, 0]]}}",
            "'oil.orifice' must have areas greater than zero",
        ),
        (
            "elements.strut.extended_length=800",
            "it starts at a stroke of 799.199 m, .* all gas is used up at 0.4 m",
        ),
        ("elements.strut.gas.volume=0", "must be greater than zero"),
        ("nodes.airframe.position=[0, 0, 0.3]", "same place"),
    ],
)
def test_what_is_refused(change, text):
    with pytest.raises(DeckError, match=text):
        input_deck("oleo_drop", change)


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ("elements.strut.gas.pressure=0.9 bar", "'gas.pressure' is 90000 Pa, less than the 101325 Pa of the air"),
        ("elements.strut.gas.volume=0.5e-3", "the stop is at a stroke of 0.3 m, but all gas is used up at"),
        ("elements.strut.oil.rebound_orifice=60", "an orifice has 60 m2, not less than"),
        ("elements.strut.extended_length=0.6", "it starts 0.201 m longer than its 'extended_length', 0.6 m: beyond"),
        ("elements.strut.gas.volume=1.45", "the whole stroke of 0.3 m compresses the gas by 0.00083 of its volume"),
        ("elements.strut.law.stop={stiffness: 5.0e6, lower: 0, upper: 0.3}",
         "its stop at 'lower' = 0 prevents all compression, in which"),
        ("elements.strut.oil.orifice={table: {points: [[0, 1.3e-4], [300, 6.0e-5]]}}",
         "an orifice is given up to a stroke of 300 m, of a strut 0.8 m long; is it in mm?"),
        ("elements.strut.oil.orifice=1.0e-4", ""),
        ("elements.strut.oil.area=0.4", "'oil.area' is 0.4 m2 and 'gas.area' 0.004 m2: the same piston displaces oil"),
        ("elements.strut.oil.discharge_coefficient=0.8", ""),
        ("elements.strut.gas.exponent=12", "'gas.exponent' is 12: it lies between 1, isothermal, and 1.67"),
        ("elements.strut.second_gas.exponent=0.9", "'second_gas.exponent' is 0.9: it lies between 1, isothermal"),
    ],
)  # fmt: skip
def test_what_is_suspicious(change, text):
    found = warnings_of(prepare(input_deck("oleo_drop", change)))
    assert len(found) == bool(text) and all(f"oleo 'strut': {text}" in one for one in found)


def test_oil_that_would_cavitate_is_warned_of(tmp_path):
    """A rebound through a tenth of the orifice without a recoil chamber sucks the oil below zero pressure."""
    said = {}
    for name, area in (("wide", "0.6e-4"), ("narrow", "0.6e-5")):
        given = input_deck("oleo_drop", f"elements.strut.oil.rebound_orifice={area}", "time.end=0.6")
        run(given, tmp_path / f"{name}.h5")
        with open_results(tmp_path / f"{name}.h5") as results:
            said[name] = [text for text in results.warnings if "cavitates" in text]
    assert said["wide"] == []
    (text,) = said["narrow"]
    assert text.startswith("oleo 'strut': oil_pressure reached -") and text.endswith("a larger 'oil.rebound_orifice'")


def test_drop_test_of_an_airliner_against_curves_of_another_program():
    """Up to the opening of the second chamber at 0.0913 s; beyond, that program interpolates its separator."""
    t, stroke, force = np.genfromtxt(INPUTS / "nose_gear_drop.csv", delimiter=",", skip_header=4).T
    m = RecordedRun(input_deck("nose_gear_drop", "time.end=0.24"))
    found = {"stroke": 1e3 * m["elements/strut/stroke"], "force": 1e-3 * m["signals/tyres/value"]}
    for published, values, within in ((stroke, found["stroke"], 0.03), (force, found["force"], 0.06)):
        given = np.isfinite(published) & (t < 91.3)
        assert given.sum() >= 6
        assert np.interp(1e-3 * t[given], m.time, values) == pytest.approx(published[given], abs=within)
    assert found["stroke"].max() == pytest.approx(np.nanmax(stroke), rel=3e-3)
    assert found["force"].max() == pytest.approx(np.nanmax(force), rel=3e-3)


def test_two_chambers_of_unlike_gases_share_pressure_and_volume():
    """Without friction and flow the strut stores the work of its gas; both chambers follow from one pressure."""
    p_1, V_1, n_1, p_2, V_2, n_2 = 1.1e6, 3.63e-3, 1.1, 7.7e6, 1.7e-3, 1.3
    m = RecordedRun(input_deck("nose_gear_drop", "time.end=0.2"))
    s, p = m["elements/strut/stroke"], m["elements/strut/gas_pressure"]
    opened = p > p_2
    left = V_1 * (p_1 / p) ** (1 / n_1) + V_2 * (p_2 / p) ** (1 / n_2)
    assert opened.sum() > 100
    assert left[opened] == pytest.approx(V_1 + V_2 - 0.011589 * s[opened], rel=1e-12)
    assert np.ptp(m["energy/balance"]) < 3e-6 * m["energy/dissipated"][-1]
