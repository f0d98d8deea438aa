"""Sources of units, method by method: blocks in this process, FMUs, and FMUs behind a mapping (`mapping/mapped.py`).

This also shows `source_description.py` and `unit_source.py`.
"""

from __future__ import annotations

import dataclasses

import pytest

from components import BLOCKS
from components.interfaces.sockets import PLANT
from fmus.reading.archive import InterfaceType
from fmus.toolchain.version import WRITTEN_VERSIONS, Version
from fmus.units.block_unit import BlockUnit
from fmus.units.co_simulation import Fmu2Unit, Fmu3Unit
from fmus.units.isolated_unit import IsolatedUnit
from fmus.units.mapped_unit import MappedUnit
from orchestrator.mapping.mapped import Mapped, fitted
from orchestrator.mapping.mapping_reader import read_mapping
from orchestrator.system.source import Fmu, InProcess, block_source
from orchestrator.system.source_description import SourceDescription
from tests.fmus.foreign import description2, description3, pack, scalar
from tests.orchestrator import foreign
from tests.orchestrator.blocks import Affine


@pytest.fixture
def in_process():
    return InProcess(BLOCKS["bicycle"], {"m": 2000.0})


@pytest.fixture(params=WRITTEN_VERSIONS, ids="fmi{}".format)
def fmu(request, built_fmus):
    return Fmu(built_fmus / f"fmi{request.param}" / "bicycle.fmu", {"m": 2100.0})


@pytest.fixture(scope="module")
def theirs(tmp_path_factory):
    """A car with signals of its own, which needs a mapping."""
    folder = tmp_path_factory.mktemp("theirs")
    mapping = read_mapping(foreign.right_handed_mapping(folder), "plant")
    source, problems, _ = fitted("plant", PLANT, Fmu(folder / "theirs.fmu"), mapping)
    assert problems == ()
    return source


@pytest.fixture(scope="module")
def tried(built_fmus, tmp_path_factory):
    """Our own plant behind a mapping that only adds the units of measurement that its file does not declare."""
    file = tmp_path_factory.mktemp("tried") / "theirs.fmu"
    source, problems, _ = fitted(
        "plant", PLANT, Fmu(foreign.relabelled(built_fmus / "fmi3" / "bicycle.fmu", file, units={"state.x": None}))
    )
    assert problems == ()
    return source


@pytest.fixture
def described(tmp_path):
    """An FMU of a description, whose library is never loaded."""

    def made(version, text):
        library = tmp_path / "library.so"
        library.write_bytes(b"no library")
        return pack(tmp_path / f"fmi{version}" / "m.fmu", version, text, library)

    return made


@pytest.fixture
def resizable(described):
    """An FMU with an array as long as its structural parameter says."""
    length = '<UInt64 name="n" valueReference="1" causality="structuralParameter" variability="fixed" start="2"/>'
    size = '<Dimension valueReference="1"/>'
    array = f'<Float64 name="y" valueReference="2" causality="output">{size}</Float64>'
    structure = ['<Output valueReference="2" dependencies=""/>']
    return Fmu(described(Version.FMI3, description3([length, array], structure)))


ARRAY = {"x[1]": 11, "x[2]": 12, "x[3]": 13}
FROM_ZERO = {"y[0]": 20, "y[1]": 21}
MATRIX = {"z[1][1]": 31, "z[1][2]": 32, "z[2][1]": 33, "z[2][2]": 34}


@pytest.fixture
def arrays(described):
    """An FMU of FMI 2.0 whose arrays are spelled in different ways, and that has a variable for no one."""
    variables = [
        *(scalar(name, reference, "input", of_start="0") for name, reference in ARRAY.items()),
        *(scalar(name, reference, "output") for name, reference in {**FROM_ZERO, **MATRIX}.items()),
        scalar("speed", 40, "output"),
        scalar("inner", 50, "local"),
    ]
    outputs = [f'<Unknown index="{i}" dependencies=""/>' for i in range(4, 11)]
    return Fmu(described(Version.FMI2, description2(variables, outputs)))


def variable(source, role, name):
    return next(v for v in getattr(source.interface, role) if v.name == name)


def test_the_interface_of_a_block_in_this_process_is_the_block_s(in_process):
    assert in_process.interface.kind == "bicycle"
    assert [v.name for v in in_process.interface.parameters] == [v.name for v in BLOCKS["bicycle"].parameters()]


def test_a_block_with_other_parameters_is_another_source(in_process):
    other = in_process.with_parameters({"m": 1.0})
    assert (other.block, other.parameters) == (in_process.block, {"m": 1.0})
    assert in_process.parameters == {"m": 2000.0}
    with pytest.raises(dataclasses.FrozenInstanceError):
        in_process.parameters = {}


def test_a_block_stays_in_this_process(in_process):
    assert in_process.in_own_process(1.0) is None
    assert in_process.single_instance() is None


def test_a_block_is_described_without_a_file(in_process):
    found = in_process.describe()
    assert found == SourceDescription("bicycle", file=None, version=None, isolated=None)
    assert found.runs_as == "block in this process"


def test_a_block_becomes_a_running_block(in_process):
    unit = in_process.open("car")
    assert isinstance(unit, BlockUnit)
    assert unit.name == "car"
    unit.close()


def test_other_tools_cannot_run_a_block_in_this_process(in_process):
    assert str(in_process.foreign_problem("plant")) == (
        "plant: found `bicycle`, a block that runs in this process only; "
        "valid: a block that becomes C, or an FMU. Choose another with --plant."
    )
    assert in_process.for_other_tools() is in_process


def test_no_file_says_anything_of_a_block(in_process):
    obstacles = InProcess(BLOCKS["ramp_traffic"], {})
    x = variable(obstacles, "outputs", "obstacles.x")
    assert obstacles.element_names(x, "outputs") == [f"obstacles.x[{i}]" for i in range(1, 9)]
    assert in_process.mapping_text() is None
    assert not in_process.declares("m")
    assert in_process.structural == ()
    assert in_process.references == {}


def test_a_block_with_its_values_is_a_source():
    values = {"k": 2.0, "d": -1.0}
    assert block_source(Affine(**values)) == InProcess(Affine, values)


def test_an_fmu_is_read_once_and_only_when_it_is_needed(tmp_path, fmu):
    assert Fmu(tmp_path / "nowhere.fmu").path.name == "nowhere.fmu"
    assert fmu.archive is fmu.archive
    assert fmu.interface is fmu.archive.interface


def test_other_parameters_leave_the_file_read(fmu):
    other = fmu.with_parameters({"m": 2200.0})
    assert other.archive is fmu.archive
    assert (other.path, other.parameters) == (fmu.path, {"m": 2200.0})
    assert fmu.parameters == {"m": 2100.0}


def test_other_lengths_make_it_read_the_file_again(resizable):
    longer = resizable.with_parameters({"n": 5})
    assert resizable.structural == ("n",)
    assert longer.archive is not resizable.archive
    assert variable(resizable, "outputs", "y").shape == (2,)
    assert variable(longer, "outputs", "y").shape == (5,)


def test_an_fmu_in_its_own_process_is_the_same_file(fmu):
    apart = fmu.in_own_process(2.5)
    assert apart.archive is fmu.archive
    assert (apart.isolated, fmu.isolated) == (2.5, None)
    assert apart.parameters == fmu.parameters
    assert apart.with_parameters({}).isolated == 2.5


def test_an_fmu_is_described_by_its_model_file_and_version(fmu):
    version = Version(fmu.archive.version)
    found = fmu.in_own_process(2.5).describe()
    assert found == SourceDescription("bicycle", fmu.path, version, 2.5, InterfaceType.CO_SIMULATION)
    assert found.runs_as == f"FMI {version}.0"
    assert fmu.describe().isolated is None


def test_an_fmu_becomes_the_unit_of_its_version(fmu):
    unit = fmu.open("car")
    assert type(unit) is {Version.FMI2: Fmu2Unit, Version.FMI3: Fmu3Unit}[fmu.archive.version]
    unit.close()


def test_an_fmu_in_its_own_process_becomes_an_isolated_unit(fmu):
    unit = fmu.in_own_process(60.0).open("car")
    assert isinstance(unit, IsolatedUnit)
    unit.close()


def test_any_tool_can_run_an_fmu(fmu):
    assert fmu.foreign_problem("plant") is None
    assert fmu.for_other_tools() is fmu
    assert fmu.mapping_text() is None


@pytest.mark.foreign
def test_a_process_holds_many_units_of_an_fmu_unless_its_file_says_otherwise(fmu, described):
    assert fmu.single_instance() is None
    text = description2([scalar("y", 1, "output")], ['<Unknown index="1" dependencies=""/>'])
    text = text.replace("<CoSimulation ", '<CoSimulation canBeInstantiatedOnlyOncePerProcess="true" ', 1)
    once = Fmu(described(Version.FMI2, text))
    assert once.single_instance() is None, "each unit of an FMU of another maker has a process"
    assert once.in_this_process().single_instance() == once.path
    assert once.in_own_process(1.0).single_instance() is None


@pytest.mark.parametrize(
    ("name", "role", "spelled"),
    [
        ("x", "inputs", [*ARRAY]),
        ("y", "outputs", [*FROM_ZERO]),
        ("z", "outputs", [*MATRIX]),
        ("speed", "outputs", ["speed"]),
    ],
)
def test_elements_of_fmi_2_arrays_are_named_as_the_file_spells_them(arrays, name, role, spelled):
    found = variable(arrays, role, name)
    assert found.size == len(spelled)
    assert list(arrays.element_names(found, role)) == spelled


def test_a_variable_is_declared_also_where_no_master_exchanges_it(arrays):
    assert arrays.declares("inner")
    assert arrays.declares("x[1]")
    assert not arrays.declares("x")
    assert not arrays.declares("outer")
    assert "inner" not in {v.name for v in (*arrays.interface.inputs, *arrays.interface.outputs)}


def test_fmi_2_has_a_reference_for_each_element_and_fmi_3_one_in_all(arrays, resizable):
    assert arrays.references["x"] == [*ARRAY.values()]
    assert arrays.references["z"] == [*MATRIX.values()]
    assert resizable.references["y"] == [2]


def test_a_mapped_fmu_looks_like_its_socket(theirs):
    assert isinstance(theirs, Mapped)
    assert {"actuation.delta_f", "actuation.T_r"} == {v.name for v in theirs.interface.inputs}
    assert {v.name for v in PLANT.required()} <= {v.name for v in theirs.interface.outputs}


def test_other_parameters_reach_a_mapped_fmu_and_leave_the_rest(tried):
    other = tried.with_parameters({"m": 2200.0})
    assert other.parameters == other.fmu.parameters == {"m": 2200.0}
    assert other.fitting is tried.fitting
    assert other.fmu.archive is tried.fmu.archive
    assert tried.parameters == {}


def test_the_fmu_behind_a_mapping_goes_into_the_other_process(theirs):
    apart = theirs.in_own_process(2.5)
    assert (apart.fmu.isolated, theirs.fmu.isolated) == (2.5, None)
    assert apart.fitting is theirs.fitting
    assert apart.fmu.archive is theirs.fmu.archive
    assert theirs.single_instance() is None


def test_a_mapped_fmu_is_described_as_the_fmu(theirs):
    found = theirs.describe()
    assert found == theirs.fmu.describe()
    assert (found.file, found.runs_as) == (theirs.fmu.path, "FMI 2.0")


def test_the_mapping_is_written_for_the_file_that_is_named(theirs):
    assert 'fmu = "elsewhere.fmu"' in theirs.mapping_text("elsewhere.fmu").splitlines()
    assert 'v_x = "car.speed"' in theirs.mapping_text().splitlines()


def test_a_mapped_fmu_becomes_a_unit_around_that_of_the_fmu(theirs):
    unit = theirs.open("car")
    assert isinstance(unit, MappedUnit)
    assert unit.interface is theirs.interface
    unit.close()


def test_other_tools_cannot_run_a_mapped_fmu(theirs):
    kind = theirs.interface.kind
    assert str(theirs.foreign_problem("plant")) == (
        f"plant: found `{kind}` behind a mapping, which other tools do not read; "
        "valid: an FMU with the names and units of its socket. Export it so, or run it here."
    )
    assert theirs.for_other_tools() is theirs


def test_where_the_mapping_only_adds_to_what_the_file_says_others_get_the_fmu(tried):
    assert isinstance(tried, Mapped)
    assert tried.fitting.plain
    assert tried.for_other_tools() is tried.fmu
