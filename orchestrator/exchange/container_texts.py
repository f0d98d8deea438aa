"""Start values of String variables in a container, whose toolbox separates them by blanks and line breaks."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from lxml import etree

from components.interfaces.problem import Problem
from components.interfaces.quantity import Type
from orchestrator.ssp.element_names import element_names, is_fmi2
from orchestrator.system.system import System


def start_texts(system: System) -> dict[tuple[str, str], list[str]]:
    """The texts of all elements of String parameters and held inputs, by unit and name as the FMU spells it."""
    found: dict[tuple[str, str], list[str]] = {}
    old = is_fmi2(system)
    for unit, source in system.units.items():
        for role, values in (("parameters", source.parameters), ("inputs", system.held_by(unit))):
            for variable in getattr(source.interface, role):
                if variable.quantity.type is Type.STRING and variable.name in values:
                    texts = np.ravel(np.asarray(values[variable.name], dtype=object)).tolist()
                    names = element_names(source, variable.name, role, flat=old)
                    found |= {(unit, name): [texts[i]] if old else texts for i, name in enumerate(names)}
    return found


def text_problems(system: System) -> Iterator[Problem]:
    """The texts that a container cannot hold: its configuration has one line for each."""
    for (unit, name), texts in start_texts(system).items():
        if any("\n" in text or "\r" in text for text in texts):
            yield Problem(f"{unit}.{name}", "a text with a line break", "a text of one line", "Set it to another text.")


def configure(container: Any, port_class: type[Any], system: System) -> None:
    """Give a container the texts as they are: its own function takes a blank for the end of a text.

    Args:
        container: The toolbox's container, in which each of these variables has a start value already.
        port_class: The toolbox's class of the ports that start values belong to.
        system: The system.
    """
    for (unit, name), texts in start_texts(system).items():
        port = port_class(container.get_fmu(f"{unit}.fmu"), name)
        container.start_values[port] = "\n" + "\n".join(texts)


def describe_texts(variables: Any, texts: Mapping[tuple[str, str], Sequence[str]]) -> None:
    """Write the texts into the variables of a model description, in which the toolbox has them with a line break."""
    by_name = {f"{unit}.{name}": values for (unit, name), values in texts.items()}
    for variable in variables:
        values = by_name.get(str(variable.get("name")))
        if values is None:
            continue
        if variable.tag == "ScalarVariable":
            variable[0].set("start", values[0])
            continue
        for start in variable.findall("Start"):
            variable.remove(start)
        for value in values:
            etree.SubElement(variable, "Start", value=value)
