"""Systems for other tools: the files, what they hold for whom, and requests that are refused."""

from __future__ import annotations

import re
import shutil
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import fmpy.ssp.ssd
import pytest
from lxml import etree

from components.interfaces.conversion import Linear
from fmus.toolchain.version import Version
from orchestrator.scenario.options import Options
from orchestrator.scenario.prepare import prepare
from orchestrator.ssp import reader as ssp_reader
from orchestrator.ssp import writer as ssp
from orchestrator.system.experiment import Scenario
from orchestrator.system.source import Fmu
from orchestrator.system.system import System
from tests.fmus.foreign import copied, entries
from tests.orchestrator import foreign

SCHEMAS = Path(fmpy.ssp.ssd.__file__).parent / "schema"
NS = {"ssd": ssp.SSD, "ssc": ssp.SSC, "ssv": ssp.SSV, "osp": "http://opensimulationplatform.com/SSP/OSPAnnotations"}


@pytest.fixture
def export(macrostep):
    def call(*arguments):
        code, out, err = macrostep("export", *arguments)
        return code, out.splitlines(), err.splitlines()

    return call


def content(path):
    """All XML files of an SSP, by name."""
    return {name: etree.fromstring(text) for name, text in entries(path).items() if name.endswith((".ssd", ".ssv"))}


def assert_valid(files):
    for name, root in files.items():
        kind = "SystemStructureDescription" if name.endswith(".ssd") else "SystemStructureParameterValues"
        etree.XMLSchema(etree.parse(SCHEMAS / f"{kind}.xsd")).assertValid(root)


def test_both_files_at_once_as_fmi_2(export, built_fmus, in_tmp_path):
    code, out, _ = export("static", "--ssp", "a.ssp", "--container", "a.fmu", "--set", "plant.m=2100")
    assert code == 0
    assert out == [
        "a.fmu  one FMU, FMI 2.0 Co-Simulation, steps sequential",
        "a.ssp  SSP 1.0, 3 FMUs",
    ]
    files = content("a.ssp")
    assert_valid(files)
    assert files["resources/plant.ssv"].xpath("//*[@name='m']/*/@value") == ["2100.0"]
    assert [p.name for p in sorted(in_tmp_path.iterdir())] == ["a.fmu", "a.ssp"]


def test_an_exported_file_is_a_system_again(export, built_fmus):
    assert export("static", "--ssp", "a.ssp")[0] == 0
    code, out, _ = export("a.ssp", "--container", "a.fmu", "--algorithm", "jacobi")
    assert (code, out) == (0, ["a.fmu  one FMU, FMI 2.0 Co-Simulation, steps jacobi"])
    assert export("static", "--container", "b.fmu", "--algorithm", "jacobi")[0] == 0
    a, b = (entries(Path(name))["modelDescription.xml"] for name in ("a.fmu", "b.fmu"))
    assert a == b


def test_a_single_fmu_goes_out_as_it_is(export, built_fmus):
    fmu = built_fmus / "fmi3" / "bicycle.fmu"
    assert export(fmu, "--ssp", "a.ssp", "--stop-time", 1)[:2] == (0, ["a.ssp  SSP 2.0, 1 FMUs"])


def test_fmi_3_is_ssp_2(export, built_fmus):
    code, out, _ = export("static", "--fmi", 3, "--ssp", "a.ssp")
    assert (code, out) == (0, ["a.ssp  SSP 2.0, 3 FMUs"])


def test_what_other_tools_need_stands_in_an_ssp_1(built_fmus, tmp_path):
    """Ecos applies one set by its name; libcosim wants the macro step, and no enumeration."""
    ssp.write(prepare("static", Options(mode=Version.FMI2)), tmp_path / "a.ssp")
    files = content(tmp_path / "a.ssp")
    assert_valid(files)
    names = {root.get("name") for name, root in files.items() if name.endswith(".ssv")}
    assert names == {"static"}
    description = files["SystemStructure.ssd"]
    assert description.xpath("//osp:FixedStepAlgorithm/@baseStepSize", namespaces=NS) == ["0.1"]
    assert description.xpath("//ssd:Connector/ssc:Enumeration", namespaces=NS) == []
    assert description.xpath("//ssd:Connector[@name='solver.iterations']", namespaces=NS) != []


def convoy(built_fmus, tmp_path, **changes):
    """Two vehicles from two files of one name."""
    (tmp_path / "other").mkdir()
    other = shutil.copy(built_fmus / "fmi2" / "bicycle_saturated.fmu", tmp_path / "other" / "bicycle.fmu")
    system = System(
        units={"leader": Fmu(built_fmus / "fmi2" / "bicycle.fmu"), "follower": Fmu(Path(other))},
        wiring={"follower.actuation.delta_f": "leader.state.psi"},
        held={"leader.actuation.delta_f": 0.02, "leader.actuation.T_r": 10.0, "follower.actuation.T_r": 0.0},
    )
    return Scenario("convoy", "", replace(system, **changes), None, 0.1, 2.0, {})


def test_two_files_of_one_name_are_kept_apart(built_fmus, tmp_path):
    ssp.write(convoy(built_fmus, tmp_path), tmp_path / "a.ssp")
    kept = {name: file for name, file in entries(tmp_path / "a.ssp").items() if name.endswith(".fmu")}
    assert kept == {
        "resources/leader.bicycle.fmu": (built_fmus / "fmi2" / "bicycle.fmu").read_bytes(),
        "resources/follower.bicycle.fmu": (built_fmus / "fmi2" / "bicycle_saturated.fmu").read_bytes(),
    }
    sources = content(tmp_path / "a.ssp")["SystemStructure.ssd"].xpath("//ssd:Component/@source", namespaces=NS)
    assert sources == ["resources/leader.bicycle.fmu", "resources/follower.bicycle.fmu"]


def test_held_inputs_are_values_for_other_tools_and_for_us(built_fmus, tmp_path):
    made = convoy(built_fmus, tmp_path)
    ssp.write(made, tmp_path / "a.ssp")
    files = content(tmp_path / "a.ssp")
    assert_valid(files)
    values = files["resources/leader.ssv"].xpath("//ssv:Parameter[starts-with(@name, 'actuation')]", namespaces=NS)
    assert {p.get("name"): p[0].get("value") for p in values} == {
        "actuation.delta_f": "0.02",
        "actuation.T_r": "10.0",
    }
    assert ssp_reader.read(tmp_path / "a.ssp").system.held == made.system.held


def test_conversions_and_own_steps_are_written(built_fmus, tmp_path):
    made = convoy(
        built_fmus,
        tmp_path,
        transformations={"follower.actuation.delta_f": Linear(0.5, 0.25)},
        steps={"leader": Fraction(3), "follower": Fraction(1, 2)},
    )
    ssp.write(made, tmp_path / "a.ssp")
    files = content(tmp_path / "a.ssp")
    assert_valid(files)
    (wire,) = files["SystemStructure.ssd"].iterfind(".//ssd:Connection", NS)
    assert wire.get("suppressUnitConversion") == "true"
    assert dict(wire[0].attrib) == {"factor": "0.5", "offset": "0.25"}
    hints = files["SystemStructure.ssd"].xpath("//osp:StepSizeHint/@value", namespaces=NS)
    assert [float(hint) for hint in hints] == [pytest.approx(0.3)]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["static"], ["macrostep: export: found no file; valid: --ssp FILE.ssp, --container FILE.fmu, or both"]),
        (
            ["static", "--ssp", "no/a.ssp", "--container", "a.zip"],
            [
                "macrostep: no/a.ssp: found no folder `no`; valid: a folder that exists. Make it first.",
                "macrostep: a.zip: found the ending `.zip`; valid: a file that ends in .fmu",
            ],
        ),
        (["static", "--ssp", "taken.ssp"], ["macrostep: taken.ssp: found a folder; valid: a file"]),
        (
            ["static", "--ssp", "a.ssp", "--controller", "mpc_interior_point"],
            [
                "macrostep: controller: found `mpc_interior_point`, a block that runs in this process only; "
                "valid: a block that becomes C, or an FMU. Choose another with --controller."
            ],
        ),
        (
            ["static", "--container", "a.fmu", "--ssp", "a.ssp", "--algorithm", "clocked"],
            [
                "macrostep: algorithm: found `clocked`, for which a container has no Event Mode; "
                "valid: sequential, jacobi"
            ],
        ),
    ],
)
def test_a_wrong_request_is_told_and_nothing_is_written(export, built_fmus, in_tmp_path, arguments, said):
    (in_tmp_path / "taken.ssp").mkdir()
    assert export(*arguments) == (2, [], said)
    assert [p.name for p in in_tmp_path.iterdir()] == ["taken.ssp"]


def test_an_unknown_scenario_is_told(export, in_tmp_path):
    code, _, err = export("statik", "--ssp", "a.ssp")
    assert code == 2
    assert err[0].startswith("macrostep: scenario `statik`: found no such scenario; valid: dense, ")
    assert err[0].endswith("Did you mean `static`?")
    assert list(in_tmp_path.iterdir()) == []


def test_a_folder_in_which_nothing_may_be_written_is_told(export, monkeypatch, in_tmp_path):
    monkeypatch.setattr("os.access", lambda *_: False)
    code, _, err = export("static", "--ssp", "a.ssp")
    assert code == 2
    assert err == ["macrostep: a.ssp: found the folder `.`, in which nothing may be written; valid: another folder"]


def test_a_foreign_plant_with_our_names_goes_out_as_it_is(built_fmus, export):
    """What a file leaves open, its dependencies, is nothing that another tool reads."""
    ours = built_fmus / "fmi2" / "bicycle.fmu"
    text = entries(ours)["modelDescription.xml"].decode()
    silent = re.sub(r' dependencies(Kind)?="[^"]*"', "", text).replace('afterSet="true"', 'afterSet="false"')
    car = copied(ours, Path("car.fmu"), {"modelDescription.xml": silent.encode()})
    code, out, err = export("static", "--plant", car, "--ssp", "a.ssp")
    assert (code, out) == (0, ["a.ssp  SSP 1.0, 3 FMUs"]), err
    written = entries(Path("a.ssp"))
    assert "resources/car.fmu" in written
    assert not [name for name in written if name.endswith(".toml")]


def test_a_plant_behind_a_mapping_goes_out_and_what_stands_beside_it_is_told(export, in_tmp_path):
    mapping = foreign.right_handed_mapping(in_tmp_path)
    code, out, err = export(
        "static", "--plant", mapping, "--controller", "lqr", "--ssp", "a.ssp", "--container", "a.fmu"
    )
    assert (code, out) == (
        0,
        ["a.fmu  one FMU, FMI 2.0 Co-Simulation, steps sequential", "a.ssp  SSP 1.0, 4 FMUs"],
    )
    assert err[-2:] == [
        "note: plant: its mapping goes along as plant_out and plant_in",
        "note: plant: its mapping goes along as plant_out; a tool that exchanges values one step late delays signals by"
        " one step more in each",
    ]
    assert_valid(content("a.ssp"))
