"""Time per step, and memory that is not given back; this also shows `memory_used.py`."""

from __future__ import annotations

from orchestrator.exchange.passport import cost
from orchestrator.exchange.passport.cost import grown
from orchestrator.exchange.passport.memory_used import used
from tests.orchestrator.exchange.passport.measured_fmus import lag, on_the_bench


def lines(path):
    with on_the_bench(path) as bench:
        return {line.key: line for line in cost.lines(bench)}


def test_an_fmu_that_is_right_costs_little(tmp_path):
    found = lines(lag(tmp_path))
    assert found["cost.time"].mark == "passes"
    assert 0 < found["cost.time"].figures["median"].value < 1000
    assert found["cost.memory"].mark == "passes"
    assert found["cost.memory"].evidence.endswith(" KiB more after 9500 steps")


def test_a_leak_is_told_with_its_size(tmp_path):
    line = lines(lag(tmp_path, "#define STEP i->s[0] = (size_t)memset(malloc(200), 1, 200);"))["cost.memory"]
    assert line.mark == "fails"
    assert 190 < line.figures["per_step"].value < 240
    assert line.evidence.endswith(" bytes per step")


def test_a_leak_of_messages_is_told(tmp_path):
    assert (
        lines(lag(tmp_path, '#define ON_SET i->s[0] = (size_t)strdup("a message that nobody frees");'))[
            "cost.memory"
        ].mark
        == "fails"
    )


def test_memory_that_is_taken_once_is_no_leak(tmp_path):
    macros = "#define STEP if (i->n == 3000) i->s[0] = (size_t)memset(malloc(1 << 20), 1, 1 << 20);"
    assert lines(lag(tmp_path, macros))["cost.memory"].mark == "passes"


def test_an_fmu_that_is_slower_than_real_time_fails(tmp_path):
    macros = "#include <unistd.h>\n#define STEP usleep(20000);"
    found = lines(lag(tmp_path, macros, experiment='<DefaultExperiment stepSize="0.01"/>'))
    assert found["cost.time"].mark == "fails"
    assert found["cost.memory"].mark == "does not apply"
    assert found["cost.memory"].evidence.startswith("only 0 steps in ")


def test_a_crash_after_many_steps_is_told(tmp_path):
    found = lines(lag(tmp_path, "#define STEP if (i->n > 5000) abort();"))
    assert found["cost.time"].evidence == "its process died (SIGABRT) (making 10000 steps)"
    assert found["cost.memory"].mark == "fails"


def test_an_fmu_that_ends_at_its_stop_time_makes_as_many_steps(tmp_path):
    macros = "#define STEP if (t > 99.95) return fmi2Error;"
    found = lines(lag(tmp_path, macros, experiment='<DefaultExperiment stopTime="100" stepSize="0.1"/>'))
    assert found["cost.time"].mark == "passes"
    assert found["cost.memory"].figures["steps"].value == 500


def test_an_fmu_that_asks_for_the_end_makes_as_many_steps(tmp_path):
    macros = """
    #include "fmi2Functions.h"
    #define STEP if (t > 10) { i->n = -1; return fmi2Discard; }
    fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind k, fmi2Boolean *v) { *v = 1; return fmi2OK; }
    """
    found = lines(lag(tmp_path, macros))
    assert found["cost.time"].mark == "passes"
    assert found["cost.memory"].mark == "does not apply"


def test_growth_is_that_of_the_way_which_tells_more():
    assert grown([(100, 10), (50, 20), (120, 300)]) == 290
    assert grown([(), ()]) == 0


def test_this_process_tells_its_memory():
    before = used()
    kept = bytearray(50_000_000)
    assert grown([before, used()]) >= len(kept)
