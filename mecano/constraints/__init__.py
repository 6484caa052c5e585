"""Basic constraints from which joints are composed; see of_coordinates.py for those of a single coordinate."""
