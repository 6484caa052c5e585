"""Messages of failed runs: time, worst equations, their elements, and advice."""

from collections.abc import Iterable
from typing import TypeVar

import numpy as np

from mecano.errors import AssemblyError, ConvergenceError, Failure, NonFiniteError, name_list
from mecano.model.assembly import Assembly
from mecano.model.model import length_scale
from mecano.model.numbering import LENGTH_CONSTRAINT, ROTATION, SCALAR, SIGNAL, TRANSLATION
from mecano.model.state import State
from mecano.model.system import System
from mecano.solve.diagnostics.scales import ANGULAR_SHARE
from mecano.solve.events.events import EventRecord
from mecano.solve.linear.rounding import TINY
from mecano.solve.time.step_info import StepInfo

Failed = TypeVar("Failed", bound=ConvergenceError | NonFiniteError)
REPORTED = 5  # equations reported, the worst of each node, joint or element
UNITS = {TRANSLATION: " N", ROTATION: " N m"}  # of residuals
NEGLIGIBLE = 1e-3  # of the worst residual: smaller ones are not reported
MOST_NAMES = 6  # elements named of one equation
NEARLY_NULL = 1e-13  # added to the diagonal of a singular matrix of entries up to 1
MOVES = 0.1  # of the largest entry of a null vector: larger ones count as moving
TRY = {
    Failure.NOT_FINITE: "laws that stay finite near this state (tables and polynomials far beyond their data do not); "
    "a smaller time.step or time.adaptive, if the motion so far looks wrong",
    Failure.CONTRADICTION: "remove one of these constraints, or make their laws of time consistent; where a linkage "
    "comes to a flat or straight position, time.method: radau, which passes singular positions or names them; where "
    "rigid contacts meet two surfaces at their common edge, a law in one of them",
    Failure.SINGULAR: "a mass, an inertia or a stiffness where one is missing above; `mecano check` for mechanisms",
    Failure.NOT_CONVERGED: "a smaller time.step; a time.rho_inf of 0.9 or less, as near 1 errors of constraints "
    "grow (not of radau); laws without jumps near this state; `mecano check` for redundant constraints and mechanisms",
}


def no_step(
    system: System, assembly: Assembly, info: StepInfo, t: float, h: float
) -> ConvergenceError | NonFiniteError:
    """Return the error of a step from ``t`` that fails even with the size ``h`` [s], naming the worst equations.

    ``assembly`` is that of the last iteration.
    """
    force, constraint, increment = info.norms
    worst = undetermined(system, assembly) if info.failure is Failure.SINGULAR else ""
    rows = [] if worst else worst_rows(system, assembly)
    if rows:
        worst = f"worst equations:\n{worst_equations(system, assembly)}"
    error = (NonFiniteError if info.failure is Failure.NOT_FINITE else ConvergenceError)(
        f"no step could be taken at t = {t:.9g} s; the last try was h = {h:.3g} s: {info.message}\n"
        f"over their tolerances: forces {force:.3g}, constraints {constraint:.3g}, increments {increment:.3g}\n"
        + (f"{worst}\n" if worst else "")
        + f"what to try: {TRY[info.failure]}"
    )
    return of_equations(error, system, rows)


def of_equations(error: Failed, system: System, rows: Iterable[int]) -> Failed:
    """Return the ``error`` with the elements that act in the equations of motion ``rows``, and all of their places."""
    error.elements = tuple(dict.fromkeys(title for i in rows for title in acting_elements(system, i)))
    moving = [i for i in rows if i < system.n_q]
    own = [system.numbering.name[i].place for i in moving]
    error.places = tuple(dict.fromkeys([*own, *(place for i in moving for place in _joined_to(system, i))]))
    return error


def no_restart(error: AssemblyError, t: float) -> ConvergenceError:
    """Return the error of a restart that failed at ``t`` after an event: cause, and what to try."""
    text = str(error) if error.timed else f"at t = {t:.9g} s {error}"
    return ConvergenceError(f"{text}\nwhat to try: {TRY[error.failure]}")


def not_finite(system: System, data: np.ndarray, t: float) -> NonFiniteError:
    """Return the error for non-finite ``data`` (n_data,) of the matrix of masses and constraints at ``t`` [s]."""
    rows = np.unique(system.rows[~np.isfinite(data[: len(system.rows)])])
    places = {system.numbering.name[i].place: i for i in rows[::-1]}
    lines = [f"  {system.numbering.name[i]}{acting_clause(system, i)}" for i in list(places.values())[::-1][:REPORTED]]
    text = "\n".join([f"at t = {t:.9g} s masses or constraints are not finite:", *lines])
    return NonFiniteError(f"{text}\nwhat to try: {TRY[Failure.NOT_FINITE]}")


def with_sources(error: NonFiniteError, system: System, s: State) -> NonFiniteError:
    """Return the NonFiniteError ``error`` with the elements whose own forces or tangents are not finite at ``s``.

    ``s`` is the last accepted state: later, one such element makes all others non-finite.
    """
    from mecano.model.each_element import elements_not_finite  # rarely needed

    found = elements_not_finite(system, s)
    if not found:
        return error
    first, _, rest = str(error).partition("\n")
    already = f"already not finite at t = {s.t:.9g} s: {name_list(found, MOST_NAMES)}"
    return NonFiniteError("\n".join(line for line in (first, already, rest) if line)).about(found)


def undetermined(system: System, assembly: Assembly) -> str:
    """Return as text the motions and reactions that the singular tangent of an assembly leaves undetermined.

    They form the null vector of the tangent excited by the residual, a line for each node, joint or element; "" if
    there is none.
    """
    from mecano.solve.linear.scaled_superlu import (
        ScaledSuperLU,  # no ordinary run needs it (docs/architecture.md, Start)
    )

    n, of = system.n, system.numbering
    places: dict[str, int] = {}  # place -> the equation where it moves most
    try:
        matrix = ScaledSuperLU(n, system.rows, system.cols, assembly.data[: len(system.rows)], NEARLY_NULL)
        x = np.abs(matrix.driven_null_vector(assembly.residual[:n]))
    except (RuntimeError, ValueError):  # still exactly singular, or not finite
        return ""
    if not np.isfinite(x).all():
        return ""
    for i in np.argsort(-x, kind="stable"):
        if x[i] >= MOVES * x.max():
            places.setdefault(of.name[i].place, i)
    lines = (f"  {of.name[i].motion}{acting_clause(system, i)}" for i in list(places.values())[:REPORTED])
    return "nothing resists:\n" + "\n".join(lines)


def worst_rows(system: System, assembly: Assembly) -> list[int]:
    """Return the indices of the worst equations of an assembly, one for each node, joint or element."""
    of, r = system.numbering, np.abs(assembly.residual[: system.n])
    with np.errstate(all="ignore"):
        relative = np.nan_to_num(r / _scales(system, assembly.size)[of.kind[: system.n]], nan=np.inf, posinf=np.inf)
    least = max(NEGLIGIBLE * relative.max(initial=0.0), TINY)
    places: dict[str, int] = {}  # place -> its worst equation
    for i in np.argsort(-relative, kind="stable"):
        if relative[i] >= least:
            places.setdefault(of.name[i].place, i)
    return list(places.values())[:REPORTED]


def worst_equations(system: System, assembly: Assembly) -> str:
    """Return the names and residuals of the worst equations of an assembly, with the elements acting in them."""
    of, r = system.numbering, np.abs(assembly.residual)
    return "\n".join(
        f"  {of.name[i]}: residual {r[i]:.3g}{UNITS.get(of.kind[i], '')}{acting_clause(system, i)}"
        for i in worst_rows(system, assembly)
    )


def _scales(system, size):
    """Return the scales (7,) of residuals of each kind of equation, as in ``norms``; constraints count as forces."""
    kind, length = system.numbering.kind, length_scale(system.nodes)
    force, moment, own = (max(size[kind == one].max(initial=0.0), TINY) for one in (TRANSLATION, ROTATION, SCALAR))
    f, m = max(force, ANGULAR_SHARE * moment / length), max(moment, ANGULAR_SHARE * force * length)
    scales = np.full(7, m / length**2)
    scales[[TRANSLATION, ROTATION, SCALAR, LENGTH_CONSTRAINT]] = f, m, max(own, ANGULAR_SHARE * f), f
    return scales


def acting_elements(system: System, i: int) -> list[str]:
    """Return the titles of the elements that act on the unknown ``i``; empty for a constraint."""
    if i >= system.n_q:
        return []
    found = dict.fromkeys(
        name
        for batch in system.batches
        if batch.kind.acts
        for name, dofs in zip(batch.names, batch.dofs, strict=True)
        if i in dofs
    )
    return list(found)


def acting_clause(system: System, i: int) -> str:
    """Return a clause naming the elements that act on the unknown ``i``; "" for a constraint."""
    names = acting_elements(system, i)
    if not names:
        return ""
    return f"; on it act {name_list(names, MOST_NAMES)}"


def minimum_step(
    system: System, before: np.ndarray, after: np.ndarray, error: float, t: float, h: float, rounded: bool
) -> ConvergenceError:
    """Return the error of a step of the least size ``h`` [s] whose local error is ``error`` times the allowed one.

    ``before`` and ``after`` (n_all,) are the algorithmic accelerations that the estimate compares. ``rounded``: the
    local error is less than the rounding of positions.
    """
    worst = _changing_most(system, (after - before)[: system.n_q])
    where = system.numbering.name[worst].motion
    what, smaller = "", "a smaller time.adaptive.minimum_step; a larger time.adaptive.tolerance; "
    if rounded:
        what = ", although it is less than the rounding of positions"
        smaller = "a larger time.adaptive.tolerance; a shorter run, whose fewer steps share it; time.method: radau; "
    failed = ConvergenceError(
        f"at t = {t:.9g} s a step of {h:.3g} s, the smallest allowed, has {error:.3g} times the allowed error{what}\n"
        f"the acceleration changes most in {where}{acting_clause(system, worst)}\n"
        f"what to try: {smaller}laws without jumps near this state; a fixed step, if the mechanism passes a singular "
        "position"
    )
    return of_equations(failed, system, [worst])


def _joined_to(system, i):
    """Return the places of the unknowns on which the elements that act on the unknown ``i`` also act.

    A node without mass at the other end of a spring may be the cause of what happens to its mass.
    """
    for batch in system.batches:
        if batch.kind.acts:
            for dofs in batch.dofs[(batch.dofs == i).any(axis=1)]:
                yield from (system.numbering.name[d].place for d in dofs if d < system.n_q)


def _changing_most(system, change):
    """Return the index of the unknown whose ``change`` (n_q,) of acceleration dominates the error estimate.

    Signals, whose accelerations have other units, count only if nothing else changes.
    """
    kind = system.numbering.kind[: system.n_q]
    relative = np.abs(change) / np.where(kind == ROTATION, 1.0, length_scale(system.nodes))
    moving = np.where(kind >= SIGNAL, 0.0, relative)
    return int(np.argmax(moving if moving.any() else relative))


def friction_binds(system: System, i: int, t: float) -> ConvergenceError:
    """Return the error of a joint or contact, with the reaction of index ``i``, whose friction binds at ``t`` [s]."""
    place = system.numbering.name[i].place
    return ConvergenceError(
        f"cannot continue from t = {t:.9g} s: {place} binds: its friction grows faster with its reactions than the "
        "motion relieves them, so that rigid bodies have no acceleration, or several\n"
        "what to try: a smaller coefficient of friction; a longer guide; elasticity: a small body between guide and "
        "load, held by an elastic joint or a bushing; a law instead of a rigid contact"
    ).about([place])


def standstill(event: EventRecord, count: int, t: float) -> ConvergenceError:
    """Return the error of an ``event`` that recurs ``count`` times while time does not advance."""
    return ConvergenceError(
        f"time does not advance beyond t = {t:.9g} s: {event.element} had the event '{event.name}' ({event.before} -> "
        f"{event.after}) {count} times there\n"
        "what to try: a smaller time.step, if it has much damping; laws of this element without jumps; two levels of a "
        "switch; some damping at its stops; nodes a little farther from the boundary between two of its phases; for a "
        "wheel that cannot slip, a flexible one: without slip it may be able neither to stay on the ground nor to "
        "leave it; for a rigid contact that slides with much friction, a law in it"
    ).about([event.element])
