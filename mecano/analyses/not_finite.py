"""The error for an output that is not finite; results files contain no such numbers."""

import numpy as np

from mecano.errors import NonFiniteError
from mecano.model.assembly import Observation
from mecano.model.sampler import Sampler

MOST_NAMES = 5  # elements in a message


def output_not_finite(sampler: Sampler, observation: Observation, i: int, where: str, remedy: str) -> NonFiniteError:
    """Return the NonFiniteError for entry ``i`` of the row of a Sampler, filled from an Observation.

    ``where`` is the time or load factor as text, ``remedy`` the advice.
    """
    column = next(column for column in sampler.columns if column.start <= i < column.start + column.size)
    path, _, output = column.path.rpartition("/")
    section, _, name = path.partition("/")
    of_nodes = {path: f"node '{name}'"} if section == "nodes" else {}
    batches = sampler.system.batches
    titles = of_nodes | {b.paths[e][0]: b.names[e] for b in batches for e in range(len(b.p))}
    if column.path.startswith("energy/"):  # the sum over all elements
        finite = np.isfinite(observation.energies)
        wrong = [b.names[e] for b in batches for e in np.flatnonzero(~finite[b.phases].all(axis=1))]
        titles = {path: "; ".join(wrong[:MOST_NAMES])} if wrong else {}
    owner = f"{titles[path]}: {output}" if path in titles else column.path
    return NonFiniteError(f"cannot continue from {where}: {owner} is not finite\nwhat to try: {remedy}")
