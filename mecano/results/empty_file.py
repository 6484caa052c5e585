"""Blank results files: everything that depends on the layout only, created once and cached.

Creating the named views of a large model may take longer than its run, and all runs of a model have the same views. So
the bytes of a blank file are cached with the compiled code, and a run starts with a copy.
"""

import hashlib
import io
import os
import zlib
from functools import cache
from pathlib import Path

import h5py
import numpy as np

from mecano.jit import store
from mecano.results.disk import new_file
from mecano.results.layout import EXTREMES, FORMAT, FORMAT_VERSION, Layout
from mecano.results.table import Axes, chunk_shape, create_events, create_numbers, describe, name_axes
from mecano.results.views import make_views

RUNNING = "running"
TEXT_LENGTHS = {"status": 16, "reason": 8000}
CHANGING = ("run/status", "run/reason", "run/acknowledged", "run/clock", "run/compile_time")
"""Datasets that are overwritten in place, besides the extremes."""
LEAST_TEXT = 64  # bytes of the texts of events
MOST_KEPT = 20


def empty_file(layout: Layout) -> bytes:
    """Return the bytes of a results file of a Layout, without deck, provenance and results."""
    name = f"{_digest(layout)}.blank"
    kept = store.read(name)
    if kept is not None:
        return zlib.decompress(kept)
    data = _create(layout)
    store.write(name, zlib.compress(data, 1))
    store.keep_newest("*.blank", MOST_KEPT)
    return data


def _digest(layout):
    """Return a hash of the layout, the version of HDF5 and the modules that create the file."""
    chunks = [chunk_shape(1 + size) for size in (layout.size, len(layout.steps))]
    depends = f"{h5py.version.hdf5_version} {chunks} {_sources()} {layout.to_json()}"
    return hashlib.sha256(depends.encode()).hexdigest()[:32]


@cache
def _sources():
    """Return a hash of the modules that create results files."""
    modules = sorted(Path(__file__).parent.glob("*.py"))
    return hashlib.sha256(b"".join(path.read_bytes() for path in modules)).hexdigest()


class _Memory(io.BytesIO):
    """A file in memory that ``truncate`` can extend, like a file on disk."""

    def truncate(self, size=None):
        size = self.tell() if size is None else size
        if (lacking := size - self.getbuffer().nbytes) > 0:
            at = self.tell()
            self.seek(0, os.SEEK_END)
            self.write(bytes(lacking))
            self.seek(at)
        return super().truncate(size)


def _create(layout):
    memory = _Memory()
    with new_file(memory) as file:
        axes = Axes(file)
        outputs = create_numbers(file, "storage/output", 1 + layout.size)
        steps = create_numbers(file, "storage/solver", 1 + len(layout.steps))
        create_events(file, max(LEAST_TEXT, layout.longest_name))
        file["storage/layout"] = layout.to_json()
        make_views(file, axes, layout, outputs, steps)
        _make_run(file, axes)
        if layout.size:
            _make_extremes(file, axes, layout)
        file.attrs.update({"format": FORMAT, "format_version": FORMAT_VERSION})
    return memory.getvalue()


def _make_run(file, axes):
    run = file.create_group("run")
    for name, length in TEXT_LENGTHS.items():
        run.create_dataset(name, data=b"", dtype=h5py.string_dtype("utf-8", length))
    run["status"][()] = RUNNING
    counters = run.create_dataset("acknowledged", data=np.zeros(8, dtype="<i8"))
    describe(counters, long_name="saved times, steps, events, slot of the extremes; the others are reserved")
    name_axes(counters, axes.scale(8))
    clock = run.create_dataset("clock", data=np.zeros(2))
    describe(clock, units="s", long_name="wall-clock time since the start without compiling; CPU time of the process")
    name_axes(clock, axes.scale(2))
    compiling = run.create_dataset("compile_time", data=0.0)
    describe(compiling, units="s", long_name="wall-clock time for compiling, also before the start")


def _make_extremes(file, axes, layout):
    group = file.create_group("extremes")
    names = [name.encode() for name in layout.scalars]
    kind = h5py.string_dtype("utf-8", max(map(len, names)))
    outputs = group.create_dataset("output", data=np.array(names, dtype=kind))
    outputs.make_scale("output")
    for name, doc in EXTREMES.items():
        dataset = group.create_dataset(name, data=np.full((2, layout.size), np.nan))
        describe(dataset, long_name=f"{doc} over all accepted steps; run/acknowledged[3] is the valid row")
        name_axes(dataset, axes.scale(2), outputs)
