"""Small motions about a state: linearization, modes, mode families; reduction of a part."""
