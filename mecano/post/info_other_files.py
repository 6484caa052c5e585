"""Summary, as text, of the files of mecano that are not results of a run: modes, sweeps, responses, studies."""

import os

import h5py

from mecano.post.text_table import aligned
from mecano.results import modes_file
from mecano.results.modes_file import read_modes
from mecano.results.opening import format_of, open_checked

OWN = "mecano "  # prefix of the formats of mecano
NUMBERS = ("frequency", "natural_frequency", "damping_ratio", "real_part", "residual")
HEAD = ("mode", "damped [Hz]", "natural [Hz]", "damping", "growth [1/s]", "residual", "kind")


def is_other(path: str | os.PathLike[str]) -> bool:
    """Return whether mecano has written a file that is not the results file of a run."""
    return format_of(path).startswith(OWN) and format_of(path) != "mecano results"


def info_other(path: str | os.PathLike[str]) -> str:
    """Return the summary of a file of modes, a sweep or a study. Raises ResultsError."""
    lines = _run(path)
    lines += _modes(read_modes(path)) if format_of(path) == modes_file.FORMAT else _contents(path)
    return "\n".join(lines)


def _run(path):
    with open_checked(path) as file:
        run = dict(file["run"].attrs)
        kind = str(file.attrs["format"])
    rows = [("file", kind), ("title", run.get("title") or "none"), ("about", run.get("about", ""))]
    if "method" in run:
        rows.append(("method", f"{run['method']}; {run['computed']} computed"))
    rows.append(("deck", run.get("deck_path") or "not a file"))
    return [str(path), *(f"  {label:<12}{text}" for label, text in rows if text), ""]


def _modes(file):
    rows: list[tuple[str, ...]] = [HEAD]
    for i, kind in enumerate(file.kinds):
        numbers = [float(file.numbers[name][i]) + 0.0 for name in NUMBERS]
        texts = [
            f"{number:.1e}" if name == "residual" else f"{number:.6g}"
            for name, number in zip(NUMBERS, numbers, strict=True)
        ]
        rows.append((str(i + 1), *texts, kind if file.converged[i] else f"{kind}, not converged"))

    inside = "".join(f", {len(one['position'])} inside {name}" for name, one in file.inner.items())
    return [*aligned(rows, ">" * len(HEAD)), "", f"shapes of {len(file.nodes)} nodes{inside}; `mecano post` draws them"]


def _contents(path):
    """Return lines with names, units and descriptions of all datasets of the file."""
    lines = ["Numbers"]

    def note(name, item):
        if isinstance(item, h5py.Dataset) and not name.startswith("deck/"):
            unit, doc = item.attrs.get("units", ""), item.attrs.get("long_name", "")
            lines.append(f"  {name}{f' [{unit}]' if unit else ''}{f': {doc}' if doc else ''}")

    with open_checked(path) as file:
        file.visititems(note)
    return lines
