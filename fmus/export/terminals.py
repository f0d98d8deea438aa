"""terminalsAndIcons.xml (FMI 3.0): one terminal for each bus."""

from __future__ import annotations

from lxml import etree

from components.interfaces.record import groups
from fmus.export.description_parts import to_bytes
from fmus.export.fmi_variables import Interface


def terminals_and_icons(interface: Interface) -> bytes:
    """The file. A terminal has the name of its bus; its members are the signals of the bus, matched by name."""
    root = etree.Element("fmiTerminalsAndIcons", fmiVersion="3.0")
    terminals = etree.SubElement(root, "Terminals")
    block = interface.block
    for side, kind, variables in (
        ("input", block.input_type, interface.inputs),
        ("output", block.output_type, interface.outputs),
    ):
        for bus in groups(kind):
            terminal = etree.SubElement(
                terminals, "Terminal", name=bus, matchingRule="bus", description=f"{side} bus `{bus}`"
            )
            for v in variables:
                if v.name.startswith(f"{bus}."):
                    member = v.name.removeprefix(f"{bus}.")
                    names = {"variableName": v.name, "memberName": member, "variableKind": "signal"}
                    etree.SubElement(terminal, "TerminalMemberVariable", names)
    return to_bytes(root)
