"""terminalsAndIcons.xml (FMI 3.0): one terminal for each bus."""

from __future__ import annotations

from lxml import etree

from components.interfaces.record import groups
from fmus.export.description_parts import to_bytes
from fmus.export.fmi_variables import FmiVariables


def terminals_and_icons(variables: FmiVariables) -> bytes:
    """terminalsAndIcons.xml: a terminal has the name of its bus; its members are the signals, matched by name."""
    root = etree.Element("fmiTerminalsAndIcons", fmiVersion="3.0")
    terminals = etree.SubElement(root, "Terminals")
    block = variables.block
    for direction, record, signals in (
        ("input", block.input_type, variables.inputs),
        ("output", block.output_type, variables.outputs),
    ):
        for bus in groups(record):
            terminal = etree.SubElement(
                terminals, "Terminal", name=bus, matchingRule="bus", description=f"{direction} bus `{bus}`"
            )
            for v in signals:
                if v.name.startswith(f"{bus}."):
                    member = v.name.removeprefix(f"{bus}.")
                    names = {"variableName": v.name, "memberName": member, "variableKind": "signal"}
                    etree.SubElement(terminal, "TerminalMemberVariable", names)
    return to_bytes(root)
