"""Members: beams, cables, springs, bushings."""
