"""Newton's iteration converges quadratically with the tangents of wheels, in every regime of a drop."""

import numpy as np
import pytest
from test_flexible_wheel import DROP, LATERAL
from time_runs import deck, in_python, input_deck

from mecano.analyses.initial_state import set_initial_state
from mecano.analyses.prepare import integrator_of, prepare
from mecano.solve.linear.newton import FIRST, ITERATIONS, TOO_MANY, WORST
from mecano.solve.time import generalized_alpha
from mecano.solve.time.step import attempt

TIGHT = "newton: {force_tolerance: 1.0e-13, constraint_tolerance: 1.0e-13}"
ROUNDING = 10.0  # of the tolerance: residuals below are rounding
NEAR = 0.05  # residuals fall by more than that where the iteration is near the solution


def residuals(checked, monkeypatch):
    """Residuals (over their tolerance) of each attempt of a run, with a new tangent for every correction."""
    prepared = prepare(checked)
    set_initial_state(prepared)
    integrator, attempts = integrator_of(prepared), []

    def corrected(record):
        """Iterate once at a time: each begins with a new tangent."""
        most, report = int(record["most"][0]), integrator.method.workspace.report
        record["has"], record["most"], found = False, 1, []
        while True:
            attempt(record)
            found += [report[WORST]] if found else [report[FIRST], report[WORST]]
            if record["code"][0] != TOO_MANY or len(found) > most:
                break
            report[ITERATIONS], record["stale"], record["pending"] = 0, True, False
        record["most"] = most
        attempts.append(np.array(found))

    monkeypatch.setattr(generalized_alpha, "attempt", corrected)
    times = checked.values["time"]
    in_python(integrator)
    integrator.to(times["end"], integrator.begin(prepared.state, times["step"]))
    return attempts


def orders(found):
    """log(r2/r1)/log(r1/r0) of the last three residuals above rounding, of attempts that come near the solution."""
    for r in found:
        r = r[r > ROUNDING]
        if len(r) >= 3 and r[-2] < NEAR * r[-3] and r[-1] < NEAR * r[-2]:
            yield np.log(r[-1] / r[-2]) / np.log(r[-2] / r[-3])


CASES = {
    "flexible": lambda: deck(
        DROP.format(kind="flexible_wheel", rough=1e-5, step=5e-3, control="rho_inf: 0.8, " + TIGHT, lateral=LATERAL)
    ),
    "adhesive": lambda: deck(
        DROP.format(kind="adhesive_wheel", rough=0, step=5e-3, control="rho_inf: 0.8, " + TIGHT, lateral=LATERAL)
    ),
    "rigid": lambda: input_deck("rolling_disc", f"time={{end: 0.5, step: 0.1, {TIGHT}}}"),
}


@pytest.mark.parametrize("case", CASES)
def test_newton_converges_quadratically(case, monkeypatch):
    measured = list(orders(residuals(CASES[case](), monkeypatch)))
    assert len(measured) >= 5 and np.median(measured) > 1.8
