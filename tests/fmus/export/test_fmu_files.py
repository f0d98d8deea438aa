"""The files in an FMU are complete, valid and reproducible.

Shows, of `fmus/export`, `content.py` and what it is made of: `model_description_fmi2.py`, `model_description_fmi3.py`,
`description_parts.py`, `dependencies.py`, `terminals.py`, `documentation.py` and `c_sources.py`; and, of
`fmus/toolchain`, `archives.py`.
"""
# pyright: basic
# FMPy and lxml's schemas carry few types.

from __future__ import annotations

import logging
import os
import re
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import fmpy
import pytest
from fmpy.build import build_platform_binary
from fmpy.validation import validate_fmu
from fmu_manipulation_toolbox.checker import get_checkers
from fmu_manipulation_toolbox.operations import FMU
from lxml import etree

from components import BLOCKS
from components.interfaces.block import Sampled
from components.interfaces.progress import SILENT
from components.interfaces.record import groups
from components.interfaces.units_of_measurement import UNITS_OF_MEASUREMENT
from fmus.export.build import build_all
from fmus.export.description_parts import quantity_of
from fmus.toolchain.platform_names import binary_path
from fmus.toolchain.version import WRITTEN_VERSIONS, Version
from tests.fmus.fmu_driver import FmuDriver

Built = Mapping[tuple[str, Version], Path]
EVERY = pytest.mark.parametrize(
    ("name", "version"), [(n, v) for n in BLOCKS if BLOCKS[n].native for v in WRITTEN_VERSIONS]
)
FMPY = Path(fmpy.__file__).parent


def xml(path: Path, name: str) -> etree._Element:
    with zipfile.ZipFile(path) as archive:
        return etree.fromstring(archive.read(name))


@EVERY
def test_fmpy_finds_no_problem(built: Built, name: str, version: Version) -> None:
    assert validate_fmu(str(built[name, version])) == []


@EVERY
def test_fmutool_has_no_remark(built: Built, name: str, version: Version, caplog: pytest.LogCaptureFixture) -> None:
    logger = logging.getLogger("fmu_manipulation_toolbox")
    logger.addHandler(caplog.handler)
    with FMU(str(built[name, version])) as fmu:
        for checker in get_checkers():
            fmu.apply_operation(checker())
    logger.removeHandler(caplog.handler)
    assert [r.getMessage() for r in caplog.records if r.levelno >= logging.WARNING] == []


@pytest.mark.skipif(sys.platform != "linux", reason="ldd")
@EVERY
def test_needs_only_libc_and_libm(built: Built, name: str, version: Version, tmp_path: Path) -> None:
    library = unpacked_library(built[name, version], version, name, tmp_path)
    command = [shutil.which("ldd") or "ldd", "-r", str(library)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    allowed = r"(linux-vdso|libm|libc|/lib(64)?/ld-linux[^ ]*|ld-linux[^ ]*)\.so"
    for line in done.stdout.splitlines():
        assert re.match(rf"\s*{allowed}", line), line
    assert "undefined symbol" not in done.stdout + done.stderr


@pytest.mark.skipif(sys.platform != "linux", reason="nm")
@EVERY
def test_exports_the_functions_of_fmi_and_nothing_else(
    built: Built, name: str, version: Version, tmp_path: Path
) -> None:
    library = unpacked_library(built[name, version], version, name, tmp_path)
    assert exported_symbols(library) == functions_of_fmi(version)


def exported_symbols(library: Path) -> set[str]:
    command = [shutil.which("nm") or "nm", "-D", "--defined-only", str(library)]
    listed = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    return {line.split()[-1] for line in listed.splitlines()}


def functions_of_fmi(version: Version) -> set[str]:
    header = (FMPY / "c-code" / f"fmi{version}Functions.h").read_text()
    return set(re.findall(rf"FMI\d_Export fmi{version}\w+TYPE\s+(\w+);", header))


@EVERY
def test_loads_with_all_symbols_bound_at_once(built: Built, name: str, version: Version, tmp_path: Path) -> None:
    library = unpacked_library(built[name, version], version, name, tmp_path)
    code = f"import ctypes, os; ctypes.CDLL({str(library)!r}, mode=os.RTLD_NOW | os.RTLD_LOCAL)"
    subprocess.run([sys.executable, "-c", code], check=True)


def unpacked_library(path: Path, version: Version, name: str, folder: Path) -> Path:
    with zipfile.ZipFile(path) as archive:
        return Path(archive.extract(binary_path(version, name), folder))


def test_building_twice_gives_the_same_bytes(built: Built, start_of: Callable[[str], Any], tmp_path: Path) -> None:
    requests = [
        (BLOCKS[name], v, start_of(name)) for name in ("bicycle", "ramp_traffic", "coast") for v in WRITTEN_VERSIONS
    ]
    for again in build_all(requests, tmp_path, SILENT):
        first = built[again.path.stem, Version(int(again.path.parent.name[-1]))]
        assert again.path.read_bytes() == first.read_bytes(), again.path


@EVERY
def test_archive_has_fixed_times_order_and_permissions(built: Built, name: str, version: Version) -> None:
    with zipfile.ZipFile(built[name, version]) as archive:
        entries = archive.infolist()
    assert [e.filename for e in entries] == sorted(e.filename for e in entries)
    assert {e.date_time for e in entries} == {(1980, 1, 1, 0, 0, 0)}
    assert {e.external_attr >> 16 for e in entries} == {0o100644, 0o100755}


@EVERY
def test_sources_keep_the_licence_of_the_fmi_headers(built: Built, name: str, version: Version) -> None:
    with zipfile.ZipFile(built[name, version]) as archive:
        header = archive.read(f"sources/fmi{version}Functions.h").decode()
    assert "2-Clause BSD License" in header


@pytest.mark.parametrize("name", [n for n in BLOCKS if BLOCKS[n].native])
def test_terminals_are_valid_and_name_every_signal(built: Built, name: str) -> None:
    path = built[name, Version.FMI3]
    root = xml(path, "terminalsAndIcons/terminalsAndIcons.xml")
    schema = etree.XMLSchema(etree.parse(FMPY / "schema" / "fmi3" / "fmi3TerminalsAndIcons.xsd"))
    schema.assertValid(root)
    block = BLOCKS[name]
    buses = [*groups(block.input_type), *groups(block.output_type)]
    assert [terminal.get("name") for terminal in root.iter("Terminal")] == buses
    members = {m.get("variableName") for m in root.iter("TerminalMemberVariable")}
    described = xml(path, "modelDescription.xml").find("ModelVariables")
    assert described is not None
    signals = [v for v in described if v.tag != "Clock" and v.get("causality") in ("input", "output")]
    assert members == {v.get("name") for v in signals}


@pytest.mark.parametrize("name", [n for n in BLOCKS if BLOCKS[n].native])
def test_build_description_is_valid_and_its_files_exist(built: Built, name: str) -> None:
    path = built[name, Version.FMI3]
    root = xml(path, "sources/buildDescription.xml")
    etree.XMLSchema(etree.parse(FMPY / "schema" / "fmi3" / "fmi3BuildDescription.xsd")).assertValid(root)
    with zipfile.ZipFile(path) as archive:
        assert {f"sources/{f.get('name')}" for f in root.iter("SourceFile")} <= set(archive.namelist())


@EVERY
def test_variables_are_described_completely(built: Built, name: str, version: Version) -> None:
    description = fmpy.read_model_description(str(built[name, version]))
    for v in description.modelVariables:
        assert v.description
        if v.type in ("Real", "Float64"):
            assert v.unit in UNITS_OF_MEASUREMENT
            assert v.declaredType is not None
            assert v.declaredType.unit == v.unit


@pytest.mark.parametrize("unit", UNITS_OF_MEASUREMENT)
def test_every_unit_has_a_quantity_of_its_own(unit: str) -> None:
    assert [u for u in UNITS_OF_MEASUREMENT if quantity_of(u) == quantity_of(unit)] == [unit]
    assert not quantity_of(unit).startswith("Quantity_")


@EVERY
def test_promise_of_outputs_after_set_is_kept_by_blocks_that_are_not_sampled(
    built: Built, name: str, version: Version
) -> None:
    description = xml(built[name, version], "modelDescription.xml")
    promised = description.xpath("//*[local-name()='Outputs' and @afterSet='true']")
    assert bool(promised) != issubclass(BLOCKS[name], Sampled)


@pytest.mark.parametrize("version", WRITTEN_VERSIONS)
def test_bicycle_declares_its_feedthrough(built: Built, version: Version) -> None:
    description: Any = fmpy.read_model_description(str(built["bicycle", version]))
    on = {u.variable.name: {d.name for d in u.dependencies} for u in description.outputs}
    assert on["state.v_x"] == set()
    assert on["tyre.F_cf"] == {"actuation.delta_f"}
    assert on["motion.a_y"] == {"actuation.delta_f"}
    assert on["tyre.mu_r"] == {"actuation.T_r"}
    first = {u.variable.name: {d.name for d in u.dependencies} for u in description.initialUnknowns}
    assert first["state.v_x"] == {"v_x_start"}
    assert {"C_alpha_f", "v_x_start", "actuation.delta_f"} <= first["tyre.F_cf"]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "signal", "value"), [("bicycle", "actuation.delta_f", 0.02), ("lqr", "ego.y", 0.5)])
@pytest.mark.parametrize("version", WRITTEN_VERSIONS)
def test_recompiled_from_its_sources_it_gives_the_same_numbers(
    built: Built, version: Version, name: str, signal: str, value: float, tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    monkeypatch.setenv("PATH", str(Path(sys.executable).parent), prepend=os.pathsep)  # cmake comes with FMPy
    folder = tmp_path / "unpacked"
    with zipfile.ZipFile(built[name, version]) as archive:
        archive.extractall(folder)
    shutil.rmtree(folder / "binaries")
    (tmp_path / "build").mkdir()
    build_platform_binary(folder, tmp_path / "build")
    assert exported_symbols(folder / binary_path(version, name)) == functions_of_fmi(version)
    again = Path(shutil.make_archive(str(tmp_path / "again"), "zip", folder))
    runs = [FmuDriver(path) for path in (built[name, version], again)]
    for driver in runs:
        driver.start()
        driver.set(signal, value)
        for k in range(10):
            driver.step(k * 0.1, 0.1)
    first, second = (driver.outputs() for driver in runs)
    for driver in runs:
        driver.close()
    assert first.tobytes() == second.tobytes()
