"""Joints, gears, guides, prescribed motions, contacts of points."""
