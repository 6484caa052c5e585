"""Zeros of functions: some of those of Chandrupatla's paper (Adv. Eng. Software 28, 1997), with known zeros."""

import math

import pytest

from mecano.maths.root import root

FUNCTIONS = {
    "cubic": (lambda x: x**3 - 2.0 * x - 5.0, 2.0, 3.0, 2.0945514815423265),  # Newton 1669
    "falling": (lambda x: 1.0 - 1.0 / x**2, 0.5, 2.0, 1.0),
    "flat": (lambda x: (x - 3.0) ** 3, 0.0, 5.0, 3.0),
    "far apart": (lambda x: 1.0 / (x - 3.0) - 6.0, 3.0 + 1e-9, 4.0, 3.0 + 1.0 / 6.0),
    "steep": (lambda x: math.tanh(1e6 * (x - 0.3)), -1.0, 1.0, 0.3),
    "jump": (lambda x: -1.0 if x < 0.1 else 1.0, 0.0, 1.0, 0.1),
    "at an end": (lambda x: x, 0.0, 1.0, 0.0),
}


@pytest.mark.parametrize("name", FUNCTIONS)
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_zeros(name, sign):
    f, low, high, zero = FUNCTIONS[name]
    calls = []

    def counted(x):
        calls.append(x)
        return sign * f(x)

    found = root(counted, low, high)
    assert low <= found <= high and isinstance(found, float)
    assert found == pytest.approx(zero, abs=1e-5 if name == "flat" else 1e-14)
    assert len(calls) <= 60 + 2  # bisection needs 53


def test_a_tolerance_saves_evaluations():
    counts = []
    for tolerance in (1e-3, 1e-12):
        calls = []
        found = root(lambda x, calls=calls: calls.append(x) or math.cos(x), 0.0, 3.0, tolerance)
        assert found == pytest.approx(0.5 * math.pi, abs=tolerance)
        counts.append(len(calls))
    assert counts[0] < counts[1] <= 12
