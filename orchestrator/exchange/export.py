"""A system for other tools, without running it: as an SSP file, and as one FMU (a container)."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from components.interfaces.problem import Problem, raise_if_any
from components.interfaces.progress import Progress
from fmus.toolchain.scratch import scratch_folder
from fmus.toolchain.version import Version
from orchestrator.exchange import container
from orchestrator.exchange.leaving import for_other_tools
from orchestrator.loading import load
from orchestrator.scenario.options import Mode, Options
from orchestrator.ssp import writer as ssp
from orchestrator.ssp.element_names import is_fmi2, ssp_version
from orchestrator.system.experiment import Scenario


@dataclass(frozen=True)
class Targets:
    """The files that are to be written."""

    ssp: Path | None = None
    """The system as an SSP file."""
    container: Path | None = None
    """The system as one FMU."""


@dataclass(frozen=True)
class Written:
    """What was written."""

    lines: tuple[str, ...]
    """A description of each file."""
    remarks: tuple[str, ...]
    """The remarks on the system."""


def write(request: str, options: Options, targets: Targets, progress: Progress) -> Written:
    """Write a system in the forms that other tools read; nothing is written when anything is wrong.

    Args:
        request: A scenario, an `.ssp` file, a single FMU or a run folder, as `load` takes it.
        options: What is changed of it.
        targets: The files.
        progress: Receives reports on what is going on.

    Returns:
        What was written.

    Raises:
        RequestError: The request is wrong, or the system has no such form.
    """
    raise_if_any(_target_problems(targets))
    scenario = load(request, options, progress)
    with scratch_folder("export") as scratch:
        return _write(scenario, targets, Path(scratch), progress)


def _write(scenario: Scenario, targets: Targets, folder: Path, progress: Progress) -> Written:
    lines: list[str] = []
    remarks = scenario.remarks
    whole = (
        None if targets.container is None else for_other_tools(scenario, folder / "one", progress, conversions=False)
    )
    parts = None if targets.ssp is None else for_other_tools(scenario, folder / "parts", progress, conversions=True)
    if whole is not None and targets.container is not None:
        progress.now("putting the FMUs into one")
        container.write(whole, targets.container)
        version = 2 if is_fmi2(whole.system) else 3
        lines.append(f"{targets.container}  one FMU, FMI {version}.0 Co-Simulation, steps {whole.algorithm}")
        remarks += whole.remarks
    if parts is not None and targets.ssp is not None:
        ssp.write(parts, targets.ssp)
        lines.append(f"{targets.ssp}  SSP {ssp_version(parts.system)}, {len(parts.system.units)} FMUs")
        remarks += parts.remarks
    return Written(tuple(lines), tuple(dict.fromkeys(remarks)))


def default_mode(request: str) -> Mode:
    """How blocks are exported by default: as FMI 2.0, which every tool reads; a fixed system stays as it is.

    Args:
        request: What is exported, as `load` takes it.

    Returns:
        The mode, for `Options`.
    """
    return Options().mode if Path(request).is_dir() or Path(request).suffix in {".ssp", ".fmu"} else Version.FMI2


def _target_problems(targets: Targets) -> Iterator[Problem]:
    if targets.ssp is None and targets.container is None:
        yield Problem("export", "no file", "--ssp FILE.ssp, --container FILE.fmu, or both")
    for path, suffix in ((targets.ssp, ".ssp"), (targets.container, ".fmu")):
        if path is None:
            continue
        if path.suffix != suffix:
            yield Problem(str(path), f"the ending `{path.suffix}`", f"a file that ends in {suffix}")
        if path.is_dir():
            yield Problem(str(path), "a folder", "a file")
        elif not path.parent.is_dir():
            yield Problem(str(path), f"no folder `{path.parent}`", "a folder that exists", "Make it first.")
        elif not os.access(path.parent, os.W_OK):
            yield Problem(str(path), f"the folder `{path.parent}`, in which nothing may be written", "another folder")
