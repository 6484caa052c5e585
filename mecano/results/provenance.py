"""Provenance of results: deck as given and as resolved, versions, machine, command line."""

import json
import os
import platform
import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict, field
from datetime import UTC, datetime
from glob import glob
from typing import Any

import h5py

import mecano
from mecano.element_interface import SECTIONS, Display
from mecano.immutable import immutable
from mecano.jit import thread_pool
from mecano.process.cores import blas_threads

PACKAGES = ("numpy", "scipy", "numba", "llvmlite", "h5py")


@immutable
class Source:
    """The input of a run.

    ``deck_text`` is the deck as written by its author; ``resolved`` the plain data after overrides, includes and
    defaults; ``overrides`` the --set options; ``includes`` the SHA-256 of each file read, by path; ``automatic`` the
    values chosen where the deck says "automatic"; ``model`` the properties of the model (mass, unknowns, mobility,
    ...); ``warnings`` the warnings issued at the start; ``resumptions`` notes of resumptions that change no bit.
    """

    deck_text: str
    resolved: dict[str, Any]
    deck_path: str = ""
    title: str = ""
    overrides: tuple[str, ...] = ()
    includes: dict[str, str] = field(default_factory=dict)
    automatic: dict[str, float] = field(default_factory=dict)
    model: dict[str, Any] = field(default_factory=dict)
    warnings: Sequence[str] = ()
    resumptions: Sequence[str] = ()

    def texts(self) -> dict[str, str]:
        """Return the content of the group ``deck``: dataset name -> text."""
        return {
            "text": self.deck_text,
            "resolved": to_json(self.resolved),
            "displays": to_json({name: asdict(display) for name, display in displays(self.resolved).items()}),
            "overrides": to_json(list(self.overrides)),
            "includes": to_json(self.includes),
            "automatic": to_json(self.automatic),
            "model": to_json(self.model),
            "warnings": to_json(list(self.warnings)),
            "resumptions": to_json(list(self.resumptions)),
        }


def displays(resolved: Mapping[str, Any]) -> dict[str, Display]:
    """Return how the kinds of a resolved deck are drawn, as they declare it: name of the kind -> Display."""
    from mecano.elements import KINDS

    used = dict.fromkeys(d["type"] for section in SECTIONS for d in resolved.get(section, {}).values())
    return {name: KINDS[name].display if name in KINDS else Display() for name in used}


def read_displays(file: h5py.File) -> dict[str, Display]:
    """Return ``displays`` as stored in an open results file."""
    return {name: Display(**values) for name, values in json.loads(file["deck/displays"][()]).items()}


def to_json(data: Any) -> str:
    """Return plain data as JSON text, with arrays as lists."""
    return json.dumps(data, default=lambda value: value.tolist(), ensure_ascii=False)


def plugins() -> str:
    """Describe the kinds and laws that are not mecano's: JSON of {file or package: {"sha256", "names"}}."""
    from mecano.elements.plugins import loaded

    return to_json({one.source: {"sha256": one.sha256, "names": one.names} for one in loaded()})


def provenance() -> dict[str, str | int]:
    """Return a description of this process, the attributes of the group ``run``: name -> str or int."""
    return {
        "plugins": plugins(),
        "started": datetime.now(UTC).isoformat(timespec="seconds"),
        "command_line": " ".join(sys.argv),
        "directory": os.getcwd(),
        "threads": blas_threads(),
        "solver_threads": thread_pool.threads(),
        "process": os.getpid(),
        "host": platform.node(),
        "machine": platform.machine(),
        "processor": _processor(),
        "operating_system": platform.platform(),
        "version_mecano": mecano.__version__,
        "version_python": platform.python_version(),
        "version_hdf5": h5py.version.hdf5_version,
        **{f"version_{package}": _version(package) for package in PACKAGES},
    }


def is_running(process: int) -> bool:
    """Return whether a process of that number runs on this machine; a zombie does not."""
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        return True
    return _process_status(process)[:1] not in (["Z"], ["X"])


def start_time(process: int) -> float:
    """Return the start time of a process [s since 1970], or 0 if the system does not provide it."""
    try:
        ticks = start_ticks(process)
        return (
            time.time() - time.clock_gettime(time.CLOCK_BOOTTIME) + ticks / os.sysconf("SC_CLK_TCK") if ticks else 0.0
        )
    except (AttributeError, ValueError):
        return 0.0


def start_ticks(process: int) -> int:
    """Return the start time of a process in clock ticks since boot, or 0 if the system does not provide it."""
    try:
        return int(_process_status(process)[19])
    except (IndexError, ValueError):
        return 0


def _process_status(process):
    """Return state, parent, ... of a process from /proc on Linux; [] elsewhere."""
    try:
        with open(f"/proc/{process}/stat", encoding="utf-8") as file:
            return file.read().rpartition(")")[2].split()
    except OSError:
        return []


def _version(package):
    """Return the version of a package: its own if it is imported, else that in the name of its .dist-info folder.

    importlib.metadata takes 20 ms.
    """
    if package in sys.modules:
        return sys.modules[package].__version__
    for folder in sys.path:
        for found in glob(f"{package}-*.dist-info", root_dir=folder or "."):
            return found.removeprefix(f"{package}-").removesuffix(".dist-info")
    from importlib import metadata

    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return "not installed"


def _processor():
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as lines:
            return next(line.split(":", 1)[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor()
