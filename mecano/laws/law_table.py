"""The flat table of all laws of a model, and the compiled functions that evaluate a law in it.

Layout from the start of a law: the number of its terms; then for each term its code, the count of its numbers,
and these numbers. The first entry of the table is 0.0: a law that starts there has no terms and is zero.
"""

import math
from array import array
from numbers import Real

import numpy as np

from mecano.jit.kernel import kernel
from mecano.laws import TERMS
from mecano.maths.dual import chain, value

CODES = {}  # name of a term -> its code in the table, that of all terms with the same functions


class LawTable:
    """Collects the laws of a model."""

    def __init__(self):
        self._numbers = array("d", [0.0])  # a list of Python's floats takes four times the memory

    def add(self, law):
        """Append a checked law, a number (a constant) or None (no law: 0); return its start in the table."""
        law = terms_of(law)
        if not law:
            return 0
        start = len(self._numbers)
        self._numbers.append(float(len(law)))
        for name, values in law:
            numbers = np.asarray(TERMS[name].numbers(values), float)
            self._numbers.extend((float(CODES[name]), float(len(numbers))))
            self._numbers.frombytes(numbers.tobytes())
        return start

    def append(self, numbers):
        """Append numbers that are not a law, for elements whose data exceed a record; return their start."""
        start = len(self._numbers)
        self._numbers.frombytes(np.asarray(numbers, float).tobytes())
        return start

    def array(self):
        """Return the table, (n,) float64, for the kernels."""
        return np.array(self._numbers)


def terms_of(law):
    """Return the terms of a law, which may also be a number or None (absent)."""
    if law is None:
        return ()
    return (("constant", {"value": law}),) if isinstance(law, Real) else law


def kinks(law):
    """Return the extensions (low, high) of the stops of a force law; -inf, inf if it has none.

    If there are several corners on one side, the stiffest one is returned.
    """
    corners = [corner for name, values in terms_of(law) for corner in TERMS[name].stops(values)]
    low = max((corner for corner in corners if corner[1] < 0), key=lambda c: -c[1], default=(-math.inf, 0))
    high = max((corner for corner in corners if corner[1] > 0), key=lambda c: c[1], default=(math.inf, 0))
    return low[0], high[0]


def breakpoints(law):
    """Return the arguments, ascending, at which a curve has a jump, a corner or the end of a smooth edge."""
    return sorted({float(x) for name, values in terms_of(law) for x in TERMS[name].breakpoints(values)})


def landmarks(law):
    """Return the arguments, ascending, at which adaptive steps end so that they do not pass over a pulse of a curve."""
    return sorted({float(x) for name, values in terms_of(law) for x in TERMS[name].landmarks(values)})


def chosen_by_code(functions, arguments, otherwise):
    """Return a compiled f(code, *arguments) that calls functions[code], or returns ``otherwise`` for an unknown code.

    It is generated as source: a flat chain of comparisons compiles in half the time of nested closures.
    """
    lines = [f"def choose(code, {arguments}):"]
    for code in functions:
        lines.append(f"    if code == {code}:\n        return term_{code}({arguments})")
    names = {f"term_{code}": function for code, function in functions.items()}
    names["otherwise"] = otherwise
    exec("\n".join([*lines, "    return otherwise"]), names)
    return kernel(names["choose"])


NANS = (math.nan, math.nan, math.nan)


def number_terms():
    """Give each term its code, and make the functions that choose among them by code.

    Called again when terms are registered, before the first law of the process is packed or compiled.
    """
    global LAST_CURVE, curve_term, force_term, integral_term
    functions: dict[str, dict[tuple, int]] = {"curve": {}, "force": {}}
    # curves first: one comparison then distinguishes a curve from a force
    for name, term in sorted(TERMS.items(), key=lambda item: item[1].role):
        alike, known = (term.evaluate, term.integral), functions[term.role]
        CODES[name] = known.setdefault(alike, 1 + sum(map(len, functions.values())))
    LAST_CURVE = len(functions["curve"])
    curves, forces = ({code: f for (f, _), code in functions[role].items()} for role in ("curve", "force"))
    integrals = {code: f for known in functions.values() for (_, f), code in known.items()}
    curve_term, force_term = chosen_by_code(curves, "a, i, s", NANS), chosen_by_code(forces, "a, i, s, v", NANS)
    integral_term = chosen_by_code(integrals, "a, i, s", math.nan)


number_terms()


@kernel
def evaluate_curve(laws, start, s):
    """Return (y, dy/ds, d2y/ds2) of the law at ``start``; nan if one of its terms is a force term."""
    y, d, h = 0.0, 0.0, 0.0
    i = start + 1
    for _ in range(int(laws[start])):
        y_i, d_i, h_i = curve_term(int(laws[i]), laws, i + 2, s)
        y, d, h = y + y_i, d + d_i, h + h_i
        i += 2 + int(laws[i + 1])
    return y, d, h


@kernel
def evaluate_force(laws, start, s, v):
    """Return (F, dF/ds, dF/dv) of the law at ``start`` for extension s [m or rad] and rate v; F [N or N m] > 0 pulls.

    Curves among its terms are functions of the extension.
    """
    F, F_s, F_v = 0.0, 0.0, 0.0
    i = start + 1
    for _ in range(int(laws[start])):
        code = int(laws[i])
        if code <= LAST_CURVE:
            F_i, s_i, _ = curve_term(code, laws, i + 2, s)
            v_i = 0.0
        else:
            F_i, s_i, v_i = force_term(code, laws, i + 2, s, v)
        F, F_s, F_v = F + F_i, F_s + s_i, F_v + v_i
        i += 2 + int(laws[i + 1])
    return F, F_s, F_v


@kernel
def curve(laws, start, s):
    """Return y of the law at ``start``; a Dual if s is one."""
    y, d, _ = evaluate_curve(laws, start, value(s))
    return chain(s, y, d)


@kernel
def curve_and_slope(laws, start, s):
    """Return y and dy/ds of the law at ``start``; Duals if s is one."""
    y, d, h = evaluate_curve(laws, start, value(s))
    return chain(s, y, d), chain(s, d, h)


@kernel
def law_force(laws, start, s, v):
    """Return F of the law at ``start`` [N or N m] for extension s and rate v; a Dual if s or v is one."""
    F, F_s, F_v = evaluate_force(laws, start, value(s), value(v))
    return chain(s, F, F_s) + chain(v, 0.0, F_v)


@kernel
def potential(laws, start, s):
    """Return U [J] with dU/ds = F(s, 0), up to a constant; continuous, and 0 at the origin of each term."""
    U = 0.0
    i = start + 1
    for _ in range(int(laws[start])):
        U += integral_term(int(laws[i]), laws, i + 2, s)
        i += 2 + int(laws[i + 1])
    return U
