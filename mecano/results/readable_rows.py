"""Count the rows of a dataset that are complete in a truncated file, such as that of an interrupted copy."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import h5py


def rows_within(dataset: "h5py.Dataset", rows: int, size: int) -> int:
    """Return how many of the first ``rows`` rows of a chunked dataset lie in the first ``size`` bytes of the file."""
    height = dataset.chunks[0]
    for start in range(0, rows, height):
        if not _chunks_within(dataset, start, size):
            return start
    return rows


def _chunks_within(dataset, row, size):
    starts: list[tuple[int, ...]] = [(row,)]
    if dataset.ndim > 1:
        starts = [(row, column) for column in range(0, dataset.shape[1], dataset.chunks[1])]
    try:
        chunks = [dataset.id.get_chunk_info_by_coord(start) for start in starts]
    except (OSError, RuntimeError, ValueError):
        return False
    return all(c.byte_offset is not None and c.byte_offset + c.size <= size for c in chunks)
