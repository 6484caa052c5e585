"""Estimate of the memory of a run; in large models, the views of the results file take most of it.

The constants were fitted to chains of springs, beams and grids of beams of 20 to 200,000 series (CPython 3.11 on Linux,
resident memory at its peak).
"""

from mecano.analyses.prepare import Prepared
from mecano.model.sampler import ENERGIES, NODE_OUTPUTS
from mecano.model.system import System
from mecano.solve.linear.least_degree import SMALL

PROGRAM = 60e6  # B of Python, NumPy, HDF5 and compiled code
SCIPY = 30e6  # B if it is imported: for ordering many nodes, and for redundant constraints
SERIES = 2900.0  # B for each series: its declaration, its view in the file, its share of the buffered rows


def memory_of_run(prepared: Prepared) -> float:
    """Return the peak resident memory [B] of a run of a Prepared model, accurate to about 25 %."""
    system = prepared.system
    scipy = SCIPY if len(system.nodes) > SMALL or prepared.analysis.redundant else 0.0
    return PROGRAM + scipy + SERIES * count_series(system) + prepared.linear.nbytes


def count_series(system: System) -> int:
    """Return the number of series in the results file of a System."""
    nodes = sum(not node.internal for node in system.nodes)
    return nodes * len(NODE_OUTPUTS) + sum(len(b.paths) * len(b.kind.outputs) for b in system.batches) + len(ENERGIES)


def memory_text(number: float) -> str:
    """Return an amount of memory [B] as text with two digits, in MB or GB."""
    return f"{number / 1e9:.2g} GB" if number >= 1e9 else f"{float(f'{number / 1e6:.2g}'):.0f} MB"
