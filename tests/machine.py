"""The speed of the machine, for limits of processor time that do not depend on it."""

import time


def addition():
    """Return the processor time [s] of one addition in a loop of Python, measured now: 0.05 to 0.15 us."""
    n, total, start = 1_000_000, 0, time.process_time()
    for i in range(n):
        total += i
    return (time.process_time() - start) / n
