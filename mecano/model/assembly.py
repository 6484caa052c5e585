"""Values that an assembly of a system writes: sums at one state, and the outputs of the elements there.

Each value has arrays of its own, and the record SYSTEM through which the loops of the elements reach them. The system
itself is not changed by an assembly, so no result depends on what was assembled before it.
"""

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from mecano.model.system import System


class Assembly:
    """Residual and tangent of a system at one state; written by ``System.assemble``.

    Parameters
    ----------
    system : System
    data : (n_data,) array, optional
        Values to which a tangent is added, instead of new ones.

    Attributes
    ----------
    residual, size : (n_all,) array
        Residual of the equations, and the sum of the magnitudes of its terms, which is its scale.
    data : (n_data,) array
        Values of the tangent in the pattern of the system; the last three collect the terms of fixed unknowns.
    forces : (n_slots,) array
        Sums of the residuals of the elements at each node, also where nodes share unknowns.
    record : (1,) array of SYSTEM
    """

    def __init__(self, system: "System", data: np.ndarray | None = None):
        self.residual, self.size = np.zeros(system.numbering.n_all), np.zeros(system.numbering.n_all)
        self.data = np.zeros(system.n_data) if data is None else data
        self.forces, self._sizes = np.zeros(system.n_slots), np.zeros(system.n_slots)
        self._masses = np.zeros(system.n_slots)  # diagonals of the mass matrices at the last tangent
        self.record = system.record_with(
            residual=self.residual, scale=self.size, data=self.data, force=self.forces, size=self._sizes,
            mass=self._masses,
        )  # fmt: skip


class Observation:
    """Outputs and energies of the elements of a system at one state; written by ``System.observe``.

    Attributes
    ----------
    outputs : (n,) array
        Outputs of all elements, batch by batch.
    energies : (n_elements, 4) array
        Kinetic and potential energy [J], dissipated and supplied power [W] of each element, batch by batch.
    energy : (4,) array
        Their sums.
    record : (1,) array of SYSTEM
    """

    def __init__(self, system: "System"):
        self.outputs, self.energies = np.zeros(system.n_outputs), np.zeros((system.n_elements, 4))
        self.energy = np.zeros(4)
        self._transmitted = np.zeros(system.n_transmitted)
        self.record = system.record_with(
            outputs=self.outputs, energies=self.energies, energy=self.energy, transmitted=self._transmitted
        )

    @property
    def powers(self) -> tuple[float, float]:
        """Dissipated and supplied power [W] of all elements."""
        return float(self.energy[2]), float(self.energy[3])
