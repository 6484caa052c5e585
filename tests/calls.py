"""Cost in calls of Python, which do not depend on the machine."""

import sys
from collections import Counter


def calls(action, of=""):
    """How many calls of functions an action makes; ``of``: only of functions in the file whose path ends so."""
    counted = Counter()

    def count(frame, event, argument):
        if frame.f_code.co_filename.endswith(of):
            counted[event] += 1

    sys.setprofile(count)
    try:
        action()
    finally:
        sys.setprofile(None)
    return counted["call"] + (0 if of else counted["c_call"])
