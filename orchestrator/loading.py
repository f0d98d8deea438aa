"""A person's request becomes a scenario: a name, a scenario file, an SSP file, a former run, or a single FMU."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from components.interfaces.arguments import checked_arguments
from components.interfaces.problem import refuse
from components.interfaces.progress import SILENT, Progress
from orchestrator.results.run_folder import SUMMARY, SYSTEM, is_run
from orchestrator.scenario.driven_inputs import with_table
from orchestrator.scenario.options import UNCHANGED, Options
from orchestrator.scenario.prepare import parse_record, parse_settings, prepare
from orchestrator.scenario.single_fmu import single_fmu
from orchestrator.scenario.suggested_times import deviations
from orchestrator.scenario.table_file import read_table
from orchestrator.stepping import observation
from orchestrator.stepping.finiteness import ALL
from orchestrator.system.contents import is_folder
from orchestrator.system.experiment import Algorithm, Scenario, algorithm_named, relative_tolerance
from orchestrator.system.source import Fmu


@checked_arguments
def load(request: str | Path, options: Options = UNCHANGED, progress: Progress = SILENT) -> Scenario:
    """Load what is to be run, apply the options, and check everything that can be checked before the first step.

    Blocks run as FMUs unless the options say otherwise; the FMUs that are missing or out of date are built.

    Args:
        request: The name of a scenario, or the path of a scenario file (`.toml`), a system (`.ssp`), a single FMU
            (`.fmu`) or a run folder.
        options: What is changed for this run.
        progress: Receives reports on what is being built or compiled, before it is.

    Returns:
        The checked system with its experiment, for `Simulation` or `execute`.

    Raises:
        RequestError: Something is wrong with the request, with all problems that were found.
        BuildError: The C compiler failed.
    """
    request, path = str(request), Path(request)
    if is_folder(path):
        if not is_run(path):
            raise refuse(request, "a folder without system.ssp", "a scenario, an .ssp file or a run folder")
        path = path / SYSTEM
    if path.suffix not in {".ssp", ".fmu"}:
        return completed(prepare(request, options, progress), options, progress)
    if options.replacements or options.mode != UNCHANGED.mode:
        raise refuse(request, "--blocks, --fmi or another unit for a fixed system", "--set, --step, --stop-time, --out")
    settings = parse_settings(options.settings, any_unit=True)
    if path.suffix == ".fmu":
        return completed(with_options(single_fmu(Fmu(path), settings, options), options), options, progress)
    from orchestrator.ssp import reader as ssp_reader  # noqa: PLC0415 - only a system in a file needs it

    scenario = ssp_reader.read(path, settings, options)
    if path.parent == Path(request) and not (path.parent / SUMMARY).is_file():
        remark = "that run was cut short; this one begins anew"
        scenario = replace(scenario, remarks=(*scenario.remarks, remark))
    return completed(with_options(scenario, options), options, progress)


def completed(scenario: Scenario, options: Options, progress: Progress) -> Scenario:
    """The scenario with what options ask of any system, whose units show all that is to be recorded, and remarks."""
    system = scenario.system
    if allowed := [*options.allow_nonfinite, *([ALL] if options.lenient else [])]:
        system = replace(system, allow_nonfinite=tuple(dict.fromkeys((*system.allow_nonfinite, *allowed))))
    remarks: list[str] = []
    if options.input is not None and system.table is None:
        system, remarks = with_table(system, read_table(Path(options.input)), hold=options.input_hold)
    if system.table is not None and (uncovered := system.table.uncovered(scenario.start, scenario.until)):
        remarks.append(uncovered)
    system = observation.observed(system, scenario.record)
    for source in system.units.values():
        source.make_ready(progress)
    remarks += [*deviations(scenario), *observation.remarks(system, scenario.record)]
    return replace(scenario, system=system, remarks=(*scenario.remarks, *remarks))


def with_options(scenario: Scenario, options: Options) -> Scenario:
    """Apply the options that say how a scenario is run.

    Args:
        scenario: A system that was read from a file.
        options: The master algorithm, the treatment of algebraic loops and the recorded signals are taken from them.

    Returns:
        The changed scenario.

    Raises:
        RequestError: The options name no master algorithm, or a pattern of recorded signals has another form.
    """
    return replace(
        scenario,
        algorithm=_algorithm(scenario, options),
        solve_loops=options.solve_loops or scenario.solve_loops,
        end_off_road=options.end_off_road or scenario.end_off_road,
        record=parse_record(options.record) or scenario.record,
        tolerance=scenario.tolerance if options.tolerance is None else relative_tolerance(options.tolerance),
    )


def _algorithm(scenario: Scenario, options: Options) -> Algorithm:
    if options.algorithm:
        return algorithm_named(options.algorithm)
    # Jacobi has no algebraic loops, so a request to solve loops implies another algorithm.
    jacobi = scenario.algorithm is Algorithm.JACOBI
    return Algorithm.SEQUENTIAL if options.solve_loops and jacobi else scenario.algorithm
