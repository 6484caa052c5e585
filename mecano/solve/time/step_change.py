r"""Change of the step size between two steps of generalized-alpha, in one compiled call.

The history moves to where steps of the new size h keep it (docs/theory.md, 2.1): the accelerations along their slope,
then the constrained parts of accelerations and velocities by

.. math:: \begin{bmatrix} S & -k B^T \\ -k B & -k^2 c \end{bmatrix} \begin{bmatrix} \delta \\ \mu \end{bmatrix} =
   \begin{bmatrix} 0 \\ -k r \end{bmatrix}

with r (n_l,), by which rates or second rates of the constraints are to change, and the tangent S of steps so short that
masses dominate it, at the state between the steps. A longer step takes of the shift along the slope what its own
tangent resolves (modal_filter.py); the next step begins its iterations with the factor of this tangent if it keeps one
(refactorization.py).
"""

from mecano.jit.entry import Records, entry
from mecano.jit.kernel import kernel
from mecano.jit.memory import call, floats, integers
from mecano.maths.vector import cross, put, vec
from mecano.model.assembly_driver import assemble, constraint_derivatives, constraint_loops, tangent_loops
from mecano.model.numbering import ROTATION, SIGNAL
from mecano.model.state import Instant
from mecano.solve.events.compliance import OF_RATES, OF_RELEASED, RELEASED_COMPLIANCE
from mecano.solve.linear.newton import CONVERGED, OTHERWISE, soften_tangent
from mecano.solve.linear.refactorization import price
from mecano.solve.linear.sparse import ACCEPT_BELOW
from mecano.solve.time.increments import extrapolate, largest_change
from mecano.solve.time.stiff_members import follow_stiff_members, moves
from mecano.solve.time.workspace import (
    BEGIN,
    FORMER,
    STEP,
    TANGENT,
    TRIAL,
    UNCHANGED,
    copy_history,
    copy_state,
    history_of,
    in_own_axes,
    start_spins,
    state_of,
    system_of,
)

DIFFERENCE = 0.02  # of a step, for differences along the motion
JUMP = 10.0  # ratio of two such differences from which on one includes a jump; of t^2, t^3 from rest it is 3 and 7
METRIC = 1e-3  # of a step: for steps so much shorter the tangent is that of the masses, where there are any
TOO_FAST = 0.1  # of the accelerations lost to the filter: below, its error is all that it would bring
MOST = 0.1  # of the accelerations outside the filter that no slow motion explains: beyond, members vibrate
HERE, NEXT, AFTER, ALGORITHMIC = range(4)  # rows of ``derivatives``


@entry
def change_step(work: Records(STEP)):
    """Give BEGIN the history for steps of size ``next_h``; overwrites TANGENT and TRIAL.

    Another change before a step is made begins with the history before the first one.

    ``code`` is CONVERGED, or OTHERWISE if the fixed order of elimination does not factor a matrix, or if that is
    ``delegated``: the caller solves it with the right-hand side in ``residual``, adds one to ``factored``, and calls
    again. A change from the same state to a ``similar`` size has the same first matrix and the same mean stiffness.
    """
    w = work[0]
    if w.factored == 0:
        if w.changed:
            restore_history(w)
        else:
            keep_history(w)
        start_increments(w)
        w.h = w.next_h
        differentiate_constraints(w)
        if w.n_l and not close_velocity_gap(w):
            w.code = OTHERWISE
            return
    longer = w.known == 0 or w.h > w.last_h
    if w.factored <= 1:
        shift_velocities(w)
        shift_accelerations(w, longer)
        scale_differences(w, w.h / w.last_h)
        if longer and not factor_filter(w):
            w.factored, w.code = 1, OTHERWISE
            return
    if longer:
        add_resolved_part(w)
    else:
        scale_constraints(w, w.h, True)
    w.has = w.has if longer or w.delegated else 0
    w.factored, w.age, w.spent, w.code = 0, 1, price(w.n) + 1.0, CONVERGED


@kernel
def keep_history(w):
    """Keep the history before the change, with which an interrupted run is resumed."""
    copy_history(w, BEGIN, UNCHANGED)
    copy_state(w, TANGENT, FORMER)
    w.changed, w.last_h, w.last_stiffness = 1, w.h, w.stiffness
    w.last_age, w.last_has, w.last_spent = w.age, w.has, w.spent


@kernel
def restore_history(w):
    """Restore the history before the last change."""
    copy_history(w, UNCHANGED, BEGIN)
    copy_state(w, FORMER, TANGENT)
    w.h, w.stiffness = w.last_h, w.last_stiffness
    w.age, w.has, w.spent = w.last_age, w.last_has, w.last_spent


@kernel
def start_increments(w):
    """Make TANGENT the state BEGIN, from which the rotation increments of the next step are counted."""
    copy_state(w, BEGIN, TANGENT)
    start_spins(w, TANGENT)[:, :] = 0.0
    z = state_of(w, TANGENT).z
    kind = integers(w.kind, w.n_all)
    for i in range(w.n_q):
        if kind[i] == ROTATION:
            z[i] = 0.0


@kernel
def differentiate_constraints(w):
    """Evaluate the constraints at BEGIN, and along the motion at accelerations that are constant in space."""
    s, s_moved, rotation_dof = state_of(w, BEGIN), state_of(w, TRIAL), integers(w.rotation_dof, w.n_rotations)
    for row in range(3 if w.n_l else 0):
        dt = row * DIFFERENCE * w.h
        extrapolate(w, BEGIN, dt, TRIAL)
        for r in range(w.n_rotations):
            d = rotation_dof[r]
            put(s_moved.a, d, vec(s.a, d) - dt * cross(vec(s.v, d), vec(s.a, d)))
        evaluate_constraints(w, TRIAL, s_moved.a, row)


@kernel
def evaluate_constraints(w, which, a, row):
    """Write value, rate and second rate of all constraints at one of the states with accelerations ``a`` (n_all,)."""
    s = state_of(w, which)
    accelerated = Instant(s.t, s.z, s.v, a, s.R, s.phases, s.memory)
    constraint_derivatives(constraint_loops(w), system_of(w), accelerated, derivatives(w, row))


@kernel
def derivatives(w, row):
    """Return value, rate and second rate (n_l, 3) of the constraints in one of the rows."""
    return floats(w.derivatives + 24 * row * w.n_l, (w.n_l, 3))


@kernel
def jerk_rate(w, i):
    """Return d = -B q''', the change of the second rate of a constraint along the motion at constant accelerations.

    The difference of second order, or, where one of two differences is more than ten times the other, the smaller one:
    the second rate jumps within the other, as with the curvature of a profile.
    """
    here, next_, after = derivatives(w, HERE), derivatives(w, NEXT), derivatives(w, AFTER)
    first, second = next_[i, 2] - here[i, 2], after[i, 2] - next_[i, 2]
    change = 1.5 * first - 0.5 * second
    if abs(first) > JUMP * abs(second):
        change = second
    elif abs(second) > JUMP * abs(first):
        change = first
    return change / (DIFFERENCE * w.h)


@kernel
def close_velocity_gap(w):
    """Solve for r (n_l,) of the velocities, which steps keep off the constraints by O(h^2); return as ``factor``.

    Constraints on rates are exempt.
    """
    gap, here = floats(w.gap, w.n_l), derivatives(w, HERE)
    exact_rates = integers(w.exact_rates, w.n_l)
    for i in range(w.n_l):
        kept = w.error * w.h * w.h * jerk_rate(w, i)
        gap[i] = (0.0 if exact_rates[i] else kept) - here[i, 1]
    if w.similar:
        w.k = w.metric_k
    else:
        assemble_scaled(w, METRIC * w.h, False)
        w.metric_k = w.k
    put_gap(w)
    return factor(w)


@kernel
def assemble_scaled(w, h, as_given):
    """Assemble the matrix for steps of size h; its rows of constraints are scaled by the matrix without them.

    ``as_given``: by k and penalty of the deck, if it has them; they suit no matrix that masses dominate.
    """
    scale_constraints(w, h, as_given)
    assemble_at_tangent(w, 1.0, w.cC, w.cM)
    omit_feedback(w)
    soften_tangent(w, system_of(w)[0], 1.0)


@kernel
def omit_feedback(w):
    """Omit how the rates that constraints on velocities follow depend on velocities: they are known here."""
    data, feedback = floats(system_of(w)[0].data, w.nnz), integers(w.feedback, w.n_feedback)
    for i in range(w.n_feedback):
        data[feedback[i]] = 0.0


@kernel
def factor(w):
    """Factor the assembled matrix and solve it for the right-hand side; return whether the solution is accurate.

    False if ``delegated`` to the caller of ``change_step``.
    """
    if w.delegated:
        return False
    w.factorizations += 1
    results = floats(w.solve_results, 3)
    call(w.solve, w.solve_words, w.solve_results)
    w.usable = 1 if results[2] <= ACCEPT_BELOW else 0
    return w.usable == 1


@kernel
def scale_constraints(w, h, as_given):
    """Set the scales and compliances of the constraints for the mean stiffness of the tangent of steps of size h."""
    w.cC, w.cM = w.gamma / (w.beta * h), (1 - w.am) / (1 - w.af) / (w.beta * h * h)
    w.stiffness = w.similar_stiffness
    if not w.similar:
        w.k, w.penalty = 1.0, 0.0
        assemble_at_tangent(w, 1.0, w.cC, w.cM)
        w.stiffness = mean_stiffness(w)
    w.k = w.fixed_k if as_given and w.fixed_k > 0.0 else w.stiffness
    w.penalty = w.fixed_penalty if as_given and w.fixed_penalty >= 0.0 else w.penalty_share * w.stiffness
    w.penalty = min(w.penalty, w.largest_penalty, w.stiffness * w.largest_penalty_share)
    set_compliances(w, h / w.h)


@kernel
def set_compliances(w, share):
    """Set the compliances for steps of a ``share`` of the step size (compliance.py).

    They fall as its square, like the mobility of the masses, so that no constraint is softer than in the step itself.
    """
    n = w.n_entries
    base, kinds, in_tangent = floats(w.soft_base, n), integers(w.soft_kinds, n), floats(w.soft_in_tangent, n)
    values, entries = floats(w.soft_values, n), floats(w.entry_values, n)
    for i in range(n):
        if kinds[i] == OF_RELEASED:
            values[i] = RELEASED_COMPLIANCE / w.stiffness * base[i]
        else:
            values[i] = (share / w.cC if kinds[i] == OF_RATES else share * share) * base[i]
        entries[i] = -w.k * w.k * values[i] * in_tangent[i]


@kernel
def mean_stiffness(w):
    """Return the mean stiffness [N/m] of the assembled tangent (scales.balance)."""
    s = system_of(w)[0]
    data, diagonal, kind = floats(s.data, s.n_data), integers(w.diagonal, w.n), integers(w.kind, w.n_all)
    total, number = 0.0, 0
    for i in range(w.n_q):
        size = abs(data[diagonal[i]])
        if size > 0.0:
            total += size / (w.length * w.length) if kind[i] == ROTATION else size
            number += 1
    return total / number if number else 1.0


@kernel
def assemble_at_tangent(w, cK, cC, cM):
    """Assemble a tangent of these weights at TANGENT, where rotation increments are zero."""
    assemble(tangent_loops(w), system_of(w), state_of(w, TANGENT), in_own_axes(w), w.k, w.penalty, cK, cC, cM)


@kernel
def put_gap(w):
    """Write the right-hand side (0, -k r)."""
    b, gap = floats(w.residual, w.n_all), floats(w.gap, w.n_l)
    for i in range(w.n_q):
        b[i] = 0.0
    for i in range(w.n_l):
        b[w.n_q + i] = -w.k * gap[i]


@kernel
def shift_velocities(w):
    """Write the correction of the velocities, from the solution for their gap."""
    shift, x = floats(w.v_shift, w.n_all), floats(w.increment, w.n)
    shift[:] = 0.0
    for i in range(w.n_q if w.n_l else 0):
        if moves(w, i):
            shift[i] = x[i]


@kernel
def shift_accelerations(w, longer):
    """Move the algorithmic accelerations along their slope; ``added``: the part that a longer step may not resolve."""
    a, slope, _ = history_of(w, BEGIN)
    true, more, kind = state_of(w, BEGIN).a, floats(w.added, w.n_all), integers(w.kind, w.n_all)
    for i in range(w.n_all):
        shifts = i < w.n_q and kind[i] != SIGNAL
        added = (w.am - w.af) * (w.h / w.last_h - 1.0) * slope[i] if shifts else 0.0
        if w.known == 0:  # no step has been made: as at a start
            a[i], added = 0.0, true[i]
        elif not longer:
            a[i] += added
        more[i] = a[i] + added
    for whole in range(2 if longer else 1):
        project(w, more if whole else a)
    for i in range(w.n_q):
        more[i] -= a[i]


@kernel
def project(w, a):
    """Move accelerations ``a`` (n_all,) to where the second rates of the constraints are -(am - af) h d."""
    if w.n_l == 0:
        return
    evaluate_constraints(w, BEGIN, a, ALGORITHMIC)
    gap, found = floats(w.gap, w.n_l), derivatives(w, ALGORITHMIC)
    for i in range(w.n_l):
        gap[i] = -(w.am - w.af) * w.h * jerk_rate(w, i) - found[i, 2]
    put_gap(w)
    call(w.substitute, w.substitute_words, 0)
    x = floats(w.increment, w.n)
    for i in range(w.n_q):
        if moves(w, i):
            a[i] += x[i]


@kernel
def factor_filter(w):
    """Solve the effective tangent for cM M ``added`` (modal_filter.py); return the same as ``factor``."""
    more, b, kept = floats(w.added, w.n_all), floats(w.residual, w.n_all), floats(w.added + 16 * w.n_all, w.n)
    times_masses(w, more, kept)
    assemble_scaled(w, w.h, True)
    for i in range(w.n):
        b[i] = w.cM * kept[i]
    return factor(w)


@kernel
def add_resolved_part(w):
    """Add the filtered ``added`` to the accelerations, or all of it if no part is too fast for the steps.

    At a start, the accelerations that stiff members need to follow a slow motion are added, too, if they explain nearly
    all that the filter leaves out.
    """
    a, x, more = history_of(w, BEGIN)[0], floats(w.increment, w.n), floats(w.added, w.n_all)
    none, resolved = floats(w.added + 8 * w.n_all, w.n_all), floats(w.added + 16 * w.n_all, w.n)
    lost = left_out(w, x)
    allowed = TOO_FAST * largest_change(none, more, integers(w.kind, w.n_all), w.n_q, w.length)
    filtered = lost > allowed
    for i in range(w.n):
        resolved[i] = x[i]
    if filtered and w.known == 0 and follow_stiff_members(w, a):
        for i in range(w.n):
            x[i] = resolved[i] - x[i]
        unexplained = left_out(w, x)
        if unexplained < MOST * lost:
            resolved, filtered = x, unexplained > allowed
    for i in range(w.n_q):
        a[i] += resolved[i] if filtered else more[i]


@kernel
def left_out(w, part):
    """Return the largest of ``added`` without its ``part`` (n,), into which unknowns that do not move are copied."""
    more, kind = floats(w.added, w.n_all), integers(w.kind, w.n_all)
    for i in range(w.n_q):
        if not moves(w, i):
            part[i] = more[i]
    return largest_change(part, more, kind, w.n_q, w.length)


@kernel
def times_masses(w, x, out):
    """Write M x (n,), zero for the multipliers; M of trials from one state is assembled once."""
    data, rows, columns = floats(system_of(w)[0].data, w.nnz), integers(w.rows, w.nnz), integers(w.columns, w.nnz)
    kept = floats(w.masses, w.nnz) if w.delegated else data
    if not (w.delegated and w.masses_kept):
        assemble_at_tangent(w, 0.0, 0.0, 1.0)
        for i in range(w.nnz if w.delegated else 0):
            kept[i] = data[i]
        w.masses_kept = 1
    for i in range(w.n):
        out[i] = 0.0
    for i in range(w.nnz):
        if rows[i] < w.n_q and columns[i] < w.n_q:
            out[rows[i]] += kept[i] * x[columns[i]]


@kernel
def scale_differences(w, ratio):
    """Scale slope and bend, the differences over a step, to the new size."""
    _, slope, bend = history_of(w, BEGIN)
    for i in range(w.n):
        scaled = ratio * ratio * bend[i]
        slope[i] = ratio * (slope[i] + 0.5 * bend[i]) - 0.5 * scaled
        bend[i] = scaled
