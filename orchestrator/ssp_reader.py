"""Reading a system back from an SSP file that `ssp` wrote."""

from __future__ import annotations

import atexit
import json
import re
import shutil
import tempfile
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from lxml import etree

from components.interfaces.problem import refuse
from components.interfaces.quantity import Type
from components.interfaces.record import Variable
from components.interfaces.sockets import SOCKETS
from orchestrator.parameters import Setting
from orchestrator.scenario import Scenario, block_named
from orchestrator.scene import Scene
from orchestrator.ssp import BLOCK_SOURCE, BLOCK_TYPE, OURS, SSD, SSV
from orchestrator.system import Fmu, InProcess, Source, System

_NS = {"ssd": SSD, "ssv": SSV, "m": OURS}
_INDEX = re.compile(r"\[[\d,]+\]$")


def read(path: Path, settings: Mapping[str, list[Setting]] | None = None) -> Scenario:
    """The system and experiment in an `.ssp` file. Raises `RequestError`."""
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
    return _scenario(root, folder, json.loads(notes.text))


def _scenario(root: Any, folder: Path, extras: Mapping[str, Any]) -> Scenario:
    units: dict[str, Source] = {}
    sources: dict[str, Mapping[str, Any]] = dict(extras["sources"])
    for component in root.iterfind(".//ssd:Component", _NS):
        name = component.get("name")
        unit = _unit(component, folder)
        values, origins = _parameters(folder / f"resources/{name}.ssv", unit)
        units[name] = type(unit)(unit.block if isinstance(unit, InProcess) else unit.path, values)  # type: ignore[arg-type]
        sources |= {f"{name}.{parameter}": told for parameter, told in origins.items()}
    wiring = {
        f"{c.get('endElement')}.{_whole(c.get('endConnector'))}": f"{c.get('startElement')}.{_whole(c.get('startConnector'))}"
        for c in root.iterfind(".//ssd:Connection", _NS)
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


def _parameters(path: Path, unit: Source) -> tuple[dict[str, Any], dict[str, Mapping[str, Any]]]:
    declared = {v.name: v for v in unit.interface.parameters}
    texts: dict[str, list[str]] = {}
    origins: dict[str, str] = {}
    for parameter in etree.parse(path).iterfind(".//ssv:Parameter", _NS):
        name = _whole(parameter.get("name"))
        texts.setdefault(name, []).extend(parameter[0].get("value").split())
        origins[name] = parameter.get("description", "")
    values = {name: _value(declared[name], found) for name, found in texts.items()}
    told = {
        name: {
            "value": np.asarray(value).tolist(),
            "unit": declared[name].quantity.unit,
            "source": origins[name],
        }
        for name, value in values.items()
    }
    return values, told


def _value(variable: Variable, texts: list[str]) -> Any:
    q = variable.quantity
    if q.type is Type.BOOLEAN:
        values: list[Any] = [text in {"true", "1"} for text in texts]
    elif q.enumeration is not None:
        values = [q.enumeration[text].value for text in texts]
    else:
        values = [float(text) if q.type is Type.FLOAT64 else int(text) for text in texts]
    return np.array(values).reshape(q.shape) if q.shape else values[0]


def _whole(name: str) -> str:
    return _INDEX.sub("", name)
