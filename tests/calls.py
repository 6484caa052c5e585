"""Cost in calls of Python, which do not depend on the machine."""

import sys
from collections import Counter


def calls(action):
    """How many calls of functions an action makes."""
    counted = Counter()

    def count(frame, event, argument):
        counted[event] += 1

    sys.setprofile(count)
    try:
        action()
    finally:
        sys.setprofile(None)
    return counted["call"] + counted["c_call"]
