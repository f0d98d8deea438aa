"""What a person asks to run becomes a scenario: by name or file, an SSP file, a former run, or a single FMU."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from components.interfaces.problem import refuse
from orchestrator.results.run_folder import SUMMARY, SYSTEM, is_run
from orchestrator.scenario.options import Options
from orchestrator.scenario.prepare import parse_record, parse_settings, prepare
from orchestrator.scenario.single_fmu import single_fmu
from orchestrator.system.experiment import Algorithm, Scenario, algorithm_named


def load(request: str, options: Options, progress: Callable[[str], None]) -> Scenario:
    """What a person asks to run, with the options applied. Raises `RequestError`.

    A scenario by name or file, a system in an `.ssp` file, the system of a former run, or a single FMU.
    """
    path = Path(request)
    if path.is_dir():
        if not is_run(path):
            raise refuse(request, "a folder without system.ssp", "a scenario, an .ssp file or a run folder")
        path = path / SYSTEM
    if path.suffix not in {".ssp", ".fmu"}:
        return prepare(request, options, progress)
    if options.replacements or options.mode != Options().mode:
        raise refuse(request, "--blocks, --fmi or another unit for a fixed system", "--set, --step, --stop-time, --out")
    settings = parse_settings(options.settings, any_unit=True)
    if path.suffix == ".fmu":
        return with_options(single_fmu(path, settings, options), options)
    from orchestrator.ssp import reader as ssp_reader  # noqa: PLC0415 - only a system in a file needs it

    found = ssp_reader.read(
        path, settings, options.step, options.stop_time, lenient=options.lenient, isolate=options.isolate
    )
    if path.parent == Path(request) and not (path.parent / SUMMARY).is_file():
        found = replace(found, remarks=(*found.remarks, "that run was cut short; this one begins anew"))
    return with_options(found, options)


def with_options(scenario: Scenario, options: Options) -> Scenario:
    """The scenario with what the options say of how it is run. Raises `RequestError`."""
    return replace(
        scenario,
        algorithm=_algorithm(scenario, options),
        solve_loops=options.solve_loops or scenario.solve_loops,
        record=parse_record(options.record) or scenario.record,
    )


def _algorithm(scenario: Scenario, options: Options) -> Algorithm:
    if options.algorithm:
        return algorithm_named(options.algorithm)
    late = scenario.algorithm is Algorithm.JACOBI  # which has no loops to be solved
    return Algorithm.SEQUENTIAL if options.solve_loops and late else scenario.algorithm
