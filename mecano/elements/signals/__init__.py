"""Signals: named numbers that follow from the motion, from the time and from one another."""
