"""What is done with a coordinate of a joint: it is held, driven, locked, stopped, loaded by a law, rubbed, measured."""
