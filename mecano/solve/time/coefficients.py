r"""Coefficients of the methods of the family of generalized-alpha (generalized_alpha.py), by the spectral radius."""

from typing import Self

import numpy as np

from mecano.immutable import immutable


@immutable
class Coefficients:
    """am, af, beta, gamma of the family, and the constant Ce of its local displacement error."""

    am: float
    af: float
    beta: float
    gamma: float

    @classmethod
    def generalized_alpha(cls, rho: float) -> Self:
        """Chung & Hulbert 1993, spectral radius rho at infinity in [0, 1]."""
        am, af = (2.0 * rho - 1.0) / (rho + 1.0), rho / (rho + 1.0)
        gamma = 0.5 + af - am
        return cls(am, af, 0.25 * (gamma + 0.5) ** 2, gamma)

    @classmethod
    def hht(cls, rho: float) -> Self:
        """Hilber, Hughes & Taylor 1977; rho in [1/2, 1]."""
        af = (1.0 - rho) / (1.0 + rho)
        return cls(0.0, af, 0.25 * (1.0 + af) ** 2, 0.5 + af)

    @classmethod
    def newmark(cls, rho: float) -> Self:
        """Newmark 1959 with damping: gamma = 1/2 + delta, beta = (gamma + 1/2)^2/4; first order for rho < 1."""
        delta = (1.0 - rho) / (1.0 + rho)
        gamma = 0.5 + delta
        return cls(0.0, 0.0, 0.25 * (gamma + 0.5) ** 2, gamma)

    @property
    def error(self) -> float:
        """Ce of the local error Ce h^2 |a_{n+1} - a_n| of the displacement."""
        return self.beta + 0.5 * (self.am - self.af) - 1.0 / 6.0

    def acceleration(self, phase: np.ndarray) -> np.ndarray:
        """Return the acceleration of a coordinate that turns by ``phase`` [rad] in each step, over the exact one.

        Complex: of exp(i omega t), whose displacements, velocities and both accelerations follow from one another by
        the formulas of the method.
        """
        z = np.exp(1j * phase)
        moved = (1.0 - self.gamma) + self.gamma * z + (z - 1.0) * (0.5 - self.beta + self.beta * z)
        averaged = ((1.0 - self.am) * z + self.am) / ((1.0 - self.af) * z + self.af)
        return -((z - 1.0) ** 2) / (phase**2 * moved) * averaged
