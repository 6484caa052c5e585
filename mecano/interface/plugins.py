"""Load elements, tyre laws and terms of laws of one's own from Python."""

import os


def load_plugin(path: str | os.PathLike[str]) -> list[str]:
    """Run a Python file and register its kinds, slip laws and terms of laws, as the option ``--plugin`` does.

    Parameters
    ----------
    path
        A file that ends with .py; it is run once in a process.

    Returns
    -------
    list of str
        Names of the kinds and laws that it registered.

    Raises
    ------
    MecanoError
        The file cannot be read or run, registers nothing or a name already in use, or adds terms of laws after the
        first model of the process was built.

    Examples
    --------
    >>> mecano.load_plugin("my_drag.py")
    ['air_drag']
    """
    from mecano.elements.plugins import load

    return load(os.fspath(path)).names
