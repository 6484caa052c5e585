"""`python -m mecano`: the command line."""

from mecano.cli import program

if __name__ == "__main__":
    program()
