"""The model of a deck before it runs: its assembled positions, as a results file of one saved time."""

from typing import TYPE_CHECKING

from mecano.analyses.prepare import model_facts, prepare
from mecano.analyses.source import source_of
from mecano.model.sampler import Sampler, StaticSample
from mecano.results.layout import Layout, Series
from mecano.results.writer import Writer

if TYPE_CHECKING:
    import os

    from mecano.deck.deck import Deck

UNKNOWN_BEFORE_RUN = ("N", "N m", "Pa", "W", "J", "1/s2", "m/s2")  # units of outputs that only a run computes
ASSEMBLED = "before the run: positions as assembled, no forces yet"


def preview(deck: "Deck", path: "str | os.PathLike[str]") -> None:
    """Write the assembled positions of a checked deck into the results file ``path``.

    Raises AssemblyError if the positions cannot be assembled, ResultsError for the file.
    """
    prepared = prepare(deck)
    sampler = Sampler(prepared.system)
    kept = [column for column in sampler.columns if column.unit not in UNKNOWN_BEFORE_RUN]
    row = sampler.take(StaticSample(prepared.state), prepared.system.observe(prepared.state))
    source = source_of(deck, model=model_facts(prepared))
    with Writer.create(path, Layout([Series(c.path, c.unit, c.doc, c.shape) for c in kept]), source) as writer:
        writer.append(prepared.state.t, [x for c in kept for x in row[c.start : c.start + c.size]])
        writer.close("complete", ASSEMBLED)
