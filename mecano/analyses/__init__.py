"""The analyses, each from a checked deck to a results file: dynamics, statics, modes, reduction, checks."""
