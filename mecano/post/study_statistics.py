"""Statistics of the outputs of a study, and their correlation with the varied values."""

from collections.abc import Iterator

import numpy as np

from mecano.post.report import Table, Text, number
from mecano.post.study_outputs import displayed_outputs, study_unit
from mecano.results.study_file import StudyTable

LEAST = 10  # least number of cases with a value of an output, for statistics
CORRELATION = (
    "The table below gives rank correlations (Spearman): 1 if the output grows with the varied value from case to case "
    "whatever the other values are, -1 if it falls, near 0 if neither."
)


def statistics(table: StudyTable) -> Iterator[Table | Text]:
    """Yield the parts of a report on the outputs of unnamed cases: mean, deviation, quantiles, rank correlations."""
    if table.named:  # chosen one by one, not samples
        return
    outputs = [one for one in displayed_outputs(table) if np.isfinite(one.values).sum() >= LEAST]
    if not outputs:
        return
    yield Table(
        ("output", "unit", "cases", "mean", "standard deviation", "5 % below", "median", "95 % below"),
        [_row(one) for one in outputs], 2,
    )  # fmt: skip
    varied = [one for one in table.group("parameters") if one.numeric and len(set(one.values)) > 2]
    if varied:
        names = [one.name.removeprefix("parameters.") for one in varied]
        yield Text(CORRELATION)
        yield Table(("output", *names), [(_words(one), *(_correlation(one, by) for by in varied)) for one in outputs])


def _row(output):
    values = output.values[np.isfinite(output.values)]
    factor, unit = study_unit(output.unit, output.values)
    numbers = values.mean(), values.std(ddof=1), *np.quantile(values, (0.05, 0.5, 0.95))
    return _words(output), unit, str(len(values)), *(number(one / factor) for one in numbers)


def _words(output):
    return output.name.replace("_", " ")


def _correlation(output, by):
    """Return the rank correlation of an output with a varied value; "" if the output is the same in all cases."""
    known = np.isfinite(output.values) & np.isfinite(by.values)
    x, y = by.values[known], output.values[known]
    if len(set(x)) < 2 or len(set(y)) < 2:
        return ""
    from scipy.stats import spearmanr  # takes 0.4 s to import, hence only when needed

    return f"{spearmanr(x, y).statistic:.2f}"
