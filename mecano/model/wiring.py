"""Connect the inputs of elements to the signals, sensors and formulas that determine them."""

import numpy as np

from mecano.elements.signals.formula import FORMULA
from mecano.laws.formula import read_formula
from mecano.model.instance import Instance
from mecano.model.measured import meaning, sensor_of_node, sensor_of_output
from mecano.model.model import title_of

DIVISION = "\N{DIVISION SLASH}"  # in the name of a formula, since / separates groups of the results file


def wire(instances, model, context):
    """Set ``inputs`` of all instances that read formulas; sensors, and formulas written in place, are appended."""
    wiring = _Wiring(instances, model, context)
    for item in instances:  # the list grows
        item.inputs = tuple(wiring.source(text) for text in item.reads)


class _Wiring:
    """Sources of inputs (signals, sensors, formulas), by the text of the formula."""

    def __init__(self, instances, model, context):
        self.instances, self.model, self.context = instances, model, context
        self.nodes = {node.name: i for i, node in enumerate(model.nodes)}
        self.elements = {(element.kind.section, element.name): element for element in model.elements}
        self.kinds = {place: element.kind for place, element in self.elements.items()}
        self.sources = {
            item.path.partition("/")[2]: i for i, item in enumerate(instances) if item.kind.section == "signals"
        }

    def source(self, text):
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
        path = f"formulas/{text.replace('/', DIVISION)}"
        self.instances.append(Instance(owner, path, kind, nodes, record, reads=kind.read(values)))
        return len(self.instances) - 1

    def _of_reference(self, name):
        if name in self.sources:
            return self.sources[name]
        section, owner, what = meaning(name, self.kinds, self.nodes)
        if section == "nodes":
            title, part, nodes = f"node '{owner}'", sensor_of_node(what), (self.nodes[owner],)
        else:
            element = self.elements[section, owner]
            nodes = tuple(self.nodes[node] for node in element.nodes)
            frames = [(np.asarray(self.model.nodes[i].x, float), self.model.nodes[i].R) for i in nodes]
            title = title_of(element.kind.name, owner)
            part = sensor_of_output(element.kind, what, element.values, frames, self.context)
        on = tuple(nodes[i] for i in part.nodes)
        self.instances.append(
            Instance(f"{title}: {what}", f"sensors/{name}", part.kind, on, part.parameters, reads=part.reads)
        )
        self.sources[name] = len(self.instances) - 1
        return self.sources[name]
