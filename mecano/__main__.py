"""The program `mecano`, also as `python -m mecano`; Ctrl-C ends it silently until a command handles signals."""

import signal

if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # Ctrl-C during the imports would print a traceback

from mecano.cli import program

if __name__ == "__main__":
    program()
