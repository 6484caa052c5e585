"""Monitoring of outputs during a run: limits with a warning, and limits beyond which an element cannot go."""

from mecano.element_interface import SECTIONS
from mecano.elements import KINDS


def has_watched_outputs(values, what):
    """Return whether elements with the deck values ``values`` have monitored outputs."""
    return any(getattr(KINDS[d["type"]], what)(d) for section in SECTIONS for d in values[section].values())


def watched_outputs(values, sampler, what):
    """Return the monitored outputs of the elements with the deck values ``values``; ``what`` is "limits" or "ends".

    [(name, deck values of the element, output, its column in the row, value, text)]; of a vector each component is one.
    """
    columns = {column.path: column for column in sampler.columns}
    return [
        (name, d, output + part, column.start + i, value, text)
        for section in SECTIONS
        for name, d in values[section].items()
        for output, value, text in getattr(KINDS[d["type"]], what)(d)
        for column in [columns[f"{section}/{name}/{output}"]]
        for i, part in enumerate((".x", ".y", ".z") if column.size == 3 else ("",))
    ]


def ended(ends, row):
    """Return a text for the first element in a row of the sampler that has reached its end, or ""."""
    for name, d, _, i, size, text in ends:
        if abs(row[i]) > size:
            return f"{d['type']} '{name}' {text}"
    return ""
