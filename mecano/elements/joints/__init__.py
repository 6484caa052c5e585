"""Joints, gears, guides, prescribed motions, point contacts."""
