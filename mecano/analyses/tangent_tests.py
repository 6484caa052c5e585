"""Generic tests of the tangents of a kind against finite differences; see kind_tests.py."""

from collections.abc import Callable

import numpy as np
from scipy.spatial.transform import Rotation

from mecano.analyses.differences import STEP, difference, simple_difference
from mecano.analyses.kind_samples import K_SCALE, PENALTY, Instance, Local, elements
from mecano.element_interface import Kind


def check_tangents(kind: Kind) -> None:
    """Tangents are the derivatives of the force, which is the same where it is computed alone.

    Differences of second order suffice for most; otherwise those of fourth order decide.
    """
    for sample, instance in elements(kind):
        t, state = sample.motion.t, instance.local(sample.motion)
        f, *tangents = instance.force(t, state, K_SCALE, PENALTY)
        np.testing.assert_array_equal(instance.residual(t, state, K_SCALE, PENALTY), f)
        n = instance.kind.n_local
        end = n - len(instance.kind.multipliers) - len(instance.kind.coupled_multipliers)
        for array, tangent in enumerate(tangents):
            expected = np.zeros((n, n))
            for by in (simple_difference, difference):
                for column in range(n if array == 0 else end):
                    expected[:, column] = slope(instance, t, state, array, column, by)
                expected[:, end:] *= K_SCALE  # the multiplier in q is k lambda, that of the tangent lambda
                if np.all(_excess(tangent, expected, 1e-7) <= 0.0):
                    break
            close(tangent, expected, 1e-7, phase=sample.phase, of=instance.kind.name, tangent="KCM"[array])
        if instance.kind.residual is not None:
            masses, own = instance.inertia(t, state), np.diag(tangents[2])
            np.testing.assert_allclose(masses, own, 1e-12, err_msg="'inertia' must write the diagonal of the masses")


def slope(
    instance: Instance, t: float, state: Local, array: int, column: int, by: Callable[..., np.ndarray] = difference
) -> np.ndarray:
    """Return df/dq, df/dv or df/da for one unknown, (n_local,); ``by``: difference or simple_difference.

    Forces are affine in the accelerations, for which the difference of second order is exact.
    """

    def force(h):
        return instance.residual(t, displaced(instance, state, column, h, array), K_SCALE, PENALTY)

    return (simple_difference if array == 2 else by)(force, STEP)


def displaced(instance: Instance, state: Local, column: int, h: float, array: int) -> Local:
    """Return the local state with one unknown of q, v or a (``array`` 0, 1, 2) displaced, rotations materially."""
    q, v, a, R = (part.copy() for part in state)
    slot = column // 3
    layout = instance.kind.layout
    if array == 0 and slot < len(layout) and layout[slot][0] == "R":
        r = sum(name[0] == "R" for name in layout[:slot])
        increment = np.zeros(3)
        increment[column % 3] = h
        R[r] = R[r] @ Rotation.from_rotvec(increment).as_matrix()
    else:
        (q, v, a)[array][column] += h
    return q, v, a, R


def close(actual: np.ndarray, expected: np.ndarray, rtol: float, **labels: str) -> None:
    """Assert that arrays agree row by row, as the rows of a tangent have different units and magnitudes."""
    error = _excess(actual, expected, rtol)
    worst = np.unravel_index(np.argmax(error), error.shape)
    assert np.all(error <= 0.0), f"{labels} {worst}: {actual[worst]} instead of {expected[worst]}"


def _excess(actual, expected, rtol):
    """Return by how much each difference exceeds the tolerance; negative where values are close."""
    size = np.abs(expected).max(axis=-1, keepdims=True)
    return np.abs(actual - expected) - rtol * np.maximum(size, 1e-6 * size.max(initial=0.0)) - 1e-9
