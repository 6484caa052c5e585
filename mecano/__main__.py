"""The program `mecano`, also as `python -m mecano`; Ctrl-C ends it silently until a command handles signals."""

import gc
import signal

gc.set_threshold(200_000, 20, 20)  # all objects of a model live until the end: repeated collection would take 0.1 s
if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # Ctrl-C during the imports would print a traceback

from mecano.cli import program  # noqa: E402

if __name__ == "__main__":
    program()
