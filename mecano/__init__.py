"""mecano: flexible multibody dynamics by finite elements.

``mecano.open_results(path)`` reads a results file; everything else is used through the command line.
"""

__version__ = "0.1.0"


def __getattr__(name):
    if name == "open_results":
        from mecano.results.reader import open_results

        return open_results
    raise AttributeError(f"module 'mecano' has no attribute '{name}'")
