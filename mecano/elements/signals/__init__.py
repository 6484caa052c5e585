"""Signals: named scalars computed from the motion, the time and other signals."""
