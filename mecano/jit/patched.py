"""Attributes of numba that are patched while kernels are compiled."""

from contextlib import contextmanager


@contextmanager
def patched(*attributes):
    """Have the ``attributes`` (owner, name, value) these values in the block, and their own ones after it."""
    before = [getattr(owner, name) for owner, name, _ in attributes]
    for owner, name, value in attributes:
        setattr(owner, name, value)
    try:
        yield
    finally:
        for (owner, name, _), value in zip(attributes, before, strict=True):
            setattr(owner, name, value)
