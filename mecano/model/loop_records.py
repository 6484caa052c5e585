"""Records of the arrays of a batch and of the system, which the compiled loops over elements read."""

from typing import TYPE_CHECKING, Any

import numpy as np

from mecano.jit.kernel import kernel
from mecano.jit.memory import items

if TYPE_CHECKING:
    from mecano.model.assembly_driver import Loops


def fields(floats="", words="", loops=""):
    """Return the type of a record of numbers, of words (addresses, lengths), and of Loops, by their purposes."""
    words += "".join(f" {name}" for purpose in loops.split() for name in _fields_of_loops(purpose))
    return np.dtype([(name, "f8") for name in floats.split()] + [(name, "i8") for name in words.split()], align=True)


def _fields_of_loops(purpose):
    return f"n_{purpose}_loops", f"{purpose}_loops", f"{purpose}_batches"


# Addresses of the functions of the kind, index of the current element, addresses of arrays, and their lengths
# (n, n_...); shapes as in batch.py.
BATCH = fields(
    floats="penalty_factor",
    words="function inertia element of_rates n n_local n_vectors n_rotations n_multipliers first_reaction n_reactions "
    "n_output_dofs n_forces n_outputs n_phases "
    "n_events n_memory p dofs rots slots columns entries multipliers output_dofs output_slots "
    "q v a R f K C M seeded F y energies idle before commands kept first_phase first_memory first_output first_event "
    "first_element groups",
)
# Addresses of the arrays of the system, of the state on which the loops work, and of the values that they write.
SYSTEM = fields(
    floats="t k penalty lag cK cC cM",
    words="n_all n_rotations z v a R T phases memory memory_out "
    "n_states states n_laws laws n_slots n_vectors force size mass slot_dof residual scale n_data data "
    "n_transmitted partition_starts partition_members partition_weights transmitted "
    "outputs energies energy event_values n_constraints constraint_derivatives columns",
)
WORD = {name: offset // 8 for name, (_, offset) in SYSTEM.fields.items()}
"""Places of the fields of SYSTEM, as words of eight bytes."""


def record(dtype, **values):
    """Return an array (1,) of one record."""
    out = np.zeros(1, dtype)
    for name, value in values.items():
        out[name] = value
    return out


class Pointers:
    """A record (1,) of numbers and of addresses of arrays, which live as long as it."""

    def __init__(self, dtype: np.dtype):
        self.record = np.zeros(1, dtype)
        self._arrays: dict[str, np.ndarray] = {}

    def point_to(self, **values: Any) -> None:
        """Set fields to numbers, or to the addresses of arrays."""
        for name, value in values.items():
            if type(value) is np.ndarray:
                self._arrays[name] = value
                value = value.ctypes.data
            self.record[name] = value

    def point_to_loops(self, **loops: "Loops") -> None:
        """Set the fields of Loops, given by their purposes."""
        for purpose, (addresses, batches) in loops.items():
            values = len(addresses), addresses, batches
            self.point_to(**dict(zip(_fields_of_loops(purpose), values, strict=True)))

    def array(self, name: str) -> np.ndarray:
        """Return the array to which a field points."""
        return self._arrays[name]


@kernel
def batch_at(address):
    """Return the record of a batch."""
    return items(address, 1, BATCH)[0]


@kernel
def system_at(address):
    """Return the record of the system."""
    return items(address, 1, SYSTEM)[0]
