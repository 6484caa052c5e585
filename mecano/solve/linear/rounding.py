r"""Rounding errors at which Newton's method has converged.

A coordinate x is known to :math:`\epsilon |x|`, and so a residual to :math:`\epsilon |S|\,|x|` with the tangent S. In
short steps S is that of the masses, :math:`M/(\beta h^2)`: the rounding of a constraint alone may be a force above the
tolerance, however small the forces are. An iteration that has left the share :math:`\theta` of the last residual has
converged, whatever its residual, if the next correction would be rounding,

.. math::  \min(\theta, 1)\, |\Delta x| \le 16\, \epsilon\, |x|,

or if with a new tangent the residual falls no more (:math:`\theta > 0.3`) after a correction of 1e-12 |x|, as where
angles of many turns are rounded more coarsely. |x| is the largest coordinate, but at least the length scale, or 1 rad.
Hairer & Wanner (1996, IV.8) judge the next correction in the same way, with at least 10 rounding units.
"""

from mecano.jit.kernel import kernel

TINY, HUGE = 1e-300, 1e300  # smaller numbers count as zero, larger ones as infinite
ROUNDING = 16 * 2.2e-16  # relative rounding error of a sum of a few numbers
NEAR = 1e-12  # a smaller correction may be rounding
STALLS = 0.3  # it is, if it leaves more than this of the residual


@kernel
def at_rounding(correction, reduction, fresh, reach, least):
    """Return whether Newton's method has reached the rounding of the unknowns.

    Parameters
    ----------
    correction : float
        Largest displacement over the length scale, or rotation [rad], of the last iteration.
    reduction : float
        The residual over that before the correction, or the correction over the one before.
    fresh : bool
        Whether the tangent was new.
    reach : float
        Largest coordinate over the length scale, at least 1.
    least : float
        Largest next correction over ``reach`` that counts as rounding error.
    """
    return correction * min(reduction, 1.0) <= least * reach or (
        fresh and reduction > STALLS and correction <= NEAR * reach
    )
