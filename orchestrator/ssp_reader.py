"""Reading a system back from an SSP file that `ssp` wrote."""

from __future__ import annotations

import atexit
import json
import re
import shutil
import tempfile
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from lxml import etree

from components.interfaces.problem import raise_if_any, refuse
from components.interfaces.quantity import Type
from components.interfaces.record import Variable
from components.interfaces.sockets import SOCKETS
from orchestrator.parameters import Given, Setting, values_of
from orchestrator.scenario import Scenario, block_named
from orchestrator.scene import Scene
from orchestrator.ssp import BLOCK_SOURCE, BLOCK_TYPE, OURS, SSD, SSV
from orchestrator.system import Fmu, InProcess, Source, System

_NS = {"ssd": SSD, "ssv": SSV, "m": OURS}
_INDEX = re.compile(r"\[[\d,]+\]$")


def read(
    path: Path,
    settings: Mapping[str, Sequence[Setting]] | None = None,
    step: float | None = None,
    stop_time: float | None = None,
) -> Scenario:
    """The system and experiment in an `.ssp` file, with a person's changes. Raises `RequestError`."""
    where = str(path)
    valid = "an SSP file written by macrostep"
    if not zipfile.is_zipfile(path):
        raise refuse(where, "a file that is no zip archive" if path.exists() else "no such file", valid)
    folder = Path(tempfile.mkdtemp(prefix="macrostep_ssp_"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    with zipfile.ZipFile(path) as archive:
        for name in archive.namelist():
            if not (folder / name).resolve().is_relative_to(folder.resolve()):
                raise refuse(where, f"an entry that would leave the folder, {name}", valid)
        archive.extractall(folder)
    try:
        root = etree.parse(folder / "SystemStructure.ssd", etree.XMLParser(resolve_entities=False)).getroot()
    except (OSError, etree.XMLSyntaxError) as error:
        raise refuse(where, f"a SystemStructure.ssd that cannot be read ({error})", valid) from error
    notes = root.find(".//m:Scenario", _NS)
    if notes is None or not notes.text:
        raise refuse(where, "no macro step", "an SSP file with the annotation `org.macrostep`")
    made = _scenario(root, folder, json.loads(notes.text), settings or {})
    return replace(made, h=made.h if step is None else step, until=made.until if stop_time is None else stop_time)


def _scenario(
    root: Any, folder: Path, extras: Mapping[str, Any], settings: Mapping[str, Sequence[Setting]]
) -> Scenario:
    units: dict[str, Source] = {}
    sources: dict[str, Mapping[str, Any]] = dict(extras["sources"])
    for component in root.iterfind(".//ssd:Component", _NS):
        name = component.get("name")
        unit = _unit(component, folder)
        values, origins = _parameters(folder / f"resources/{name}.ssv", unit, settings.get(name, ()))
        units[name] = type(unit)(unit.block if isinstance(unit, InProcess) else unit.path, values)  # type: ignore[arg-type]
        sources |= {f"{name}.{parameter}": told for parameter, told in origins.items()}
    wiring = {
        f"{wire.get('endElement')}.{_whole(wire.get('endConnector'))}": (
            f"{wire.get('startElement')}.{_whole(wire.get('startConnector'))}"
        )
        for wire in root.iterfind(".//ssd:Connection", _NS)
    }
    system = System(
        units=units,
        wiring=wiring,
        held=extras["held"],
        sockets={name: SOCKETS[socket] for name, socket in extras["sockets"].items()},
    )
    top = root.find("ssd:System", _NS)
    return Scenario(
        name=root.get("name"),
        title=top.get("description", ""),
        system=system,
        scene=Scene(**extras["scene"]) if extras["scene"] else None,
        h=float(extras["step"]),
        until=float(root.find("ssd:DefaultExperiment", _NS).get("stopTime")),
        sources=sources,
    )


def _unit(component: Any, folder: Path) -> Source:
    source = component.get("source")
    if component.get("type") == BLOCK_TYPE:
        return InProcess(block_named(source.removeprefix(BLOCK_SOURCE), f"component {component.get('name')}"), {})
    return Fmu(folder / source)


def _parameters(
    path: Path, unit: Source, settings: Sequence[Setting]
) -> tuple[dict[str, Any], dict[str, Mapping[str, Any]]]:
    """Values of a unit's parameters, and where each comes from."""
    declared = {v.name: v for v in unit.interface.parameters}
    texts: dict[str, list[str]] = {}
    origins: dict[str, str] = {}
    for parameter in etree.parse(path).iterfind(".//ssv:Parameter", _NS):
        name = _whole(str(parameter.get("name")))
        texts.setdefault(name, []).extend(str(parameter[0].get("value")).split())
        origins[name] = parameter.get("description", "")
    given = {
        name: Given(value=_value(declared[name], found), unit=declared[name].quantity.unit, source=origins[name])
        for name, found in texts.items()
    }
    values, problems = values_of(path.stem, unit.interface.parameters, {}, given, settings)
    raise_if_any(problems)
    origins |= {s.name: "--set" for s in settings}
    return values, {n: {"value": v, "unit": declared[n].quantity.unit, "source": origins[n]} for n, v in values.items()}


def _value(variable: Variable, texts: list[str]) -> Any:
    q = variable.quantity
    if q.type is Type.BOOLEAN:
        values: list[Any] = [text in {"true", "1"} for text in texts]
    elif q.enumeration is not None:
        values = [q.enumeration[text].value for text in texts]
    else:
        values = [float(text) if q.type is Type.FLOAT64 else int(text) for text in texts]
    return np.array(values).reshape(variable.shape).tolist() if variable.shape else values[0]


def _whole(name: str) -> str:
    return _INDEX.sub("", name)
