"""Residual and tangent of a force on a body at a point away from its node: force, and moment in the body's axes."""

from mecano.jit.kernel import kernel
from mecano.maths.vector import EYE, add_col, add_mat, add_vec, cross, skew


@kernel
def add_force(f, Rn, arm, force):
    """Add a ``force`` (inertial) at ``arm`` (inertial) from a node with rotation Rn."""
    add_vec(f, 0, 1.0, force)
    add_vec(f, 3, 1.0, Rn.T @ cross(arm, force))


@kernel
def add_multiplier_column(K, column, k, Rn, arm, b):
    """Add the column -k (b, R^T (arm x b)) of a multiplier whose force acts along b."""
    add_col(K, 0, column, -k, b)
    add_col(K, 3, column, -k, Rn.T @ cross(arm, b))


@kernel
def moment_variation(arm, d_arm, force, d_force):
    """Return d(arm x force), 3x3, from the derivatives of both."""
    return skew(arm) @ d_force - skew(force) @ d_arm


@kernel
def add_columns(A, j, Rn, frame, force_rows, moment_rows):
    """Add three columns of a tangent from inertial derivatives; ``frame`` (3x3) transforms the variables."""
    add_mat(A, 0, j, 1.0, force_rows @ frame)
    add_mat(A, 3, j, 1.0, Rn.T @ (moment_rows @ frame))


@kernel
def add_position_tangent(K, Rn, arm, d_arm, force, d_force):
    """Add derivatives by position and rotation; ``d_arm`` and ``d_force`` are pairs (by dx, by inertial dtheta)."""
    moment = skew(cross(arm, force))
    add_columns(K, 0, Rn, EYE, d_force[0], moment_variation(arm, d_arm[0], force, d_force[0]))
    add_columns(K, 3, Rn, Rn, d_force[1], moment_variation(arm, d_arm[1], force, d_force[1]) + moment)


@kernel
def add_velocity_tangent(C, Rn, arm, by_u):
    """Add derivatives by velocities of a force; ``by_u``, 3x3, is its derivative by u = v + omega x arm."""
    lever = skew(arm)
    by_turn = -(by_u @ lever)
    add_columns(C, 0, Rn, EYE, by_u, lever @ by_u)
    add_columns(C, 3, Rn, Rn, by_turn, lever @ by_turn)
