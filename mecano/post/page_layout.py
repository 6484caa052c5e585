"""Arrangement of panels in columns, so that a picture of many fits a screen or a page in landscape format."""

RATIO = 0.7  # height over width of a page
HIGHEST = 8.5  # inches of a page that need not be wide


def columns_of(count: int, width: float, height: float) -> int:
    """Return the number of columns in which ``count`` panels of a size [inch] fit the smallest page."""
    return min(range(1, count + 1), key=lambda n: max(rows_of(count, n) * height, RATIO * n * width))


def rows_of(count: int, columns: int) -> int:
    """Return the number of rows of ``count`` panels in columns."""
    return -(-count // columns)


def height_of_row(rows: int, width: float, least: float, most: float) -> float:
    """Return the height of each of the ``rows`` [inch] on a page of a width, from ``least`` to ``most``."""
    return max(least, min(most, max(HIGHEST, RATIO * width) / rows))
