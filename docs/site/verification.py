"""The verification manual: results of ``pytest --verification build/verification.json`` as tables and pictures."""

import io
import json
from itertools import groupby
from pathlib import Path

from matplotlib.figure import Figure

FOUND = Path(__file__).parents[2] / "build" / "verification.json"
COMMAND = "pytest -n auto --dist worksteal --verification build/verification.json"
FLOOR = 1e-8  # of an error over its tolerance: what is smaller is drawn so long
HEAD = f"""# Verification

Numbers computed by mecano, compared with closed forms, published results and independent integrations. The test suite
checks each of them. This page was made by one run of

```text
{COMMAND}
```

*Error* is the largest error if there are several numbers; it is relative if the tolerance is followed by *rel*. If an
order is given, the value is extrapolated from two step sizes, and the order is that of the largest error between the
two. Tolerances follow from the method (tests/convergence.py): a bar close to 1 is no cause for
concern, and bars far below 1 belong to numbers that are exact except for rounding.

More measurements are on the pages on [beams](../beams.md), [shocks](../shocks.md), [wheels](../tyres.md),
[superelements](../superelements.md), [step control](../step-control.md) and in the [theory](../theory.md).
"""


def pages():
    """Return {path: content} of the page and its pictures; without a run of the tests the page says so."""
    if not FOUND.exists():
        return {"verification.md": f"{HEAD}\nThis page was made without a run of the tests, so it has no tables.\n"}
    records = json.loads(FOUND.read_text(encoding="utf-8"))
    lines, pictures = [HEAD, f"{len(records)} comparisons in all."], {}
    for subject, group in groupby(sorted(records, key=_key), key=lambda record: record["subject"]):
        rows, name = list(group), f"verification_{subject.lower().replace(' ', '_')}.svg"
        pictures[name] = _picture(rows)
        lines += ["", f"## {subject}", "", f"![error over tolerance]({name})", "", *_table(rows)]
    return {"verification.md": "\n".join(lines) + "\n", **pictures}


def _key(record):
    return record["subject"], record["what"]


def _table(rows):
    yield "| what | computed | reference | error | tolerance | | source |"
    yield "|---|---|---|---|---|---|---|"
    for row in rows:
        what = row["what"] + (f", {row['count']} numbers" if row["count"] > 1 else "")
        tolerance = _power(row["tolerance"]) + (" *rel*" if row["measure"] == "relative" else "")
        cells = what, row["found"], row["reference"], _power(row["error"]), tolerance, row["remark"], row["source"]
        yield "| " + " | ".join(cells) + " |"


def _power(number):
    """Return a number of two digits that is not broken into two lines."""
    return f"{number:.1e}".replace("-", "\N{NON-BREAKING HYPHEN}")


def _picture(rows):
    """Return bars of error over tolerance on a logarithmic scale, as SVG."""
    figure = Figure(figsize=(9.0, 0.7 + 0.26 * len(rows)), layout="constrained")
    axes = figure.add_subplot()
    ratios = [max(row["error"] / row["tolerance"], FLOOR) for row in rows]
    axes.barh(range(len(rows)), ratios, left=FLOOR / 3.0, height=0.7, color="#4c72b0")
    axes.axvline(1.0, color="#c44e52", linewidth=1.5)
    axes.set_xscale("log")
    axes.set_xlim(FLOOR / 3.0, 3.0)
    axes.set_yticks(range(len(rows)), [row["what"] for row in rows], fontsize=8)
    axes.invert_yaxis()
    axes.set_xlabel("error / tolerance")
    axes.spines[["top", "right"]].set_visible(False)
    picture = io.StringIO()
    figure.savefig(picture, format="svg", metadata={"Date": None})
    return picture.getvalue().encode()
