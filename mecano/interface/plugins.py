"""Elements, tyre laws and laws of one's own, from Python."""

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
        If it cannot be read or run, has nothing to register or a name that is taken, or has terms of laws after the
        first model of the process.

    Examples
    --------
    >>> mecano.load_plugin("my_drag.py")
    ['air_drag']
    """
    from mecano.elements.plugins import load

    return load(os.fspath(path)).names
