"""What is asked of a sweep: by a command, in Python, or by the table `sweep` of a scenario file."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from components.interfaces.sockets import SOCKETS
from orchestrator.scenario.options import UNCHANGED, Options
from orchestrator.scenario.scenario_file import Varied, read
from orchestrator.sweeping.sampling import TABLES
from orchestrator.sweeping.variation import spelled

_FILES = (".toml", ".ssp", ".fmu", ".mo")
"""The endings of what is a file and no name."""


@dataclass(frozen=True)
class SweepRequest:
    """What was asked for."""

    scenario: str
    """What is run, as `macrostep run` takes it."""
    vary: tuple[str, ...] = ()
    """What varies, as `PATH=VALUES`."""
    samples: str | None = None
    """How it is sampled: `sobol:512` and the like, or a table."""
    grid: str | None = None
    """The number of values of each variation, for a grid."""
    seed: int = 0
    find: str | None = None
    """What is looked for, in place of samples: `gap_edge < 0`."""
    budget: str = "60s"
    """How long it is looked for, or by how many variants."""
    options: Options = UNCHANGED
    """What is changed in all variants."""
    signals: tuple[str, ...] = ()
    """The signals whose mean and range over all variants are shown."""


def completed(request: SweepRequest) -> SweepRequest:
    """A request with what the table `sweep` of its scenario says, where it says nothing itself of what varies.

    Raises:
        RequestError: The scenario cannot be read.
    """
    of_table = request.samples is not None and request.samples.endswith(TABLES)
    if request.vary or of_table or Path(request.scenario).is_dir() or request.scenario.endswith((".ssp", ".fmu")):
        return request
    table = read(request.scenario)[1].sweep
    if table is None:
        return request
    asks = request.samples is not None or request.grid is not None or request.find is not None
    samples = table.samples
    if samples is not None and samples.endswith(TABLES):
        samples = str(Path(request.scenario).parent / samples)
    return replace(
        request,
        vary=tuple(f"{path}={_spelled(varied)}" for path, varied in table.vary.items()),
        samples=request.samples if asks else samples,
        grid=request.grid if asks else table.grid,
        seed=request.seed or table.seed,
        signals=request.signals or tuple(table.signals),
    )


def _spelled(varied: Varied) -> str:
    """Values of a file as they are typed."""
    return spelled(varied.values) + (f" [{varied.unit}]" if varied.unit else "")


def absolute(request: SweepRequest) -> SweepRequest:
    """A request whose files are found from any folder."""
    options = request.options
    replacements = {socket: absolute_file(str(unit)) for socket, unit in options.replacements.items()}
    table = None if options.input is None else str(Path(options.input).resolve())
    changed = replace(options, replacements=replacements, input=table)
    samples = request.samples
    if samples is not None and samples.endswith(TABLES):
        samples = str(Path(samples).resolve())
    vary = tuple(map(_absolute_values, request.vary))
    return replace(request, scenario=absolute_file(request.scenario), vary=vary, samples=samples, options=changed)


def _absolute_values(text: str) -> str:
    """What varies, with absolute paths where units fill a socket."""
    path, sign, values = text.partition("=")
    if not sign or path.strip() not in SOCKETS:
        return text
    return f"{path}={','.join(absolute_file(unit.strip()) for unit in values.split(','))}"


def absolute_file(text: str) -> str:
    """The absolute path of a file or a folder; a name as it is."""
    is_file = text.partition(":")[0].endswith(_FILES) or Path(text).is_dir()
    return str(Path(text).resolve()) if is_file else text
