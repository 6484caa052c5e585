"""The motions of modes, one after the other, as a results file, which pages and films play."""

import os

import numpy as np
from scipy.spatial.transform import Rotation

from mecano.errors import ResultsError
from mecano.post.deformation import quaternions
from mecano.post.mode_shapes import NO_SHAPES, amplitude_of, named_mode
from mecano.results.layout import Layout, Series
from mecano.results.modes_file import MOTIONS, ModesFile
from mecano.results.provenance import Source
from mecano.results.recorded import Event
from mecano.results.writer import Writer

CYCLES = 2  # of each mode
MOST, FEWEST = 48, 16  # saved instants of a mode
MOST_INSTANTS = 599  # of all modes, beside the state


def write_motions(file: ModesFile, path: str | os.PathLike[str]) -> None:
    """Write the results file of the state at "mode" 0, and of the modes with the number n from n to n + 1.

    Displacements have the amplitude of pictures of modes, which neither grows nor decays. Nodes inside superelements,
    which files of results do not contain, are left out. Raises ResultsError if there are no modes.
    """
    if not len(file.values):
        raise ResultsError(f"{file.path}: {NO_SHAPES}")
    layout = Layout([one for name in file.nodes for one in _series(name)], axis=MOTIONS)
    about = f"the motions of modes about: {file.about}"
    source = Source("", file.resolved, title=file.title or file.path.stem)
    with Writer.create(path, layout, source, force=True) as writer:
        writer.append(0.0, _row(file, 0, 0.0j))
        count = min(MOST, max(FEWEST, MOST_INSTANTS // len(file.values)))
        for mode in range(len(file.values)):
            size = amplitude_of(file, mode)
            for share in np.arange(count) / count:
                writer.append(mode + 1.0 + share, _row(file, mode, size * np.exp(2j * np.pi * CYCLES * share)))
            writer.append_event(Event(mode + 1.0, "", named_mode(file, mode), "", ""))
        writer.close("complete", about)


def _series(name):
    yield Series(f"nodes/{name}/position", "m", "position, inertial", (3,))
    yield Series(f"nodes/{name}/rotation", "-", "unit quaternion (w, x, y, z) from material to inertial axes", (4,))


def _row(file, mode, factor):
    """Return the positions and rotations of all nodes, displaced by the real part of ``factor`` times a shape."""
    values = []
    for node in file.nodes.values():
        shift, turn = (np.real(factor * node[what][mode]) for what in ("translation", "rotation"))
        rotation = Rotation.from_rotvec(turn).as_matrix() @ node["orientation"]
        values += [*(node["position"] + shift), *quaternions(rotation[None])[0]]
    return np.array(values)
