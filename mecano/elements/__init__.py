"""The registry: one line for each kind of element, joint and load, nothing else."""

KINDS = {kind.name: kind for kind in ()}
