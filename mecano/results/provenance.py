"""Where a result comes from: the deck as given and as understood, versions, machine, command line."""

import json
import os
import platform
import sys
import time
from dataclasses import asdict, dataclass, field
from datetime import UTC, datetime
from glob import glob

import h5py

import mecano
from mecano.element_interface import SECTIONS, Display

PACKAGES = ("numpy", "scipy", "numba", "llvmlite", "h5py")


@dataclass(frozen=True)
class Source:
    """What the run was asked to do.

    ``deck_text`` is the deck as its author wrote it; ``resolved`` the plain data it came to after overrides, includes
    and defaults; ``overrides`` the --set options; ``includes`` the SHA-256 of each file read, by path;
    ``automatic`` what stood for values that the deck leaves automatic; ``model`` numbers that tell the model: mass,
    unknowns, mobility...; ``warnings`` what the user was told at the start.
    """

    deck_text: str
    resolved: dict
    deck_path: str = ""
    title: str = ""
    overrides: tuple = ()
    includes: dict = field(default_factory=dict)
    automatic: dict = field(default_factory=dict)
    model: dict = field(default_factory=dict)
    warnings: tuple = ()

    def texts(self):
        """Return what the group ``deck`` holds: dataset name -> text."""
        return {
            "text": self.deck_text,
            "resolved": to_json(self.resolved),
            "displays": to_json({name: asdict(display) for name, display in displays(self.resolved).items()}),
            "overrides": to_json(list(self.overrides)),
            "includes": to_json(self.includes),
            "automatic": to_json(self.automatic),
            "model": to_json(self.model),
            "remarks": to_json(list(self.warnings)),
        }


def displays(resolved):
    """Return how the kinds of a resolved deck are drawn, as they declare it: name of the kind -> Display."""
    from mecano.elements import KINDS

    used = dict.fromkeys(d["type"] for section in SECTIONS for d in resolved.get(section, {}).values())
    return {name: KINDS[name].display if name in KINDS else Display() for name in used}


def read_displays(file, resolved):
    """Return the same as ``displays``, from an open file that holds the deck; older ones do not tell."""
    if "deck/displays" not in file:
        return displays(resolved)
    return {name: Display(**values) for name, values in json.loads(file["deck/displays"][()]).items()}


def to_json(data):
    """Write plain data, with arrays as lists, as JSON."""
    return json.dumps(data, default=lambda value: value.tolist(), ensure_ascii=False)


def plugins():
    """Describe the kinds and laws that are not mecano's: JSON of {file or package: {"sha256", "names"}}."""
    from mecano.elements.plugins import loaded

    return to_json({one.source: {"sha256": one.sha256, "names": one.names} for one in loaded()})


def provenance():
    """Describe this process: name -> text or whole number, the attributes of the group ``run``."""
    return {
        "plugins": plugins(),
        "started": datetime.now(UTC).isoformat(timespec="seconds"),
        "command_line": " ".join(sys.argv),
        "directory": os.getcwd(),
        "threads": threads(),
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


def lives(process):
    """True when a process of that number runs on this machine; one that was killed, but is still listed, does not."""
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        return True
    return _listed(process)[:1] not in (["Z"], ["X"])


def began(process):
    """When the process of a number began [s since 1970], where the system tells it; else 0."""
    try:
        ticks = start_ticks(process)
        return (
            time.time() - time.clock_gettime(time.CLOCK_BOOTTIME) + ticks / os.sysconf("SC_CLK_TCK") if ticks else 0.0
        )
    except (AttributeError, ValueError):
        return 0.0


def start_ticks(process):
    """Return when the process of a number began, in ticks since the system did, where it tells that; else 0."""
    try:
        return int(_listed(process)[19])
    except (IndexError, ValueError):
        return 0


def _listed(process):
    """State, parent... of a process as Linux lists them; nothing elsewhere."""
    try:
        with open(f"/proc/{process}/stat", encoding="utf-8") as file:
            return file.read().rpartition(")")[2].split()
    except OSError:
        return []


def threads():
    """Threads of the linear algebra of NumPy and SciPy, on which the last digits depend."""
    given = os.environ.get("OPENBLAS_NUM_THREADS", "")
    return int(given) if given.isdigit() else os.cpu_count()


def _version(package):
    """As the folder has it that an installer leaves beside the package: importlib.metadata takes 20 ms for the same."""
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
