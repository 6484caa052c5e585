"""Plugins: user-defined kinds, slip laws and terms of laws, from Python files or installed packages.

Every ``Kind`` of a deck section, ``SlipLaw`` and ``Term`` at the top level of such a module is registered under its
name, unless its name in the module begins with "_"; from then on it is used like a built-in one. A deck cannot name
modules: it is data only, and a file runs only if the user names it.
"""

import hashlib
import os
import sys
from functools import cache
from glob import glob
from importlib.util import module_from_spec, spec_from_file_location

from mecano.errors import UsageError
from mecano.immutable import immutable

GROUP = "mecano.kinds"  # entry points of installed packages, each of which names a module


@immutable
class Plugin:
    """A module whose kinds and laws are registered."""

    source: str  # absolute path of the file, or "package:module"
    sha256: str
    found: tuple  # its Kinds, SlipLaws and Terms

    @property
    def names(self):
        """Names of the kinds and laws that it registered."""
        return [item.name for item in self.found]


_loaded = {}  # source -> Plugin


def loaded():
    """Return the Plugins of this process, in the order in which they were loaded."""
    return list(_loaded.values())


def files():
    """Return the absolute paths of the files that the user named, for child processes."""
    return [plugin.source for plugin in loaded() if os.path.isabs(plugin.source)]


def load(path):
    """Run a Python file and register its kinds and laws; return its Plugin. A file is run once.

    Raises UsageError if it cannot be read or run, or contains a name that is already in use.
    """
    source = os.path.abspath(path)
    if source not in _loaded:
        try:
            with open(source, "rb") as file:
                data = file.read()
        except OSError as error:
            raise UsageError(f"plugin {path} cannot be read: {error.strerror}") from None
        stem = os.path.splitext(os.path.basename(source))[0]
        _register(source, hashlib.sha256(data).hexdigest(), _run(source, path, f"mecano_plugin_{stem}"))
    return _loaded[source]


@cache
def load_installed():
    """Load the modules that installed packages name as entry points of the group ``mecano.kinds``.

    Raises UsageError as ``load``.
    """
    if not _any_installed():
        return
    from importlib import import_module, metadata

    for point in metadata.entry_points(group=GROUP):
        try:
            module = import_module(point.module)
        except Exception as error:
            end_of_path = point.module.replace(".", os.sep)
            raise UsageError(f"plugin {point.name} ({point.value}) {_failed(error, end_of_path)}") from error
        with open(module.__file__, "rb") as file:
            digest = hashlib.sha256(file.read()).hexdigest()
        _register(f"{point.dist.name if point.dist else point.name}:{point.module}", digest, module)


def _any_installed():
    """Return whether an installed package has such an entry point; importlib.metadata would take longer."""
    for folder in dict.fromkeys(sys.path):
        for name in glob("*.*-info/entry_points.txt", root_dir=folder or "."):
            with open(os.path.join(folder, name), "rb") as file:
                if f"[{GROUP}]".encode() in file.read():
                    return True
    return False


def _run(source, path, name):
    spec = spec_from_file_location(name, source)
    if spec is None:
        raise UsageError(f"plugin {path} is not a Python file: its name must end with .py")
    module = module_from_spec(spec)
    sys.modules[name] = module
    try:
        spec.loader.exec_module(module)
    except (Exception, SystemExit, GeneratorExit) as error:  # a script that ends itself would end mecano, as if done
        del sys.modules[name]
        raise UsageError(f"plugin {path} {_failed(error, source)}") from error
    return module


def _failed(error, source):
    """Return the error of a module as text, with the last line of the module that was reached."""
    from traceback import extract_tb  # not needed by plugins without errors

    lines = [frame.lineno for frame in extract_tb(error.__traceback__) if source in frame.filename]
    line = error.lineno if isinstance(error, SyntaxError) else lines[-1] if lines else None
    return f"cannot be run: {'' if line is None else f'line {line}: '}{type(error).__name__}: {error}"


def _register(source, digest, module):
    from mecano.elements.plugin_registry import register  # with all laws, which a run without plugins need not import

    _loaded[source] = Plugin(source, digest, register(source, module))
