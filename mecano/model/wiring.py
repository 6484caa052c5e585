"""Connect the inputs of elements to the signals, sensors and formulas that determine them."""

from collections.abc import Sequence

import numpy as np

from mecano.constraints.output_sensor import output_sensor, outputs_of, sum_of
from mecano.constraints.sensors import NODE_SENSORS, SENSORS
from mecano.element_interface import Context, Kind, OwnOutput, Part
from mecano.elements.signals.formula import FORMULA
from mecano.laws.formula import read_formula
from mecano.model.instance import Instance
from mecano.model.measured_outputs import AXES, MAGNITUDE, index_of, magnitude_of, powers
from mecano.model.mesh import Frame
from mecano.model.model import Model, title_of
from mecano.model.quantity_names import resolve
from mecano.schema import Values

IN_PLACE = "formulas/"  # section of the formulas that are written in place
DIVISION = "\N{DIVISION SLASH}"  # in the name of a formula, since / separates groups of the results file


def path_of(text: str) -> str:
    """Return the path of a formula that is written in place."""
    return f"{IN_PLACE}{text.replace('/', DIVISION)}"


def text_of(path: str) -> str:
    """Return the formula of a path of ``path_of``."""
    return path.removeprefix(IN_PLACE).replace(DIVISION, "/")


def wire(instances: list[Instance], model: Model, context: Context) -> set[str]:
    """Set ``inputs`` of all instances that read formulas; sensors, and formulas written in place, are appended.

    Return the paths of the elements whose hidden outputs are read.
    """
    wiring = _Wiring(instances, model, context)
    for item in instances:  # the list grows
        item.inputs = tuple(wiring.input_of(item, one) for one in item.reads)
    return wiring.hidden


class _Wiring:
    """Sources of inputs: signals, sensors, formulas, own outputs."""

    def __init__(self, instances: list[Instance], model: Model, context: Context):
        self.instances, self.model, self.context = instances, model, context
        self.nodes = {node.name: i for i, node in enumerate(model.nodes)}
        self.elements = {(element.kind.section, element.name): element for element in model.elements}
        self.entries = {place: (element.kind, element.values) for place, element in self.elements.items()}
        self.sources: dict[str | tuple[str, str], int] = {  # by formula, or path and name of an own output
            item.path.partition("/")[2]: i for i, item in enumerate(instances) if item.kind.section == "signals"
        }
        self.hidden: set[str] = set()  # paths of the elements whose hidden outputs are read

    def input_of(self, item: Instance, one: str | OwnOutput) -> int:
        """Return the list index of the source of an input, a formula or an OwnOutput; append it if new.

        A sensor has the inputs of the instance that it senses.
        """
        if not isinstance(one, OwnOutput):
            return self.source(one)
        owner = item if item.senses is None else self.instances[item.senses]
        key = owner.path, one.name
        if key not in self.sources:
            self.sources[key] = self._of_observed(f"{owner.owner}: {one.name}", owner.path, one.name)
        return self.sources[key]

    def source(self, text: str) -> int:
        """Return the list index of the instance whose first scalar is the value of a formula; append it if new."""
        if text not in self.sources:
            formula = read_formula(text)
            if formula.reference:
                self.sources[text] = self._of_reference(formula.reference)
            else:
                self.sources[text] = self._append(f"formula '{text}'", FORMULA.chosen({"value": text}), (), text)
        return self.sources[text]

    def _append(self, owner, kind, nodes, text):
        values = {"value": text}
        record = kind.record_values(values, (), self.context)
        self.instances.append(Instance(owner, path_of(text), kind, nodes, record, reads=kind.read(values)))
        return len(self.instances) - 1

    def _of_reference(self, name):
        if name in self.sources:
            return self.sources[name]
        if name.endswith(MAGNITUDE):
            return self.source(magnitude_of(name.removesuffix(MAGNITUDE)))
        section, owner, what = resolve(name, self.entries, self.nodes)
        nodes: tuple[int, ...]
        part: Part | None
        if section == "nodes":
            title, part, nodes = f"node '{owner}'", _sensor_of_node(what), (self.nodes[owner],)
        else:
            element = self.elements[section, owner]
            power = powers(element.kind.chosen(element.values)).get(what)
            if power is not None:
                self.sources[name] = self._of_powers(f"{title_of(element.kind.name, owner)}: {what}", name, power)
                return self.sources[name]
            nodes = tuple(self.nodes[node] for node in element.nodes)
            frames = [(np.asarray(self.model.nodes[i].x, float), self.model.nodes[i].R) for i in nodes]
            title = title_of(element.kind.name, owner)
            part = _sensor_of_output(element.kind, what, element.values, frames, self.context)
        if part is None:
            self.sources[name] = self._of_observed(f"{title}: {what}", f"{section}/{owner}", what)
            return self.sources[name]
        on = tuple(nodes[i] for i in part.nodes)
        self.instances.append(
            Instance(f"{title}: {what}", f"sensors/{name}", part.kind, on, part.parameters, reads=part.reads)
        )
        self.sources[name] = len(self.instances) - 1
        return self.sources[name]

    def _of_observed(self, title, path, what):
        """Append the sensor of an output that ``observe`` of an element, or of one of its parts, writes."""
        for i, item in [(i, item) for i, item in enumerate(self.instances) if item.path == path]:
            if (index := index_of(what, item.kind, item.label)) is not None:
                if what.partition(".")[0] in item.kind.hidden:
                    self.hidden.add(path)
                return self._append_sensor(title, i, item, index)
        raise AssertionError(f"{what} is not an output of {path}")

    def _of_powers(self, title, name, power):
        """Append the sum of a power over an element and its parts, and their sensors; ``power``: its index."""
        section, owner, what = resolve(name, self.entries, self.nodes)
        path, terms = f"{section}/{owner}", []
        for i, item in [(i, item) for i, item in enumerate(self.instances) if item.path == path and item.kind.observe]:
            terms.append(f"{name} of {i}")  # no formula has such a text
            self.sources[terms[-1]] = self._append_sensor(title, i, item, outputs_of(item.kind) + power)
        self.instances.append(Instance(title, f"sensors/{path}/{what}", sum_of(len(terms)), (), {}, reads=tuple(terms)))
        return len(self.instances) - 1

    def _append_sensor(self, title, i, item, index):
        coupled = (i, *(item.coupled_to if item.kind.acts else range(i + 1, i + 1 + item.n_parts)))
        n_multipliers = sum(len(self.instances[j].kind.multipliers) for j in coupled)
        kind, record = output_sensor(item.kind, n_multipliers), {**item.parameters, "sensed": index}
        path = f"sensors/{item.path}/{index}"
        self.instances.append(Instance(title, path, kind, item.nodes, record, 0, coupled, reads=item.reads, senses=i))
        return len(self.instances) - 1


def _sensor_of_node(what: str) -> Part:
    """Return the Part of the sensor of a component of the motion of a node: position.z."""
    quantity, _, axis = what.partition(".")
    values = {"direction": np.eye(3)[AXES.index(axis)]}
    if quantity == "position":
        values |= {"origin": np.zeros(3), "zero": 0.0}
    return Part(NODE_SENSORS[quantity], (0,), values)


def _sensor_of_output(
    kind: Kind, output: str, values: Values, frames: Sequence[Frame], context: Context
) -> Part | None:
    """Return the Part of the sensor of a coordinate of an element or of its rate, at ``frames`` [(x, R)], or None."""
    for name in (output, *(o.name for o in kind.outputs if o.rate == output)):
        if name in kind.measures:
            return _sensor_of_coordinate(kind.measures[name](values, frames, context), int(name != output))
    return None


def _sensor_of_coordinate(found, which):
    return Part(SENSORS[found.coordinate][which], found.nodes, {**found.axes, "zero": found.zero})
