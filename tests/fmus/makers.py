"""FMUs in the manner of well-known makers: their names, flags, orders, encodings and breaches around one drive.

The descriptions stand in `makers`, the equations in `c/models/drive.h`.
"""

from __future__ import annotations

import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

from lxml import etree

from fmus.toolchain.platform_names import binary_path
from fmus.toolchain.version import Version
from tests.fmus.foreign import C, functions, kept_folder, library
from tests.fmus.reference_fmus import EXACT

DESCRIPTIONS = Path(__file__).parent / "makers"
_NOT_FOR_CO_SIMULATION = ("ModelExchange", "Scheduled", "Continuous", "Nominals", "EventIndicators", "SetTime")
"""Parts of the names of the functions that only other interface types of FMI 3.0 need."""


@dataclass(frozen=True)
class Maker:
    """How one maker's FMU is, and how it is run."""

    angle: str
    """The name of the angle, which is recorded with what else there is."""
    torque: str
    """The name of the input."""
    parameters: Mapping[str, Any]
    """Values that differ from those of the file."""
    flags: Sequence[str] = ()
    """What its library does otherwise."""
    lenient: bool = False
    """Whether it breaks a rule."""
    held: Mapping[str, Any] = field(default_factory=dict[str, Any])
    """Values of its other inputs."""
    files: Mapping[str, str] = field(default_factory=dict[str, str])
    """What else is inside: texts by their paths."""
    h: float = 0.01
    start: float = 0.0
    without: bool = False
    """Whether its library has the functions of Co-Simulation only."""


_TABLE = {"resources/table.txt": "1.25\n"}
MAKERS: Mapping[str, Maker] = {
    "dymola": Maker(
        "phi", "tau", {"inertia1.J": 2.5, "damper.d": 0.2, "gear": 2}, ["-DBY_TYPE", "-DTABLE"],
        files={**_TABLE, "documentation/_main.html": "<html/>", "binaries/win64/Vehicle_Tests_Drive.dll": "MZ"},
    ),
    "dymola3": Maker("inertia1.phi", "tau", {"inertia1.J": 2.5, "gear": 2}, ["-DTABLE"], lenient=True, files=_TABLE),
    "openmodelica": Maker(
        "phi", "tau", {"J": 2.5}, ["-DBY_TYPE", "-DTABLE", "-DDUMMY_STATE"], h=0.002,
        files={**_TABLE, "resources/Drive_info.json": "{}", "sources/Drive.c": "#error not meant to be compiled"},
    ),
    "simulink": Maker(
        "Winkelgr\u00f6\u00dfe \u03c6", "In[1]", {"J": 2.5, "Gear": 2}, ["-DONLY_CO_SIMULATION", "-DONLY_ONCE"],
        h=0.001, held={"In[2]": 0.5, "enable torque": True}, without=True,
        files={
            "terminalsAndIcons/terminalsAndIcons.xml": (DESCRIPTIONS / "simulink_terminals.xml").read_text("utf-8"),
            "binaries/x86_64-windows/drive.dll": "MZ",
        },
    ),
    "twentysim": Maker(
        "Shaft phi", "tau", {"parameters.Shaft\\J": 2.5, "parameters.D\u00e4mpfer\\d": 0.2},
        ["-DLOADS_STARTS", "-DONLY_ONCE"], files={"binaries/win32/Drive.dll": "MZ", "binaries/win64/Drive.dll": "MZ"},
    ),
    "maplesim": Maker("Main.'I_Drive'.phi", "tau", {"Main.I.J": 2.5}),
    "amesim": Maker(
        "expseu_.phi", "expseu_.tau", {"inertia 1 [RL01].moment of inertia": 2.5, "gearbox.usage": 2}, ["-DBY_TYPE"]
    ),
    "hopsan": Maker("angle_out", "torque_in", {"Shaft#J": 2.5}, lenient=True),
    "hopsan3": Maker("angle_out", "torque_in", {"Shaft#J": 2.5}, lenient=True),
    "jmodelica": Maker("y[1]", "u[1]", {"inertia.J": 2.5, "_gear": 2}, ["-DBY_TYPE"], start=-0.5, held={"u[2]": 0.5}),
    "dymola1": Maker("phi", "tau", {"J": 2.5, "gear": 2}, ["-DBY_TYPE"]),
    "simulationx1": Maker("outPhi", "inM", {"Tr\u00e4gheit.J": 2.5}),
}  # fmt: skip


def description(name: str) -> bytes:
    """The model description as the maker writes it."""
    return (DESCRIPTIONS / f"{name}.xml").read_bytes()


def version_of(name: str) -> Version:
    """The version of FMI."""
    return Version(int(etree.fromstring(description(name)).get("fmiVersion")[0]))


@cache
def _library(name: str, *, complete: bool) -> Path:
    maker, version = MAKERS[name], version_of(name)
    root = etree.fromstring(description(name))
    token = root.get("guid") or root.get("instantiationToken")
    flags = ['-DMODEL="models/drive.h"', f'-DTOKEN="{token}"', EXACT]
    flags += [flag for flag in maker.flags if not (complete and flag == "-DONLY_CO_SIMULATION")]
    flags += ["-DHAS_EVENTS"] if 'hasEventMode="true"' in description(name).decode("latin-1") else []
    absent = [n for n in functions(version) if any(part in n for part in _NOT_FOR_CO_SIMULATION)]
    absent = absent if maker.without and not complete else []
    where = kept_folder() / f"maker-{name}{'-complete' * complete}"
    model = root.get("modelIdentifier", "")
    flags += [f"-DID={model}"] if version is Version.FMI1 else []
    source = f'#include "reference{version}.c"'
    return library(where, version, source, *flags, absent=absent, model=model)


@cache
def maker_fmu(name: str, *, sources: bool = False, complete: bool = False) -> Path:
    """The FMU of a maker, compiled once for all tests.

    Args:
        name: The maker, one of `MAKERS`.
        sources: Whether it has sources, whose functions have a prefix, instead of a library for this platform.
        complete: Whether its library has functions that its maker leaves out.
    """
    maker, version = MAKERS[name], version_of(name)
    root = etree.fromstring(description(name))
    path = kept_folder() / f"{name}{'-sources' * sources}{'-complete' * complete}.fmu"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("modelDescription.xml", description(name))
        for file, text in maker.files.items():
            archive.writestr(file, text)
        if sources:
            for file in ("reference2.c", "reference.h", "models/drive.h"):
                archive.writestr(f"sources/{file}", (C / file).read_text())
            archive.writestr("sources/drive.c", _prefixed(root, maker.flags))
            return path
        for identifier in {e.get("modelIdentifier") for e in (root, *root) if e.get("modelIdentifier")}:
            archive.write(_library(name, complete=complete), binary_path(version, identifier))
    return path


def _prefixed(root: Any, flags: Sequence[str]) -> str:
    """A source file whose functions have the model identifier in front, as the header of FMI 2.0 makes them have it."""
    prefix = f"{root.find('CoSimulation').get('modelIdentifier')}_"
    defined = ['MODEL "models/drive.h"', f'TOKEN "{root.get("guid")}"', *(flag[2:] for flag in flags)]
    defined += [f"{name} {prefix}{name}" for name in functions(Version.FMI2)]
    return "\n".join(f"#define {text}" for text in defined) + '\n#include "reference2.c"\n'
