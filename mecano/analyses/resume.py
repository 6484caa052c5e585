"""Recovery of an interrupted run from its last checkpoint: whether it can be resumed, and the rows before it."""

import json
import os
import time
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mecano.errors import ResultsError, UsageError, name_list
from mecano.results.layout import FORMAT_VERSION, Layout
from mecano.results.opening import errors_as_damage
from mecano.results.provenance import plugins, provenance, to_json
from mecano.results.reader import open_results

if TYPE_CHECKING:
    from mecano.deck.deck import Deck
    from mecano.process.interrupt import Interruption
    from mecano.results.writer import Writer

COMPLETE = "{} is complete: there is nothing to resume"
AT_ONCE = 2**21  # numbers copied at once, 16 MB
MOST = 5  # differences named
SURROUNDINGS = {"processor": "processor", "machine": "machine", "threads": "number of threads"}  # and the versions


class InterruptedRun:
    """The results file of a stopped run of ``deck``, open until ``close``.

    Raises UsageError if it belongs to another deck, ResultsError if it cannot be read or is being written.

    Attributes
    ----------
    complete : bool
        Whether the run reached its end.
    checkpoint : dict or None
        State passed to ``Writer.checkpoint``, with the row counts of the file at that time.
    automatic : dict
        Values chosen where the deck says "automatic".
    model : dict
        Properties of the model, see ``model_facts``.
    warnings, resumptions : list of str
        Those of the interrupted run.
    """

    def __init__(self, path: str | os.PathLike[str], deck: "Deck"):
        self.path, self.results = path, open_results(path)
        try:
            with errors_as_damage(path):
                self._check(deck)
                self.complete, self.checkpoint = self.results.status == "complete", self.results.checkpoint
                self.automatic, self.model = self.results.automatic, self.results.model
                self.warnings, self.resumptions = self.results.warnings, self.results.resumptions
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """Close the file."""
        self.results.close()

    def _check(self, deck):
        version = self.results.format_version
        if version != FORMAT_VERSION:
            raise ResultsError(
                f"{self.path} has format {version} of another version of mecano and cannot be resumed by this one, "
                f"which writes format {FORMAT_VERSION}: resume it with the version that wrote it, or replace it"
            )
        found = list(differences(self.results.resolved, json.loads(to_json(deck.resolved()))))
        if found:
            listed = name_list(found, MOST, "\n  ")
            raise UsageError(f"{self.path} belongs to another deck and cannot be resumed; it has\n  {listed}")
        if changed := self._changed_plugins():
            raise UsageError(f"{self.path} cannot be resumed: {changed}; name the plugins with which it was started")
        process = self.results.metadata["process"]
        if self.results.status == "running" and self.results.written_here and process != os.getpid():
            raise ResultsError(f"{self.path} is still being written, by process {process}")

    def _changed_plugins(self):
        """Return the differences of the plugins from those of the run as text, "" if there are none."""
        before, now = (json.loads(text) for text in (self.results.metadata["plugins"], plugins()))
        was, has = ({one["sha256"]: source for source, one in found.items()} for found in (before, now))
        missing, other = ([of[key] for key in of if key not in rest] for of, rest in ((was, has), (has, was)))
        return ", ".join([*(f"{s} is missing or was changed" for s in missing), *(f"{s} is new" for s in other)])

    def note(self, t: float) -> tuple[str, bool]:
        """Return the note on resuming at ``t`` [s], and whether the bits of the results may differ for it.

        They may on another machine, with other versions or another number of threads; the note names the differences.
        """
        reported = f"resumed at t = {t:.9g} s, {datetime.now(UTC).isoformat(timespec='seconds')}"
        was, now = self.results.metadata, provenance()
        names = SURROUNDINGS | {key: key.replace("_", " of ") for key in now if key.startswith("version_")}
        pairs = [(name, was.get(key), now[key]) for key, name in names.items()]
        changed = ", ".join(f"{name} ({before}, now {after})" for name, before, after in pairs if before != after)
        doubt = "results may differ in their last digits from those of an uninterrupted run"
        return (f"{reported}; {doubt}, because of another {changed}", True) if changed else (reported, False)

    def check_layout(self, layout: Layout) -> None:
        """Raise ResultsError unless the rows of the file have the ``layout`` of the resumed run."""
        if layout.to_json() != self.results.layout.to_json():
            raise ResultsError(f"{self.path} holds other outputs; it was written by another version of mecano")

    def copy_to(self, writer: "Writer", interruption: "Interruption") -> None:
        """Copy all rows and events up to the checkpoint to a new Writer, and close.

        Raises ResultsError, also for damaged rows, and the errors of ``Interruption.check``.
        """
        checkpoint = self.checkpoint
        assert checkpoint is not None, "a run without a checkpoint starts again"
        rows_before = [int(count) for count in checkpoint["file"]["rows"]]
        size = Path(self.path).stat().st_size
        what, done, begun = f"copying {self.path} ({size / 1e6:.3g} MB)", 0, time.monotonic()
        for table, rows in self._rows(*rows_before[:2]):
            writer.extend(table, rows)
            done += rows.nbytes
            more = max(size / done - 1.0, 0.0)
            interruption.check(what, more * (time.monotonic() - begun), (1.0 + more) * writer.closing_time)
        for event in self.results.events[: rows_before[2]]:
            writer.append_event(event)
        writer.resume_at(checkpoint)
        self.close()

    def _rows(self, outputs, steps):
        """Yield the first ``outputs`` and ``steps`` rows of both tables in parts: (table, (n, width) array)."""
        for table, count in (("output", outputs), ("solver", steps)):
            width = 1 + (self.results.layout.size if table == "output" else len(self.results.layout.steps))
            at_once = max(AT_ONCE // width // 1024, 1) * 1024  # whole chunks
            for first in range(0, count, at_once):
                yield table, self.results.rows(table, first, min(first + at_once, count))


def differences(was: Any, now: Any, path: str = "") -> Iterator[str]:
    """Yield the differences of two trees of plain data as texts: path, old and new value."""
    if isinstance(was, dict) and isinstance(now, dict):
        for key in dict.fromkeys([*was, *now]):
            yield from differences(was.get(key, ABSENT), now.get(key, ABSENT), f"{path}.{key}" if path else key)
    elif isinstance(was, list) and isinstance(now, list) and len(was) == len(now):
        for i, pair in enumerate(zip(was, now, strict=True)):
            yield from differences(*pair, f"{path}.{i}")
    elif was != now:
        yield f"{path}: {_short(was)} instead of {_short(now)}"


ABSENT = object()


def _short(value):
    if value is ABSENT:
        return "nothing"
    text = json.dumps(value, ensure_ascii=False)
    return text if len(text) <= 60 else text[:57] + "..."
