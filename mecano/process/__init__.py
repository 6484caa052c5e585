"""The process that a run is: its signals, its memory, its end with the one that started it."""
