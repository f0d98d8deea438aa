"""SSPs and their FMUs, made in the tests as another maker's tool might write them."""

from __future__ import annotations

import zipfile
from functools import cache
from pathlib import Path

from fmus.toolchain.version import Version
from tests.fmus.foreign import description2, description3, kept_folder, library, pack, scalar

SPACES = " ".join(
    f'xmlns:{short}="http://ssp-standard.org/SSP1/SystemStructure{name}"'
    for short, name in {
        "ssd": "Description",
        "ssc": "Common",
        "ssv": "ParameterValues",
        "ssm": "ParameterMapping",
        "ssb": "SignalDictionary",
    }.items()
)
UNITS = {
    "m": 'm="1"',
    "km": 'm="1" factor="1000"',
    "s": 's="1"',
    "m/s": 'm="1" s="-1"',
    "km/h": 'm="1" s="-1" factor="0.2777777777777778"',
    "degC": 'K="1" offset="273.15"',
    "K": 'K="1"',
}


@cache
def echo_library(version: Version) -> Path:
    """The library of an FMU whose variable k comes out at k + 100 after a step."""
    return library(kept_folder() / f"echo{version}", version, f'#include "echo{version}.c"')


def echo(path: Path, inputs, parameters=(), *, types="", outputs=None) -> Path:
    """An FMI 2.0 FMU that shows its inputs, and its parameters, after each step: `u` comes out as `y_u`.

    Variables are `name`, or (name, type, start, attributes of the type).
    """
    units = "".join(f'<Unit name="{name}"><BaseUnit {base}/></Unit>' for name, base in UNITS.items())
    variables, unknowns = [], []
    for k, (causality, given) in enumerate([*(("input", v) for v in inputs), *(("parameter", v) for v in parameters)]):
        name, kind, start, of = (given, "Real", "0", {}) if isinstance(given, str) else (*given, {})[:4]
        more = {f"of_{n}": v for n, v in of.items()}
        variability = {"variability": "tunable"} if causality == "parameter" else {}
        if kind != "Real" and causality == "input":
            variability = {"variability": "discrete"}
        variables.append(scalar(name, k, causality, kind, of_start=start, **more, **variability))
        variability = {"variability": "discrete"} if kind != "Real" else {}
        if outputs is None or name in outputs:
            variables.append(scalar(f"y_{name}", k + 100, "output", kind, **more, **variability))
            unknowns.append(f'<Unknown index="{len(variables)}" dependencies=""/>')
    before = f"<UnitDefinitions>{units}</UnitDefinitions>" + (
        f"<TypeDefinitions>{types}</TypeDefinitions>" if types else ""
    )
    text = description2(variables, unknowns, before=before, initial=unknowns)
    return pack(path, Version.FMI2, text, echo_library(Version.FMI2))


def vectors(path: Path) -> Path:
    """An FMI 3.0 FMU that shows after each step: v (3 elements), w (n elements), the scalar s and the binary b."""
    variables, structure = [], []
    for name, reference, kind, size, start in (
        ("v", 20, "Float64", '<Dimension start="3"/>', 'start="1 2 3"'),
        ("w", 23, "Float64", '<Dimension valueReference="90"/>', 'start="5 5"'),
        ("s", 1, "Float64", "", 'start="0"'),
        ("b", 2, "Binary", "", ""),
    ):
        first = '<Start value="00ff"/>' if kind == "Binary" else ""
        own = 'variability="discrete"' if kind == "Binary" else ""
        read = f'name="{name}" valueReference="{reference}" causality="input" {own} {start}'
        shown = f'name="y_{name}" valueReference="{reference + 100}" causality="output" {own}'
        variables += [f"<{kind} {read}>{size}{first}</{kind}>", f"<{kind} {shown}>{size}</{kind}>"]
        structure.append(f'<Output valueReference="{reference + 100}" dependencies=""/>')
    length = 'name="n" valueReference="90" causality="structuralParameter" variability="fixed" start="2"'
    text = description3([*variables, f"<UInt64 {length}/>"], structure)
    return pack(path, Version.FMI3, text, echo_library(Version.FMI3))


def ssd(system: str, *, version: str = "1.0", end: str = '<ssd:DefaultExperiment stopTime="0.3"/>', units=True) -> str:
    """A description with a system, given as the content of its root `System`."""
    defined = "".join(f'<ssc:Unit name="{name}"><ssc:BaseUnit {base}/></ssc:Unit>' for name, base in UNITS.items())
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<ssd:SystemStructureDescription {SPACES} version="{version}" name="theirs">
<ssd:System name="root">
{system}
</ssd:System>
{f"<ssd:Units>{defined}</ssd:Units>" if units else ""}
{end}
</ssd:SystemStructureDescription>
"""


def write(path: Path, system: str, files=None, **changed) -> Path:
    """An SSP; `files` are by path in the archive, as text, bytes, or files to take."""
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("SystemStructure.ssd", ssd(system, **changed) if "<?xml" not in system else system)
        for name, content in (files or {}).items():
            archive.writestr(name, content.read_bytes() if isinstance(content, Path) else content)
    return path


def connectors(*given: str, kind: str = "Real") -> str:
    """Connectors: `u:input`, `y:output:m/s`."""
    made = []
    for text in given:
        name, role, *unit = text.split(":")
        attributes = f' unit="{unit[0]}"' if unit else ""
        made.append(f'<ssd:Connector name="{name}" kind="{role}"><ssc:{kind}{attributes}/></ssd:Connector>')
    return f"<ssd:Connectors>{''.join(made)}</ssd:Connectors>"


def component(name: str, source: str, inside: str = "", attributes: str = "") -> str:
    """A component with its connectors and bindings."""
    return f'<ssd:Component name="{name}" source="resources/{source}" {attributes}>\n{inside}\n</ssd:Component>'


def wire(start: str, end: str, inside: str = "", attributes: str = "") -> str:
    """A connection: `a.y` to `b.u`; a name without a dot is a connector of the system."""
    ends = []
    for side, path in (("start", start), ("end", end)):
        element, dot, name = path.partition(".")
        ends.append(f'{side}Element="{element}" {side}Connector="{name}"' if dot else f'{side}Connector="{path}"')
    return f"<ssd:Connection {' '.join(ends)} {attributes}>{inside}</ssd:Connection>\n"


def linear(factor: float, offset: float = 0) -> str:
    """A linear transformation, inside a connection or an entry of a mapping."""
    return f'<ssc:LinearTransformation factor="{factor}" offset="{offset}"/>'


def system(name: str, elements: str, wires: str = "", before: str = "") -> str:
    """A nested system."""
    return f'<ssd:System name="{name}">\n{before}{body(elements, wires)}</ssd:System>\n'


def body(elements: str, wires: str = "", after: str = "") -> str:
    """Elements and connections of a system."""
    connected = f"<ssd:Connections>\n{wires}</ssd:Connections>" if wires else ""
    return f"<ssd:Elements>\n{elements}\n</ssd:Elements>\n{connected}{after}"


def values(**given) -> str:
    """A parameter set: numbers, or (type, value, unit)."""
    parameters = []
    for name, value in given.items():
        kind, text, unit = value if isinstance(value, tuple) else ("Real", value, None)
        of = f' unit="{unit}"' if unit else ""
        parameters.append(f'<ssv:Parameter name="{name}"><ssv:{kind} value="{text}"{of}/></ssv:Parameter>')
    defined = "".join(f'<ssc:Unit name="{name}"><ssc:BaseUnit {base}/></ssc:Unit>' for name, base in UNITS.items())
    return (
        f'<ssv:ParameterSet {SPACES} version="1.0" name="set"><ssv:Parameters>{"".join(parameters)}</ssv:Parameters>'
        f"<ssv:Units>{defined}</ssv:Units></ssv:ParameterSet>"
    )


def binding(inside: str = "", attributes: str = "", mapping: str = "") -> str:
    """A parameter binding: values inline, or a source among the attributes."""
    content = f"<ssd:ParameterValues>{inside}</ssd:ParameterValues>" if inside else ""
    return f"<ssd:ParameterBinding {attributes}>{content}{mapping}</ssd:ParameterBinding>"


def bindings(*given: str) -> str:
    """All parameter bindings of an element."""
    return f"<ssd:ParameterBindings>{''.join(given)}</ssd:ParameterBindings>"
