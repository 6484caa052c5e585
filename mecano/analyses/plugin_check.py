"""Test all kinds, slip laws and terms of a plugin, for `mecano check-kind`."""

from dataclasses import replace
from traceback import walk_tb

from mecano.analyses.kind_samples import samples
from mecano.analyses.kind_tests import OF_DECK_KINDS
from mecano.analyses.law_tests import OF_SLIP_LAWS, OF_TERMS
from mecano.element_interface import Kind
from mecano.elements.plugins import Plugin
from mecano.elements.wheels.rolling_contact import law_samples
from mecano.elements.wheels.slip_law import SlipLaw
from mecano.elements.wheels.transient_wheel import with_law as transient_wheel_with_law
from mecano.elements.wheels.wheel import with_law as wheel_with_law
from mecano.errors import CompilationError
from mecano.jit.compilation_error import PLAIN_MATH
from mecano.jit.machine_code import address
from mecano.model.loop_code import all_codes

NOT_FOR_DUALS = ("not Dual", "'Dual' does not support ufuncs", "** or pow(): 'Dual'")  # in messages of Python


def check_plugin(plugin: Plugin) -> tuple[str, int]:
    """Return (text, number of failures), with one line for each test of each item of a Plugin."""
    lines, failures = [], 0
    for item in plugin.found:
        title, tests = _tests(item)
        lines.append(title)
        for name, test in tests:
            failure = _failure(test, plugin.source)
            failures += failure is not None
            lines += [
                f"  {'passed' if failure is None else 'FAILED'}  {name}",
                *([f"          {failure}"] * bool(failure)),
            ]
    return "\n".join(lines), failures


def _tests(item):
    """Return the title and [(name, function)] of the tests of a Kind, a SlipLaw or a Term."""
    if isinstance(item, Kind):
        return f"{item.name} (kind of '{item.section}')", _named((*OF_DECK_KINDS, check_compilation), item)
    if isinstance(item, SlipLaw):
        return f"{item.name} (slip law of tyres)", _named(OF_SLIP_LAWS, item) + _tests_of_wheels(item)
    return f"{item.name} (term of a law)", _named(OF_TERMS, item)


def _tests_of_wheels(law):
    """Return [(name, function)] of the tests of the wheels that can have a SlipLaw with samples."""
    if not law.sample:
        return []
    found = []
    for make in (wheel_with_law, transient_wheel_with_law) if law.carcass else (wheel_with_law,):
        wheel = replace(make(law), sample=lambda rng: law_samples(rng, law))
        found += [(f"{wheel.name}: {name}", test) for name, test in _named(OF_DECK_KINDS, wheel)]
    return found


def check_compilation(kind: Kind) -> None:
    """Functions can be compiled."""
    of_kinds = {id(instance.kind): instance.kind for sample in samples(kind) for instance in sample.instances}
    try:
        for code in all_codes(of_kinds.values()):
            address(code)
    except CompilationError as error:
        raise AssertionError(str(error)) from error


def _named(tests, item):
    """Return [(first sentence of the docstring, function without arguments)]."""
    return [(test.__doc__.split("\n")[0].rstrip("."), lambda test=test: test(item)) for test in tests]


def _failure(test, path):
    """Return the failure of a test of the plugin at ``path`` as one line, "" without a text; None if it passes."""
    try:
        test()
    except Exception as error:
        text = " ".join(str(error).split())
        return text if isinstance(error, AssertionError) else _described_error(error, text, path)
    return None


def _described_error(error, text, path):
    """Return an error with the last line of the plugin that led to it, and with the fields that ``at`` has."""
    lines = [line for frame, line in walk_tb(error.__traceback__) if frame.f_code.co_filename == path]
    known = getattr(getattr(error, "obj", None), "_fields", ())
    return (
        (f"line {lines[-1]}: " if lines else "")
        + f"{type(error).__name__}: {text}"
        + (f"; known: {', '.join(known)}" if known else "")
        + (f"; {PLAIN_MATH}" if any(sign in text for sign in NOT_FOR_DUALS) else "")
    )
