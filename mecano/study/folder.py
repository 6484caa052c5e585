"""Folder of a study: results file, log and record of each case."""

import fcntl
import json
import os
import shutil
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import asdict, dataclass
from pathlib import Path

from mecano.errors import MecanoError, ResultsError, UsageError
from mecano.results.lock import locked
from mecano.results.whole_file import atomic_file, make_folder
from mecano.study.read import Case, Study

STATUSES = COMPLETE, FAILED, STOPPED, WAITING = "complete", "failed", "stopped", "waiting"
RESUMABLE = (75, 129, 130, 143, 152)  # exit codes of runs that --resume continues
OTHER_RUN = (
    "was run with other values, or another deck: name another folder, or run the study again by --force (in Python "
    "force=True)"
)


@dataclass(frozen=True)
class Record:
    """End of a case: total ``processor_time`` and ``wall_time`` [s] of its processes, peak ``memory`` [B]."""

    status: str = WAITING
    exit_code: int | None = None
    processor_time: float = 0.0
    wall_time: float = 0.0
    memory: float = 0.0
    reason: str = ""


class Folder:
    """Files of a study by the number of the case: 0001.h5, 0001.log, 0001.json; and the table of all cases."""

    def __init__(self, path: str | os.PathLike[str], study: Study):
        self.path, self.study = Path(path), study
        self.digits = max(4, len(str(len(study.cases))))
        self.table = self.path / "table.h5"

    def file(self, case: Case, ending: str) -> Path:
        """Return the path of a file of a case."""
        return self.path / f"{case.number:0{self.digits}d}{ending}"

    def pattern(self, ending: str) -> str:
        """Return the absolute path of these files for `printf`, with a place for the number of the case."""
        return f"{self.path.absolute()}/".replace("%", "%%") + f"%0{self.digits}d{ending}"

    def record(self, case: Case) -> Record:
        """Return the Record of a case. Raises UsageError if it belongs to other values, ResultsError if unreadable."""
        try:
            reported = json.loads(self.file(case, ".json").read_text(encoding="utf-8"))
            record, run = Record(**reported["ended"]), reported["run"]
        except FileNotFoundError:
            return Record()
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise ResultsError(f"cannot read {self.file(case, '.json')}: {error}") from error
        if run != self._run(case):
            raise UsageError(f"case {case.number} in {self.path} {OTHER_RUN}")
        return record

    def write(self, case: Case, record: Record) -> None:
        """Save the Record of a case."""
        with atomic_file(self.file(case, ".json")) as hidden:
            hidden.write_text(json.dumps({"run": self._run(case), "ended": asdict(record)}, indent=1) + "\n")

    def _run(self, case):
        return {"deck_sha256": self.study.digest, "overrides": list(self.study.overrides(case))}

    def clear(self, cases: Iterable[Case]) -> None:
        """Remove all files of some cases."""
        for case in cases:
            for path in self._files(case):
                path.unlink(missing_ok=True)

    def _files(self, case):
        return [self.file(case, ending) for ending in (".h5", ".json", ".log")]

    @contextmanager
    def set_aside(self, cases: Iterable[Case]) -> Iterator[None]:
        """Keep all files of some cases in the folder ``replaced`` within this block; delete them at its end.

        A MecanoError in the block restores them. Raises UsageError if another process runs cases.
        """
        files = [path for case in cases for path in self._files(case) if path.exists()]
        if not files:
            yield
            return
        aside = self.path / "replaced"
        with self.held():
            make_folder(aside)
            moved = [(path, path.replace(aside / path.name)) for path in files]
        try:
            yield
        except MecanoError:
            for path, kept in moved:
                kept.replace(path)
            shutil.rmtree(aside, ignore_errors=True)
            raise
        shutil.rmtree(aside, ignore_errors=True)

    def begun(self) -> bool:
        """Return True if a case of the study has been run here."""
        return os.path.isdir(self.path) and any(self.path.glob(f"{'[0-9]' * self.digits}.*"))

    @contextmanager
    def held(self, alone: bool = True) -> Iterator[None]:
        """Lock the folder within this block, with ``alone`` False for shared use. Raises UsageError if it is locked."""
        make_folder(self.path)
        try:
            place = os.open(self.path, os.O_RDONLY)
        except OSError as error:
            raise ResultsError(f"cannot read {self.path}: {error.strerror}") from error
        try:
            fcntl.flock(place, (fcntl.LOCK_EX if alone else fcntl.LOCK_SH) | fcntl.LOCK_NB)
        except BlockingIOError:
            os.close(place)
            raise UsageError(f"another process is running cases in {self.path}") from None
        except OSError:  # a file system without locks
            pass
        try:
            with locked(self.table) if alone else nullcontext():  # this lock works even if those of the system do not
                yield
        finally:
            os.close(place)
