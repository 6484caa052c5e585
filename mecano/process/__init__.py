"""The process of a run: its signals, its memory, its end together with the parent process."""
