"""What a user can ask for, from a checked deck to a results file: dynamics, statics, modes, reduction, checks."""
