"""Warn of controllers that make a mechanism unstable, from its modes at the start with and without signals."""

import math
from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from mecano.model.numbering import ROTATION

if TYPE_CHECKING:
    from mecano.analyses.prepare import Prepared
    from mecano.model.state import State
    from mecano.model.system import System
    from mecano.solve.modal.linearize import Linearization
    from mecano.solve.modal.sampled_system import Sampler
    from mecano.solve.time.run_state import RunState

DENSE = 100  # motions up to which all modes are computed before a run
MOST, NEAREST = 5000, 20  # motions of larger models whose run failed; number of modes nearest to zero
ROUNDED = 1e-9  # of the largest eigenvalue of signals: a smaller real part is rounding
SAMPLED = 200  # motions up to which samples are examined
UNCHANGED = 0.01  # relative change of an eigenvalue by the turns of the start that does not matter
BEGINNING = "because of the signals, small motions about the start grow"  # of the warning
GROWTH = 1e3  # growth of small motions in a run above which they are reported


def instability_warnings(prepared: "Prepared", start: "RunState", most: int = DENSE) -> Iterator[str]:
    """Yield a warning if small motions about the ``start`` of a run, a RunState, grow only because of its signals.

    Not reported are motions that grow by less than a factor of GROWTH in the run, those of models with more than
    ``most`` motions, or SAMPLED with samples, fast ones of models with more than DENSE motions, and motions about a
    moving state if no signal has a state, such as those of bodies that attract one another. Nor are motions slow beside
    the accelerations of the start, which turn axes and reactions while such motions would grow, unless they grow as
    fast after these turns: a wheel that spins up turns no other axis than its own. Values of delays count
    as constant, and those of sampled signals where a model has delays, more than SAMPLED motions, or periods without a
    common multiple.
    """
    system, time = prepared.system, prepared.deck.values["time"]
    moving = np.any(start.motion.v[: system.n_q][~system.signals])
    if not system.signals.any():
        return
    samplers = _samplers(prepared)
    if not samplers and (
        system.n_q > most or (moving and not system.states.any()) or not _may_destabilize(system, start.motion)
    ):
        return
    from mecano.solve.modal.linearize import linearize  # takes 0.1 s to import, with SciPy

    lin = linearize(system, start.motion, prepared.length, compliance=start.compliance)
    if not all(np.isfinite(matrix.data).all() for matrix in (lin.M, lin.C, lin.K)):
        return
    fastest, period = _closed_growth(lin, samplers)
    grows = (fastest.real - max(_largest_growth(_without_signals(lin)).real, 0.0)) * (time["end"] - time["start"])
    if not (fastest.real > lin.pace and grows > math.log(GROWTH)):
        return
    if abs(fastest) ** 2 > _turning(prepared, start) or _grows_after_turns(prepared, start, samplers, fastest):
        yield _grows(fastest, period)


def _grows(fastest: complex, period: float | None) -> str:
    """Return the warning of a growing eigenvalue; ``period`` [s]: the shortest of the samples; None without any."""
    as_what = f", as an oscillation of {abs(fastest.imag) / math.tau:.3g} Hz" if fastest.imag else ""
    question = "is a gain too large, or its sign wrong? `mecano modes` describes this motion"
    if period is not None:
        question = (
            f"is a gain too large, its sign wrong, or the sampling period of {period:.3g} s too long? "
            "`mecano margins --open-loop NAME` shows by how much"
        )
    return f"{BEGINNING} by the factor e in {1.0 / fastest.real:.3g} s{as_what}: {question}"


def causes_of_failure(prepared: "Prepared", start: "RunState", warnings: Iterable[str]) -> list[str]:
    """Return what a failure of a run from ``start`` says if its controllers are unstable there.

    ``warnings``: those of the start, where models with more than DENSE motions are not examined.
    """
    found = [text for text in warnings if text.startswith(BEGINNING)]
    if not found and prepared.system.n_q > DENSE:
        found = list(instability_warnings(prepared, start, MOST))
    return [f"warning: {text}. Growing motions need ever shorter steps: fix this first" for text in found]


def _samplers(prepared: "Prepared") -> "list[Sampler]":
    """Return the samplers of a model whose samples are examined, or none."""
    signals = prepared.deck.values["signals"].values()
    kinds = {d["type"] for d in signals}
    if "sample_and_hold" not in kinds or "delay" in kinds or prepared.system.n_q > SAMPLED:
        return []
    from mecano.analyses.samplers import samplers_of

    return list(samplers_of(prepared.deck, prepared.system).values())


def _closed_growth(lin: "Linearization", samplers: "list[Sampler]") -> tuple[complex, float | None]:
    """Return the eigenvalue with the largest real part: (that of the samples, their least period [s]), if it is known.

    Otherwise (that with constant held values, None).
    """
    if samplers:
        from mecano.solve.modal.sampled_system import sampled_system

        whole = sampled_system(lin, samplers)
        if not isinstance(whole, str):
            return max(whole.growing(), key=lambda s: s.real, default=0j), min(one.period for one in samplers)
    return _largest_growth(lin), None


def _may_destabilize(system: "System", s: "State") -> bool:
    """Return whether signals read the motion at ``s`` and act on it, or may grow by themselves: others only measure."""
    signal = np.append(system.signals, np.zeros(system.n_l, bool))
    reads, acts = signal[system.rows], signal[system.cols]
    K, C, M = (system.assemble(s, cK=k, cC=c, cM=m).data[: system.nnz].copy() for k, c, m in np.eye(3))
    feedback = all(any(part[where].any() for part in (K, C, M)) for where in (acts & ~reads, reads & ~acts))
    if feedback or M[acts & reads].any():
        return True
    own, blocks = np.cumsum(signal) - 1, np.zeros((2, signal.sum(), signal.sum()))
    for block, part in zip(blocks, (K, C), strict=True):
        block[own[system.rows[acts & reads]], own[system.cols[acts & reads]]] = part[acts & reads]
    return _may_grow(blocks[0], blocks[1], system.states[system.signals])


def _may_grow(K: np.ndarray, C: np.ndarray, states: np.ndarray) -> bool:
    """Return whether the signals of K y + C y' = 0 grow, or are no functions of the ``states`` (n,) bool among them."""
    others = ~states
    if C[others].any() or C[:, others].any():
        return True
    try:
        own = K[states][:, states] - K[states][:, others] @ np.linalg.solve(K[others][:, others], K[others][:, states])
        values = np.linalg.eigvals(-np.linalg.solve(C[states][:, states], own))
    except np.linalg.LinAlgError:
        return True
    return bool(values.real.max(initial=0.0) > ROUNDED * np.abs(values).max(initial=0.0))


def _turning(prepared: "Prepared", start: "RunState") -> float:
    """Return the largest acceleration [rad/s2] at the start: of rotations, and of displacements over the length scale.

    Accelerations turn the directions of constraints, by which squares of eigenvalues are uncertain by as much.
    """
    system = prepared.system
    lengths = np.where(system.numbering.kind[: system.n_q] == ROTATION, 1.0, prepared.length)
    return float(np.abs(start.motion.a[: system.n_q] / lengths)[~system.signals].max(initial=0.0))


def _grows_after_turns(prepared, start, samplers, fastest):
    """Return whether an eigenvalue does not change if the accelerations of the start move the model, as it grows.

    The time is that in which the motion grows by the factor e. Reactions are left out, which belong to the start.
    """
    from scipy.spatial.transform import Rotation

    from mecano.solve.modal.linearize import linearize

    system, moved = prepared.system, start.motion.unaccelerated()
    way = 0.5 * start.motion.a / abs(fastest) ** 2
    way[: system.n_q][system.signals] = 0.0
    moved.z[: system.n_q] += np.where(system.numbering.kind[: system.n_q] == ROTATION, 0.0, way[: system.n_q])
    moved.z[system.n_q : system.n_q + system.n_l] = 0.0
    turns = way[system.numbering.rotation_dof[:, None] + np.arange(3)]
    moved.R[:] = moved.R @ Rotation.from_rotvec(turns).as_matrix()
    lin = linearize(system, moved, prepared.length, compliance=start.compliance)
    if not all(np.isfinite(matrix.data).all() for matrix in (lin.M, lin.C, lin.K)):
        return False
    return abs(_closed_growth(lin, samplers)[0] - fastest) < UNCHANGED * abs(fastest)


def _largest_growth(lin: "Linearization") -> complex:
    """Return the eigenvalue of a Linearization with the largest real part, or 0 if none grows or none is found."""
    from mecano.errors import ConvergenceError
    from mecano.solve.modal.modes import solve

    number, method = (1, "dense") if lin.n_q <= DENSE else (NEAREST, "sparse")
    try:
        return max(solve(lin, number, method).values, key=lambda value: value.real, default=0j)
    except ConvergenceError:
        return 0j


def _without_signals(lin: "Linearization") -> "Linearization":
    """Return the Linearization in which all signals are constant."""
    motions = ~lin.signals
    keep = np.flatnonzero(np.concatenate([motions, np.ones(lin.K.shape[0] - lin.n_q, bool)]))
    M, C, K = (matrix.tocsr()[keep][:, keep] for matrix in (lin.M, lin.C, lin.K))
    return replace(
        lin, M=M, C=C, K=K, n_q=int(motions.sum()), groups=lin.groups[motions], root=lin.root[motions],
        signals=lin.signals[motions],
    )  # fmt: skip
