"""Small motions about a state: linearization, modes, mode families; reduction of a part."""

SOLVERS = ("automatic", "dense", "sparse")
"""Methods of `modes.solve`; automatic: by the size."""
