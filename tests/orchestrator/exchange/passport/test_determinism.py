"""The same inputs, the same bits: in two processes, in one again, after a reset, and from a saved state.

This also shows `running.py` and `concurrency.py`.
"""

from __future__ import annotations

import numpy as np
import pytest

from components.interfaces.quantity import Quantity, Type
from components.interfaces.record import Variable
from orchestrator.exchange.passport import concurrency, determinism
from orchestrator.exchange.passport.running import first_difference
from tests.orchestrator.exchange.passport.measured_fmus import lag, on_the_bench, told


def measured(path, patience=10.0):
    with on_the_bench(path, patience) as bench:
        baseline, lines = determinism.driven(bench)
        if baseline is not None:
            lines = [*lines, *determinism.lines(bench, baseline), *concurrency.lines(bench, baseline)]
    return told(lines)


def test_an_fmu_that_is_right_passes_every_line(tmp_path):
    found = measured(lag(tmp_path))
    rounds = found.pop("instances.threads")
    assert found == {
        "determinism.processes": ("passes", "101 rows of 1 values are bit-identical"),
        "determinism.again": ("passes", "101 rows of 1 values are those of a new process"),
        "state.reset": ("passes", "101 rows of 1 values are those of a new instance"),
        "state.restored": ("passes", "saved before step 51; 50 rows of 1 values after it are bit-identical"),
        "state.serialized": (
            "passes",
            "written before step 51 (64 bytes); 50 rows of 1 values after it are bit-identical",
        ),
        "instances.interleaved": ("passes", "the rows of one are bit-identical to those that it shows alone"),
    }
    assert rounds[0] == "passes"
    assert rounds[1].endswith(" times 100 steps are bit-identical to those that it makes alone")


@pytest.mark.parametrize(
    "macros",
    [
        "#include <time.h>\n#define SHOWN i->x + time(NULL)",
        '#include <stdio.h>\n#define STEP { unsigned r; FILE *f = fopen("/dev/urandom", "rb");'
        " fread(&r, 4, 1, f); fclose(f); i->x = r; }",
        "#include <time.h>\n#define STEP { if (i->n == 1) srand(time(NULL)); i->x = rand(); }",
        "#include <unistd.h>\n#define SHOWN i->x + getpid()",
    ],
    ids=["time", "random", "seeded by time", "process"],
)
def test_an_fmu_that_shows_something_else_each_time_fails_and_the_rest_cannot_be_told(tmp_path, macros):
    found = measured(lag(tmp_path, macros))
    mark, evidence = found["determinism.processes"]
    assert mark == "fails"
    assert evidence.startswith("`y` differs first in row ")
    why = ("does not apply", "two runs differ anyway: see determinism.processes")
    assert {key: item for key, item in found.items() if key != "determinism.processes"} == dict.fromkeys(
        (
            "determinism.again",
            "state.reset",
            "state.restored",
            "state.serialized",
            "instances.interleaved",
            "instances.threads",
        ),
        why,
    )


def test_an_instance_that_sees_what_an_earlier_one_left_behind_fails(tmp_path):
    found = measured(lag(tmp_path, "static double kept;\n#define STEP i->x = kept += h;"))
    assert found["determinism.processes"][0] == "passes"
    assert found["determinism.again"][0] == "fails"
    assert found["state.reset"][0] == "fails"
    assert found["instances.interleaved"][0] == "fails"
    assert found["instances.threads"][0] == "fails"


def test_instances_that_share_a_global_mix_in_turn_and_in_threads(tmp_path):
    """Each begins anew, so that only two at once are wrong."""
    macros = """
    static double shared;
    #define STEP { if (i->n == 1) shared = 0; shared += h * (i->u - shared); i->x = shared; }
    """
    found = measured(lag(tmp_path, macros))
    assert found["determinism.again"][0] == "passes"
    assert found["instances.interleaved"][0] == "fails"
    assert "`y` differs first in row " in found["instances.interleaved"][1]
    assert found["instances.threads"][0] == "fails"


def test_instances_that_mix_only_while_both_step_fail_in_threads(tmp_path):
    macros = """
    #include <unistd.h>
    static double shared;
    #define STEP { shared = i->u; usleep(100); i->x = shared; }
    """
    found = measured(lag(tmp_path, macros))
    assert found["instances.interleaved"][0] == "passes"
    assert found["instances.threads"][0] == "fails"


def test_a_reset_that_forgets_a_state_fails(tmp_path):
    found = measured(lag(tmp_path, "#define ON_RESET i->n = 0;"))
    assert found["state.reset"][0] == "fails"
    assert found["state.reset"][1].startswith("`y` differs first in row 0: 0.0 and 0.")
    assert found["state.restored"][0] == "passes"


def test_a_reset_that_is_refused_fails_with_the_reason(tmp_path):
    found = measured(lag(tmp_path, "#define ON_RESET return fmi2Error;"))
    assert found["state.reset"][0] == "fails"
    assert "the reset failed: " in found["state.reset"][1]
    assert found["state.reset"][1].endswith("(resetting the instance)")


def test_a_state_that_holds_a_part_only_fails_restored_and_serialized(tmp_path):
    found = measured(lag(tmp_path, "#define STATE double"))
    assert found["state.restored"][0] == "fails"
    assert found["state.serialized"][0] == "fails"


def test_a_crash_in_one_line_leaves_the_others(tmp_path):
    found = measured(lag(tmp_path, "#define ON_RESET abort();"))
    assert found["state.reset"] == ("fails", "its process died (SIGABRT) (resetting the instance)")
    assert [key for key, (mark, _) in found.items() if mark != "passes"] == ["state.reset"]


def test_a_hang_in_one_line_leaves_the_others(tmp_path):
    found = measured(lag(tmp_path, "#define ON_RESET for (;;);"), patience=2.0)
    assert found["state.reset"] == ("fails", "it hung: no answer within 2 s (resetting the instance)")
    assert [key for key, (mark, _) in found.items() if mark != "passes"] == ["state.reset"]


def test_what_is_not_declared_does_not_apply(tmp_path):
    found = measured(lag(tmp_path, capable='canBeInstantiatedOnlyOncePerProcess="true"'))
    assert found["state.restored"] == ("does not apply", "it does not declare that its state can be saved")
    assert found["state.serialized"] == ("does not apply", "it does not declare that its state can be written")
    once = ("does not apply", "it declares that a process can hold only one instance")
    assert (found["instances.interleaved"], found["instances.threads"]) == (once, once)


def test_a_course_that_the_fmu_does_not_get_through_fails_with_its_stage(tmp_path):
    found = measured(lag(tmp_path, "#define STEP if (i->n > 20) return fmi2Error;"))
    assert found == {
        "determinism.processes": ("fails", "a step at 2 s: an error (driving one instance)"),
    }


def test_an_fmu_with_a_stop_time_is_not_driven_beyond_it(tmp_path):
    macros = "#define STEP if (t + h > 1.001) return fmi2Error;"
    found = measured(lag(tmp_path, macros, experiment='<DefaultExperiment stopTime="1" stepSize="0.1"/>'))
    assert found["determinism.processes"] == ("passes", "11 rows of 1 values are bit-identical")
    assert found["state.restored"][0] == "passes"


def rows(*values, kind=Type.FLOAT64):
    return {kind: np.array(values).reshape(-1, 1)}


def test_rows_are_compared_bit_by_bit():
    y = (Variable("y", Quantity("1", "")),)
    assert first_difference(rows(1.0, np.nan), rows(1.0, np.nan), y) is None
    assert first_difference(rows(1.0, 0.0), rows(1.0, -0.0), y) == (1, "y", 0.0, -0.0)
    assert first_difference(rows(1.0), rows(1.0, 2.0), y) == (1, "the end", "the last row", "more rows")
    text = (Variable("s", Quantity("1", "", Type.STRING)),)
    one, other = (rows(*v, kind=Type.STRING) for v in (("a", "b"), ("a", "c")))
    assert first_difference(one, one, text) is None
    assert first_difference(
        {k: t.astype(object) for k, t in one.items()}, {k: t.astype(object) for k, t in other.items()}, text
    ) == (1, "s", "b", "c")
