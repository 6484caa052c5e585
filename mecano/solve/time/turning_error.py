r"""Error of bodies that spin about a turning axis.

Generalized-alpha moves angular velocities in material axes. Where the angular acceleration turns with a spinning body,
as in the precession of a top, it changes fast in these axes, and the local error of the angular velocity

.. math:: \delta\omega = \tfrac{1}{12} h^3\, \omega \times (\omega \times \dot\omega)

(the truncation error of the trapezoidal rule, with the part of the second derivative that comes from the turning of the
axes) keeps its direction in space, in which the motion is slow. Unlike the error of an oscillation, which changes its
sign, it adds up: to a rotation of :math:`\tau\, \delta\omega` for each step. Later errors undo it as the angular
acceleration turns in space, at the rate :math:`\nu = |\ddot\omega + \omega \times \dot\omega| / |\dot\omega|`, so
:math:`\tau = \min(1/(2 \nu), T/2)` in a run of the duration T. For two tops this gives errors of 0.7 and 0.9 of
the tolerance (tests/test_adaptive.py).

Where constraints hold the axis of the body, as those of a wheel that is steered, they leave nothing of this error:
error_bound.py takes its part along the constraints.
"""

from mecano.jit.kernel import kernel
from mecano.maths.vector import cross, norm, vec


@kernel
def turning_error(h, duration, rotation_dof, n_q, v, a0, a, errors_out):
    """Return the largest rotation [rad] of a node that is the error of a step of size h due to its spin.

    v (n_all,) velocities, a0, a (n_all,) accelerations at both ends of the step; those of rotations in material axes.
    ``duration`` [s] of the run. The rotations of all nodes are written into ``errors_out`` (n_q,), in material axes,
    unless it is empty.
    """
    worst = 0.0
    for r in range(rotation_dof.shape[0]):
        d = rotation_dof[r]
        if d < n_q:
            spin, change = vec(v, d), vec(a, d)
            gyroscopic = cross(spin, change)
            error = cross(spin, gyroscopic)
            size = norm(error)
            if size > 0.0:
                jerk = (change - vec(a0, d)) / h + gyroscopic
                rate = max(norm(jerk) / norm(change), 1.0 / duration)
                worst = max(worst, 0.5 * size / rate)
                if len(errors_out) > 0:
                    for i in range(3):
                        errors_out[d + i] = h * h * h / 24.0 / rate * error[i]
    return h * h * h / 12.0 * worst
