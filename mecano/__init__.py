"""mecano: flexible multibody dynamics by finite elements.

``mecano.open_results(path)`` reads a results file; everything else is used through the command line.
"""

import hashlib
import os
import tempfile
from pathlib import Path

__version__ = "0.1.0"

COMPILED = ("maths", "laws", "constraints", "elements", "model", "solve", "results")


def _cache_folder():
    """Folder for compiled code, named by a hash of its sources.

    numba does not see that an imported compiled function has changed; one folder for each state of the sources does.
    """
    here = Path(__file__).parent
    sources = sorted(path for folder in COMPILED for path in (here / folder).glob("*.py"))
    key = "mecano-" + hashlib.sha256(b"".join(path.read_bytes() for path in sources)).hexdigest()[:16]
    base = os.environ.get("NUMBA_CACHE_DIR") or os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    folder = Path(base) if Path(base).name == key else Path(base) / key
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return str(folder)
    except OSError:
        return str(Path(tempfile.mkdtemp()) / key)


os.environ["NUMBA_CACHE_DIR"] = _cache_folder()


def compiled_before(kinds):
    """True when compiled code of all ``kinds``, by name, or of variants of them, is on disk for these sources."""
    names = [path.name for path in Path(os.environ["NUMBA_CACHE_DIR"]).rglob("*.nbi")]
    return all(any(f".observe_{kind}-" in name or f".observe_{kind}_held-" in name for name in names) for kind in kinds)


def __getattr__(name):
    if name == "open_results":
        from mecano.results.reader import open_results

        return open_results
    raise AttributeError(f"module 'mecano' has no attribute '{name}'")
