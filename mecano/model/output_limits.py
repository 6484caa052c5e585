"""What the kinds of a model watch of their outputs: where a warning is due, and where an element can go no further."""

from mecano.element_interface import SECTIONS
from mecano.elements import KINDS


def watched_outputs(values, sampler, what):
    """Return what the elements of a deck's ``values`` watch, "limits" or "ends".

    [(name, deck values of the element, output, its column in the row, value, text)].
    """
    columns = {column.path: column.start for column in sampler.columns}
    return [
        (name, d, output, columns[f"{section}/{name}/{output}"], value, text)
        for section in SECTIONS
        for name, d in values[section].items()
        for output, value, text in getattr(KINDS[d["type"]], what)(d)
    ]


def ended(ends, row):
    """Return a text on the first element that can go no further in a row of the sampler, or ""."""
    for name, d, _, i, size, text in ends:
        if abs(row[i]) > size:
            return f"{d['type']} '{name}' {text}"
    return ""
