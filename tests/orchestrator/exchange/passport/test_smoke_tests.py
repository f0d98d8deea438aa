"""Smoke tests that an FMU carries after FMI-LS-REF; this also shows `experiment_run.py`."""

from __future__ import annotations

import math

import pytest

from fmus.toolchain.version import Version
from orchestrator.exchange.passport import smoke_tests
from orchestrator.exchange.passport.experiment_run import Experiment, TimeSeries, worst_deviation
from orchestrator.exchange.passport.smoke_tests import LAYERED_MANIFEST, UnreadableTestError, series
from tests.fmus.foreign import pack
from tests.orchestrator.exchange.passport.measured_fmus import lag_description, lag_library, on_the_bench, told

FOLDER = LAYERED_MANIFEST.rpartition("/")[0]
LS = (
    'xmlns:fmi-ls="http://fmi-standard.org/fmi-ls-manifest" fmi-ls:fmi-ls-name="org.fmi-standard.fmi-ls-ref" '
    'fmi-ls:fmi-ls-version="1.0.0-alpha.1" fmi-ls:fmi-ls-description="Layered Standard providing information on related'
    ' files included in an FMU."'
)
SSV = (
    '<ssv:ParameterSet xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues" version="1.0" name="p">'
    '<ssv:Parameters><ssv:Parameter name="T"><ssv:Real value="2"/></ssv:Parameter></ssv:Parameters></ssv:ParameterSet>'
)
KIND = 'type="application/x-ma-hs-experiments"'


def manifest(*related):
    items = "".join(f'<Related source="{source}" role="{role}" {KIND}/>' for source, role in related)
    return f"<fmiReferences {LS}>{items}</fmiReferences>"


def experiments(*bodies):
    return f'<Experiments name="all">{"".join(bodies)}</Experiments>'


def experiment(name="rise", attributes='startTime="0" stopTime="2" stepSize="0.1"', inside=""):
    inside = inside or '<Stimuli source="in.csv"/><References source="ref.csv"/>'
    return f'<Experiment name="{name}" {attributes}>{inside}</Experiment>'


def reference(T=0.5, u=2.0, end=2.0, off=0.0):
    rows = [f"{t / 5},{u * (1 - math.exp(-t / 5 / T)) + off}" for t in range(int(5 * end) + 1)]
    return "\n".join(["time,y", *rows]) + "\n"


def carrying(folder, macros="", role="experiment", **files):
    """The lag with a manifest and files beside it."""
    content = {
        "smoke.exp": experiments(experiment()),
        "in.csv": "time,u\n0,2\n5,2\n",
        "ref.csv": reference(),
        "fmi-ls-manifest.xml": manifest(("smoke.exp", role)),
        **{name.replace("_", "."): text for name, text in files.items()},
    }
    beside = {f"{FOLDER}/{name}": text for name, text in content.items() if text is not None}
    return pack(folder / "m.fmu", Version.FMI2, lag_description(), lag_library(macros), **beside)


def found(path, *, runs=True):
    with on_the_bench(path) as bench:
        return told(smoke_tests.lines(bench, runs=runs))


def test_a_smoke_test_that_gives_its_results_passes(tmp_path):
    lines = found(carrying(tmp_path))
    assert lines["smoke.carried"] == ("passes", "1 of them: rise")
    mark, evidence = lines["smoke.test_rise"]
    assert mark == "passes"
    assert evidence.endswith("the most of 1 signals (0.001 may)")


def test_results_that_deviate_fail_with_the_place(tmp_path):
    lines = found(carrying(tmp_path, ref_csv=reference(off=0.1)))
    mark, evidence = lines["smoke.test_rise"]
    assert mark == "fails"
    assert evidence.startswith("`y` deviates by 0.0")
    assert evidence.endswith("; 0.001 may")


def test_the_tolerance_of_the_experiment_allows_more(tmp_path):
    wide = experiment(attributes='stopTime="2" stepSize="0.1" tolerance="0.1"')
    assert found(carrying(tmp_path, smoke_exp=experiments(wide), ref_csv=reference(off=0.1)))["smoke.test_rise"][0] == (
        "passes"
    )


def test_parameters_of_an_experiment_are_set(tmp_path):
    inside = '<Parameters source="p.ssv"/><Stimuli source="in.csv"/><References source="ref.csv"/>'
    slow = experiments(experiment(inside=inside))
    lines = found(carrying(tmp_path, smoke_exp=slow, p_ssv=SSV, ref_csv=reference(T=2.0)))
    assert lines["smoke.test_rise"][0] == "passes"
    assert found(carrying(tmp_path, smoke_exp=slow, p_ssv=SSV))["smoke.test_rise"][0] == "fails"


def test_stimuli_are_linear_between_their_rows_and_held_at_their_ends(tmp_path):
    ramp = "#define STEP i->x = i->u;"
    lines = found(carrying(tmp_path, ramp, in_csv="t,u\n0,0\n1,1\n", ref_csv="t,y\n0,0\n0.6,0.5\n1,0.9\n1.5,1\n2,1\n"))
    assert lines["smoke.test_rise"][0] == "passes"


def test_a_smoke_test_that_crashes_fails_with_the_reason(tmp_path):
    lines = found(carrying(tmp_path, "#define STEP if (i->n > 5) abort();"))
    assert lines["smoke.test_rise"] == ("fails", "its process died (SIGABRT) (driving rise)")


def test_results_that_go_on_after_the_end_fail(tmp_path):
    lines = found(carrying(tmp_path, ref_csv=reference(end=3.0)))
    assert lines["smoke.test_rise"] == ("fails", "`the end` deviates by inf of its largest value at 2 s; 0.001 may")


def test_results_of_other_names_fail(tmp_path):
    lines = found(carrying(tmp_path, ref_csv=reference().replace("time,y", "time,z")))
    assert lines["smoke.test_rise"] == ("fails", "no column of its reference results has the name of an output")


@pytest.mark.parametrize(
    ("files", "fault"),
    [
        ({"smoke_exp": None}, "`smoke.exp` is not in the file"),
        ({"ref_csv": None}, "rise: `ref.csv` is not in the file"),
        (
            {"smoke_exp": experiments(experiment(inside='<Stimuli source="in.csv"/>'))},
            "rise: it has no reference results",
        ),
        (
            {"smoke_exp": experiments(experiment(inside='<References type="application/hdf5" source="ref.csv"/>'))},
            "rise: `ref.csv` has the type `application/hdf5`, which is not read here",
        ),
        (
            {"smoke_exp": experiments(experiment(attributes='stopTime="soon"'))},
            "rise: `stopTime` is `soon`, which is no number",
        ),
        ({"ref_csv": "time,y\n0,0\n1\n"}, "rise: a table that cannot be read ("),
        ({"ref_csv": "time,y\n"}, "rise: a table without rows"),
        ({"smoke_exp": "no XML"}, "XML that is not well-formed"),
    ],
)
def test_what_cannot_be_read_is_told(tmp_path, files, fault):
    mark, evidence = found(carrying(tmp_path, **files))["smoke.carried"]
    assert mark == "fails"
    assert evidence.startswith(fault)


def test_files_with_other_roles_are_no_smoke_tests(tmp_path):
    lines = found(carrying(tmp_path, role="experiment/validation"))
    assert lines == {"smoke.carried": ("does not apply", "its manifest lists no smoke tests")}


def test_the_role_of_a_smoke_test_may_be_told_in_full(tmp_path):
    assert found(carrying(tmp_path, role="experiment/smoke-test"))["smoke.test_rise"][0] == "passes"


def test_files_may_lie_elsewhere_in_the_archive(tmp_path):
    related = manifest(("../other/smoke.exp", "experiment"))
    beside = {
        f"{FOLDER}/fmi-ls-manifest.xml": related,
        "extra/other/smoke.exp": experiments(experiment()),
        "extra/other/in.csv": "time,u\n0,2\n",
        "extra/other/ref.csv": reference(),
    }
    path = pack(tmp_path / "m.fmu", Version.FMI2, lag_description(), lag_library(), **beside)
    assert found(path)["smoke.test_rise"][0] == "passes"


def test_an_fmu_without_smoke_tests_or_one_that_does_not_run(tmp_path):
    path = pack(tmp_path / "m.fmu", Version.FMI2, lag_description(), lag_library())
    assert found(path) == {"smoke.carried": ("does not apply", "it carries none")}
    assert found(carrying(tmp_path), runs=False)["smoke.test_rise"] == ("does not apply", "it does not run here")


def test_tables_are_read_as_they_are_written():
    assert series("time [s],a\n0,1\n1,true\n") == TimeSeries((0.0, 1.0), {"a": (1.0, 1.0)})
    assert series('"time";"a"\n0;1\n\n1;2\n').columns == {"a": (1.0, 2.0)}
    with pytest.raises(UnreadableTestError, match="a table that cannot be read"):
        series("time,a\n0,x\n")


def test_the_worst_of_all_signals_is_told():
    one = Experiment("e", None, None, None, None, {}, None, TimeSeries((0.0, 1.0), {"a": (1.0, 2.0), "b": (0.0, 4.0)}))
    worst = worst_deviation(one, TimeSeries((0.0, 1.0), {"a": (1.0, 2.0), "b": (1.0, 4.0), "c": (0.0, 0.0)}))
    assert worst == ("b", 0.0, 0.25, 2)
    assert worst_deviation(one, TimeSeries((0.0, 1.0), {"a": (1.0, math.nan)})).relative == math.inf


def test_instants_between_communication_points_are_interpolated_where_there_are_no_others():
    def deviation(*times):
        expected = TimeSeries(times, {"a": (*[0.0] * (len(times) - 1), 1.0)})
        one = Experiment("e", None, None, None, None, {}, None, expected)
        return worst_deviation(one, TimeSeries((0.0, 1.0), {"a": (0.0, 1.0)})).relative

    assert deviation(0.0, 0.5, 1.0) == 0.0
    assert deviation(0.25, 0.5) == 0.5
