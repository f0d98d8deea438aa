"""A system as an SSP file, and back.

This shows `writer.py`, `parameter_set_writer.py`, `element_names.py` and `xml.py`.
"""

from __future__ import annotations

from pathlib import Path

import fmpy.ssp.ssd
import pytest
from lxml import etree

from fmus.toolchain.version import Version
from orchestrator.scenario.options import Options
from orchestrator.scenario.prepare import prepare
from orchestrator.scenario.resolution import Setting
from orchestrator.ssp import reader as ssp_reader
from orchestrator.ssp import writer as ssp
from tests.fmus.foreign import entries

SCHEMAS = Path(fmpy.ssp.ssd.__file__).parent / "schema"


@pytest.fixture(params=["blocks", Version.FMI2, Version.FMI3], ids=str)
def static(request, built_fmus):
    return prepare("static", Options(mode=request.param))


def test_what_is_read_back_is_what_was_written(static, tmp_path):
    ssp.write(static, tmp_path / "a.ssp")
    found = ssp_reader.read(tmp_path / "a.ssp")
    assert (found.name, found.title, found.h, found.until) == (static.name, static.title, static.h, static.until)
    assert dict(found.sources) == dict(static.sources)
    assert vars(found.scene) == vars(static.scene)
    assert {str(c) for c in found.system.connections} == {str(c) for c in static.system.connections}
    for name, unit in static.system.units.items():
        assert found.system.units[name].parameters == unit.parameters
        assert found.system.units[name].interface.kind == unit.interface.kind
    ssp.write(found, tmp_path / "b.ssp")
    assert (tmp_path / "a.ssp").read_bytes() == (tmp_path / "b.ssp").read_bytes()


def test_a_system_of_fmi_2_keeps_the_schema_of_ssp_1(built_fmus, tmp_path):
    ssp.write(prepare("static", Options(mode=Version.FMI2)), tmp_path / "a.ssp")
    files = entries(tmp_path / "a.ssp")
    description = etree.XMLSchema(etree.parse(SCHEMAS / "SystemStructureDescription.xsd"))
    description.assertValid(etree.fromstring(files["SystemStructure.ssd"]))
    values = etree.XMLSchema(etree.parse(SCHEMAS / "SystemStructureParameterValues.xsd"))
    for name in ("plant", "traffic", "controller"):
        values.assertValid(etree.fromstring(files[f"resources/{name}.ssv"]))
    assert fmpy.ssp.ssd.read_ssd(tmp_path / "a.ssp").system.name == "static"


def test_settings_change_what_is_read(tmp_path):
    ssp.write(prepare("static", Options(mode="blocks")), tmp_path / "a.ssp")
    settings = {"plant": [Setting("plant", "m=2100.0")]}
    found = ssp_reader.read(tmp_path / "a.ssp", settings, options=Options(step=0.05, stop_time=1.0))
    assert found.system.units["plant"].parameters["m"] == 2100.0
    assert found.sources["plant.m"]["source"] == "--set"
    assert (found.h, found.until) == (0.05, 1.0)
