"""Uses of a coordinate of a joint: held, driven, locked, stopped, loaded by a law, subject to friction, measured."""
