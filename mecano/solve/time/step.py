"""One step of generalized-alpha in one compiled call: prediction, Newton's iterations, error estimate."""

from mecano.jit.entry import Records, entry
from mecano.jit.kernel import kernel
from mecano.jit.memory import floats, integers
from mecano.solve.linear.newton import CONVERGED, newton
from mecano.solve.linear.refactorization import choose_tangent
from mecano.solve.time.increments import finish, predict
from mecano.solve.time.workspace import BEGIN, STEP, TRIAL, copy_state, history_of, motion_of, time_of


@entry
def attempt(work: Records(STEP)):
    """Step from BEGIN to TRIAL, or continue the iterations if ``begun``; ``code`` reports the outcome."""
    w = work[0]
    if not w.begun:
        w.begun = 1
        begin(w)
    w.code = newton(w)
    if w.code == CONVERGED:
        complete(w)


@kernel
def begin(w):
    """Predict the state TRIAL, from the history or ``by_velocity`` alone, and begin the report on the iterations."""
    copy_state(w, BEGIN, TRIAL)
    time_of(w, TRIAL)[0] = time_of(w, BEGIN)[0] + w.h
    z0, v0, a0, R0 = motion_of(w, BEGIN)
    z, v, a, R = motion_of(w, TRIAL)
    kind, rotation_dof = tables(w)
    before, slope, bend = history_of(w, BEGIN)
    if w.by_velocity:
        # after a sudden load on stiff and light members the accelerations say little of displacements in a long step
        slope, bend = floats(w.guess, w.n), floats(w.guess + 8 * w.n, w.n)
        for i in range(w.n_q):
            a1 = (1.0 - 0.5 / w.beta) * before[i]
            slope[i] = ((1.0 - w.am) * a1 + w.am * before[i] - w.af * a0[i]) / (1.0 - w.af) - a0[i]
    w.reach = predict(
        w.am, w.af, w.beta, w.gamma, kind, rotation_dof, w.n_q, w.n, w.h,
        before, a0, slope, bend, floats(w.v_shift, w.n_all), R0, z, v, a, R,
    )  # fmt: skip
    floats(w.report, 8)[:] = 0.0
    w.pending = 0
    w.kept = 1 if w.has and not w.renewed else 0
    w.stale = 0 if w.kept and w.usable else 1


@kernel
def tables(w):
    """Return the kinds (n_all,) of the unknowns, and the first unknowns (n_rotations,) of the rotations."""
    return integers(w.kind, w.n_all), integers(w.rotation_dof, w.n_rotations)


@kernel
def complete(w):
    """Compute the history at TRIAL, the error measures, and whether the next step may keep the tangent."""
    z0, v0, a0, R0 = motion_of(w, BEGIN)
    z, v, a, R = motion_of(w, TRIAL)
    kind, rotation_dof = tables(w)
    before, slope, _ = history_of(w, BEGIN)
    algorithmic, new_slope, new_bend = history_of(w, TRIAL)
    w.change, w.turn, w.turning = finish(
        w.am, w.af, w.length, w.duration, kind, rotation_dof, w.n_q, w.n, w.h, before, slope, w.known,
        a0, z0, a, z, v, algorithmic, new_slope, new_bend,
    )  # fmt: skip
    largest, massless = 0.0, integers(w.massless, w.n_massless)
    for i in range(w.n_massless):
        largest = max(largest, abs(algorithmic[massless[i]] - before[massless[i]]))
    w.lag = w.error * w.h * w.h * largest / w.length
    w.next_known = min(w.known + 1, 2)
    w.next_has, w.next_age, w.next_drift = choose_tangent(
        w.has, w.age, w.drift, w.renewed, floats(w.report, 8), w.most_kept
    )
