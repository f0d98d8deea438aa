"""FMUs of other makers, made in the tests: C sources, compiled and packed with a model description."""

from __future__ import annotations

import atexit
import inspect
import shutil
import subprocess
import tempfile
import zipfile
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path

import fmpy
from fmpy import fmi1, fmi2, fmi3

from fmus.toolchain.compiler import required_compiler
from fmus.toolchain.platform_names import binary_path
from fmus.toolchain.version import Version

C = Path(__file__).parent / "c"
HEADERS = Path(fmpy.__file__).parent / "c-code"
_KINDS = {
    Version.FMI1: (fmi1.FMU1Slave, fmi1.FMU1Model),
    Version.FMI2: (fmi2.FMU2Slave, fmi2.FMU2Model),
    Version.FMI3: (fmi3.FMU3Slave, fmi3.FMU3Model, fmi3.FMU3ScheduledExecution),
}


def functions(version: Version, model: str = "m") -> list[str]:
    """The names of all functions of FMI; those of FMI 1.0 begin with the model."""
    names = {n for kind in _KINDS[version] for n, _ in inspect.getmembers(kind) if n.startswith(f"fmi{version}")}
    found = sorted(n for n in names if n[4].isupper())
    return [f"{model}_fmi{name[4:]}" for name in found] if version == Version.FMI1 else found


@cache
def kept_folder() -> Path:
    """Where files lie that are made once for all tests; it goes when they have ended."""
    folder = tempfile.mkdtemp(prefix="macrostep_test_")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return Path(folder)


def library(
    folder: Path, version: Version, source: str, *options: str, absent: Sequence[str] = (), model: str = "m"
) -> Path:
    """Compile C, given as text; functions of FMI that it leaves out do nothing, successfully, or are `absent`."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "source.c").write_text(source)
    stubs = [f"__attribute__((weak)) int {n}() {{ return 0; }}" for n in functions(version, model) if n not in absent]
    (folder / "stubs.c").write_text(_lines(stubs) + "\n")
    target = folder / "library.so"
    flags = ["-O1", "-w", "-fPIC", "-shared", f"-I{HEADERS}", f"-I{C}", *options]
    files = [str(folder / "source.c"), str(folder / "stubs.c")]
    subprocess.run([*required_compiler().command, *flags, *files, "-o", str(target), "-lm"], check=True)
    return target


def pack(path: Path, version: Version, description: str, binary: Path | None, **files: str | bytes) -> Path:
    """Write an FMU named `m` inside; `files` have `__` for `/` in their names."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("modelDescription.xml", description)
        if binary is not None:
            archive.write(binary, binary_path(version, "m"))
        for name, content in files.items():
            archive.writestr(name.replace("__", "/").replace("_txt", ".txt"), content)
    return path


SLAVE1 = "<Implementation><CoSimulation_StandAlone><Capabilities/></CoSimulation_StandAlone></Implementation>"


def description1(
    variables: Sequence[str],
    *,
    implementation: str = SLAVE1,
    guid: str = "g",
    counts: tuple[int, int] = (0, 0),
    before: str = "",
) -> str:
    """An FMI 1.0 model description, of Co-Simulation; `counts` are those of states and event indicators."""
    numbers = f'numberOfContinuousStates="{counts[0]}" numberOfEventIndicators="{counts[1]}"'
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="1.0" modelName="m" modelIdentifier="m" guid="{guid}" {numbers}>
{before}
<ModelVariables>
{_lines(variables)}
</ModelVariables>
{implementation}
</fmiModelDescription>
"""


def scalar1(name: str, reference: int, kind: str = "Real", *, depends: str | None = None, **attributes: str) -> str:
    """A ScalarVariable of FMI 1.0; attributes of the type after `of_`, and the inputs that an output depends on."""
    of = " ".join(f'{n[3:]}="{v}"' for n, v in attributes.items() if n.startswith("of_"))
    own = " ".join(f'{n}="{v}"' for n, v in attributes.items() if not n.startswith("of_"))
    names = "".join(f"<Name>{name}</Name>" for name in (depends or "").split())
    direct = "" if depends is None else f"<DirectDependency>{names}</DirectDependency>"
    return f'<ScalarVariable name="{name}" valueReference="{reference}" {own}><{kind} {of}/>{direct}</ScalarVariable>'


def description2(
    variables: Sequence[str],
    outputs: Sequence[str] = (),
    *,
    interface: str = '<CoSimulation modelIdentifier="m"/>',
    guid: str = "g",
    attributes: str = "",
    before: str = "",
    derivatives: Sequence[str] = (),
    initial: Sequence[str] = (),
) -> str:
    """An FMI 2.0 model description; `variables` are ScalarVariable elements, the others Unknown elements."""
    parts = {"Outputs": outputs, "Derivatives": derivatives, "InitialUnknowns": initial}
    structure = "".join(f"<{name}>{''.join(items)}</{name}>" for name, items in parts.items() if items)
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="m" guid="{guid}" {attributes}>
{interface}
{before}
<ModelVariables>
{_lines(variables)}
</ModelVariables>
<ModelStructure>{structure}</ModelStructure>
</fmiModelDescription>
"""


def scalar(name: str, reference: int, causality: str, kind: str = "Real", **attributes: str) -> str:
    """A ScalarVariable of FMI 2.0; attributes of the type after `of_`."""
    of = " ".join(f'{n[3:]}="{v}"' for n, v in attributes.items() if n.startswith("of_"))
    own = " ".join(f'{n}="{v}"' for n, v in attributes.items() if not n.startswith("of_"))
    common = f'name="{name}" valueReference="{reference}" causality="{causality}"'
    return f"<ScalarVariable {common} {own}><{kind} {of}/></ScalarVariable>"


def description3(
    variables: Sequence[str],
    structure: Sequence[str] = (),
    *,
    interface: str = '<CoSimulation modelIdentifier="m"/>',
    guid: str = "g",
    before: str = "",
    version: str = "3.0",
) -> str:
    """An FMI 3.0 model description; `variables` and `structure` are elements; the time is added."""
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="{version}" modelName="m" instantiationToken="{guid}">
{interface}
{before}
<ModelVariables>
<Float64 name="time" valueReference="0" causality="independent" variability="continuous"/>
{_lines(variables)}
</ModelVariables>
<ModelStructure>
{_lines(structure)}
</ModelStructure>
</fmiModelDescription>
"""


def entries(path: Path) -> dict[str, bytes]:
    """All files in an FMU or SSP, by their paths."""
    with zipfile.ZipFile(path) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def copied(path: Path, target: Path, changed: Mapping[str, bytes | None]) -> Path:
    """An FMU with files changed, added, or left out (None)."""
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as made:
        for name, content in {**entries(path), **changed}.items():
            if content is not None:
                made.writestr(name, content)
    return target


def _lines(items: Sequence[str]) -> str:
    return "\n".join(items)
