"""Records of parameters: structured dtypes, by default those of the deck fields of a kind."""

import numpy as np

UNUSED = "unused"  # field of an empty record
RECORDED = {"number": (), "vector": 3, "direction": 3, "law": "i", "curve": "i"}  # shape in a record, by type of field
LAWS = ("law", "curve")  # types of fields of which a record has the start in the table of laws


def record(**fields):
    """Return a structured dtype from names and shapes: record(mass=(), r_C=3, J=(3, 3)); shape "i" for an integer."""
    return np.dtype(
        [(name, "i8") if shape == "i" else (name, "f8", shape) for name, shape in fields.items()], align=True
    )


def recorded(fields):
    """Return {name: shape} of the fields that a record can hold: numbers, vectors and laws that are always given."""
    return {f.name: RECORDED[f.type.name] for f in fields if f.type.name in RECORDED and f.default is not None}


def recorded_values(names, fields, values, context):
    """Return the values of a record with these names from those of the ``fields``; of a law, its start in the table."""
    laws = [f.name for f in fields if f.type.name in LAWS]
    return {name: context.laws.add(values[name]) if name in laws else values[name] for name in names}
