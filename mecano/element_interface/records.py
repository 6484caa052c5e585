"""Records of parameters: structured dtypes, by default those of the deck fields of a kind."""

from collections.abc import Iterable
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

if TYPE_CHECKING:
    from mecano.element_interface.kind import Context
    from mecano.schema import Field, Values

Shape: TypeAlias = int | str | tuple[int, ...]  # of a number or an array of them; "i" for an integer
UNUSED = "unused"  # field of an empty record
RECORDED: dict[str, Shape] = {"number": (), "vector": 3, "direction": 3, "law": "i", "curve": "i"}  # by type of field
LAWS = ("law", "curve")  # types of fields stored in a record as the start in the table of laws


def record(**fields: Shape) -> np.dtype:
    """Return a structured dtype from names and shapes: record(mass=(), r_C=3, J=(3, 3)); shape "i" for an integer."""
    return np.dtype(
        [(name, "i8") if shape == "i" else (name, "f8", shape) for name, shape in fields.items()], align=True
    )


def with_fields(dtype: np.dtype, **fields: Shape) -> np.dtype:
    """Return the dtype of a record with further ``fields``, named as in ``record``.

    They precede those of ``dtype``: numba does not distinguish a record from another one with the same leading fields.
    """
    parts = [(name, of.fields[name][0]) for of in (record(**fields), dtype) for name in of.names or () if of.fields]
    return np.dtype(parts, align=True)


def with_attributes(p: np.void) -> SimpleNamespace:
    """Return the fields of a record as attributes, which is faster than a recarray."""
    values = {name: p[name] for name in p.dtype.names or ()}
    return SimpleNamespace(
        **values | {name: with_attributes(x) for name, x in values.items() if isinstance(x, np.void)}
    )


def recorded(fields: "Iterable[Field]") -> dict[str, Shape]:
    """Return {name: shape} of the fields that a record can hold: laws; numbers and vectors that are always given."""
    return {
        f.name: RECORDED[f.type.name]
        for f in fields
        if f.type.name in LAWS or (f.type.name in RECORDED and f.default is not None)
    }


def recorded_values(
    names: Iterable[str], fields: "Iterable[Field]", values: "Values", context: "Context"
) -> dict[str, Any]:
    """Return the values of a record with these names from those of the ``fields``; of a law, its start in the table.

    A law that is absent starts at 0, where the law is zero.
    """
    laws = [f.name for f in fields if f.type.name in LAWS]
    return {name: context.laws.add(values[name]) if name in laws else values[name] for name in names}


def random_record(dtype: np.dtype, rng: "np.random.Generator") -> "Values":
    """Return random values of a record for tests: integers 0, numbers from 0.5 to 1, vectors, unit axes (3, 3)."""
    values: Values = {}
    for name in dtype.names or ():
        base, shape = dtype[name].base, dtype[name].shape
        if shape[-2:] == (3, 3):
            Q = np.linalg.qr(rng.normal(size=shape))[0]
            values[name] = Q * np.linalg.det(Q)[..., None, None]  # right-handed
        else:
            values[name] = 0 if base.kind == "i" else rng.normal(size=shape) if shape else rng.uniform(0.5, 1.0)
    return values
