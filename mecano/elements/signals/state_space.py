r"""Linear systems: a plant, a filter or a controller in state space, or as a transfer function.

.. math::  \dot x = A x + B u, \qquad y = C x + D u

with several inputs u and one value y. ``transfer_function`` has one input,

.. math::  \frac{y(s)}{u(s)} = \frac{b_0 + b_1 s + ... + b_m s^m}{a_0 + a_1 s + ... + a_n s^n}, \qquad m \le n,

in controllable canonical form; coefficients are in ascending powers of s. The states are zero at the start.
"""

from dataclasses import replace
from functools import cache

import numpy as np

from mecano.constraints.along_coordinate.signal import IN_DECK, INPUT, UNIT_OF_VALUE, VALUE
from mecano.element_interface import Kind, Output, record
from mecano.jit.kernel import kernel
from mecano.schema import FORMULA, NUMBERS, ROWS, Field, list_of

MOST_COEFFICIENTS = 101  # of a polynomial: roots of higher ones depend on the rounding of the coefficients

STATE = Output("state_1", "SI", "state of the system, one for each: x_1, x_2...")
RECORD = record(n="i", m="i", table="i")
"""Numbers of states and of inputs; start of the rows of [A B] in the table of laws, followed by the row [C D]."""


@kernel
def _subtract_row(p, at, i, row, f, K):
    """Subtract row i of [A B; C D] times states and inputs from an equation."""
    width = p.n + p.m
    for j in range(width):
        factor = at.laws[p.table + i * width + j]
        f[row] -= factor * at.q[1 + j]
        K[row, 1 + j] -= factor


@kernel
def force(p, at, f, K, C, M):
    """Add the equations of the value and of all states; dual numbers would take n passes over n^2 numbers."""
    f[0] += at.q[0]
    K[0, 0] += 1.0
    _subtract_row(p, at, p.n, 0, f, K)
    for i in range(p.n):
        f[1 + i] += at.v[1 + i]
        C[1 + i, 1 + i] += 1.0
        _subtract_row(p, at, i, 1 + i, f, K)


@kernel
def observe(p, at, F, y, e):
    """Write the value and all states."""
    for i in range(p.n + 1):
        y[i] = at.q[i]


def _packed(A, B, C, D, context):
    n, m = B.shape
    return {"n": n, "m": m, "table": context.laws.append(np.block([[A, B], [C, D]]))}


def canonical(d):
    """Return A, B, C, D of a transfer function in controllable canonical form."""
    a, b = np.array(d["denominator"], float), np.array(d["numerator"], float)
    n = len(a) - 1
    a, b = a / a[-1], np.pad(b, (0, n + 1 - len(b))) / a[-1]
    A = np.eye(n, k=1)
    A[n - 1 :] = -a[:n]
    B = np.zeros((n, 1))
    B[n - 1 :] = 1.0
    return A, B, (b[:n] - b[n] * a[:n])[None, :], np.array([[b[n]]])


def matrices_of(d):
    """Return A, B, C, D of a system in state space; D is zero when absent."""
    B = np.array(d["B"], float)
    C = np.array(d["C"], float)[None, :]
    D = np.zeros((1, B.shape[1])) if d["D"] is None else np.array(d["D"], float)[None, :]
    return np.array(d["A"], float), B, C, D


def check_space(d, nodes):
    """Return errors for matrices of inconsistent shapes."""
    A, B, C, D = matrices_of(d)
    n, m, found = len(A), len(d["inputs"]), []
    if A.shape != (n, n):
        found.append(f"'A' must be square; it has {A.shape[0]} rows and {A.shape[1]} columns")
    if B.shape != (n, m):
        found.append(f"'B' must have {n} rows, as many as 'A', and {m} columns, one for each input")
    if C.shape[1] != n:
        found.append(f"'C' must have {n} numbers, one for each state")
    if D.shape[1] != m:
        found.append(f"'D' must have {m} numbers, one for each input")
    return found


def check_transfer(d, nodes):
    """Return errors for polynomials that are no proper transfer function."""
    a, b = d["denominator"], d["numerator"]
    if len(a) < 2 or a[-1] == 0.0:
        return ["'denominator' must have two coefficients or more, the last one not zero"]
    if len(a) > MOST_COEFFICIENTS:
        return [f"'denominator' has {len(a)} coefficients; {MOST_COEFFICIENTS} are allowed: use 'state_space'"]
    if not b or len(b) > len(a):
        return ["'numerator' must have at least one coefficient and at most as many as 'denominator'"]
    return []


@cache
def _of_size(kind, n, m):
    """Return the ``kind`` with n states and m inputs."""
    states = tuple(f"state_{i}" for i in range(1, n + 1))
    return replace(
        kind, variant=None, scalars=("value", *states), states=states,
        inputs=tuple(f"input_{i}" for i in range(1, m + 1)),
        outputs=(VALUE, *(replace(STATE, name=state) for state in states)),
    )  # fmt: skip


SHARED = {
    **IN_DECK, "doc": __doc__, "dtype": RECORD, "force": force, "outputs": (VALUE, STATE), "observe": observe,
}  # fmt: skip
STATE_SPACE = Kind(
    name="state_space",
    fields=(
        Field("inputs", list_of(FORMULA), "-", "formulas of the inputs u"),
        Field("A", ROWS, "-", "rows of A"),
        Field("B", ROWS, "-", "rows of B"),
        Field("C", NUMBERS, "-", "the row C, one number for each state"),
        Field("D", NUMBERS, "-", "the row D, one number for each input; zero when absent", None),
        UNIT_OF_VALUE,
    ),
    prepare=lambda d, nodes, context: _packed(*matrices_of(d), context),
    check=check_space,
    reads=lambda d: d["inputs"],
    smooths=lambda d: not any(d["D"] or ()),
    variant=lambda d: _of_size(STATE_SPACE, len(d["A"]), len(d["inputs"])),
    cases=(
        {"inputs": ["a", "b"], "A": [[-1.0, 0.3], [0.2, -2.0]], "B": [[1.0, 0.5], [0.0, 2.0]], "C": [0.7, 0.4],
         "D": [0.1, 0.2]},
        {"inputs": ["a"], "A": [[1.0, 2.0, 0.3], [0.2, -1.0, 0.0], [0.5, 0.1, -2.0]], "B": [[1.0], [0.0], [2.0]],
         "C": [1.0, 2.0, 3.0]},
    ),
    **SHARED,
)  # fmt: skip
TRANSFER_FUNCTION = Kind(
    name="transfer_function",
    fields=(
        INPUT,
        Field("numerator", NUMBERS, "-", "coefficients in ascending powers of s"),
        Field("denominator", NUMBERS, "-", "coefficients in ascending powers of s"),
        UNIT_OF_VALUE,
    ),
    prepare=lambda d, nodes, context: _packed(*canonical(d), context),
    check=check_transfer,
    reads=lambda d: [d["input"]],
    smooths=lambda d: len(d["numerator"]) < len(d["denominator"]),
    variant=lambda d: _of_size(TRANSFER_FUNCTION, len(d["denominator"]) - 1, 1),
    cases=(
        {"numerator": [2.0, 0.5, 0.3], "denominator": [4.0, 2.0, 0.5]},
        {"numerator": [1.0], "denominator": [1.0, 0.2]},
    ),
    **SHARED,
)
