"""Small motions about a state: their matrices, modes, families; reduction of a part."""
