"""`python -m mecano`: the command line."""

from mecano.cli import main

if __name__ == "__main__":
    main()
