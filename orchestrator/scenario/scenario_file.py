"""Scenario files: the fillings of the sockets, the experiment, the scene and the recorded signals, in TOML."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Final, cast

from pydantic import BaseModel, ConfigDict, Field, create_model

from components.interfaces.problem import choices, did_you_mean, refuse
from components.interfaces.sockets import SOCKETS
from orchestrator.scenario.parameters import PARAMETERS, parameter_set
from orchestrator.system.files import Given, checked, read_toml

SCENARIOS: Final = Path(__file__).parents[1] / "scenarios"
"""The folder of the scenarios that come with macrostep."""

_STRICT: Final = ConfigDict(extra="forbid", strict=True, use_attribute_docstrings=True)


_RECORD: Final = "At every how many ticks the signals that match a pattern are recorded, 0 for never; the last counts."
_NONFINITE: Final = "Patterns of the signals that may be infinite or not a number although a unit reads them."


class ExperimentTable(BaseModel):
    """The times, the tolerance and the algorithm of an experiment."""

    model_config = _STRICT

    step: Given
    """The macro step, in `s`."""
    stop_time: Given
    """The end, in `s`: a whole number of macro steps after the start."""
    start_time: Given | None = None
    """The beginning, in `s`; 0 if not given."""
    tolerance: Given | None = None
    """The relative tolerance that all FMUs are told; each its own, if not given."""
    algorithm: str = "sequential"
    """How the units exchange data: `sequential` (no hidden delay), `jacobi` or `clocked`."""
    solve_loops: bool = False
    """Whether algebraic loops are solved by iteration instead of being refused."""
    end_off_road: bool = False
    """Whether the run ends where the vehicle leaves the surroundings of the road."""


class SocketFilling(BaseModel):
    """The filling of a socket: a block or an FMU, with its values."""

    model_config = _STRICT

    block: str | None = None
    """A block of the catalogue."""
    fmu: str | None = None
    """An FMU, or a Modelica model (`FILE.mo` or `FILE.mo:MODEL`) that becomes one; relative to this file."""
    mapping: str | None = None
    """The mapping file by which the FMU that it names, or `fmu`, fits the socket."""
    interface: str | None = None
    """The interface type of an FMU that has both: `CoSimulation` or `ModelExchange`."""
    use: list[str] = []
    """Parameter files, whose values `parameters` replaces."""
    step: Given | None = None
    """The unit's own step, a whole multiple or a whole part of the macro step."""
    parameters: dict[str, Given] = {}
    """Values of its parameters, which replace those of `use` and of the block's own parameter file."""

    def given(self, where: str) -> dict[str, Given]:
        """All values that the scenario gives.

        Args:
            where: The place of the filling, for messages.

        Raises:
            RequestError: A parameter file is unknown, or cannot be read.
        """
        return _used(self.use, where) | self.parameters


class SceneOverrides(BaseModel):
    """The values of the scene that replace those of the parameter set `scene`."""

    model_config = _STRICT

    use: list[str] = []
    """Parameter files, whose values `parameters` replaces."""
    parameters: dict[str, Given] = {}
    """The road and the size of the vehicle, for metrics and pictures."""

    def given(self) -> dict[str, Given]:
        """All values that the scenario gives. Raises `RequestError` as that of `SocketFilling` does."""
        return _used(self.use, "scene") | self.parameters


class Varied(BaseModel):
    """The values that something has in a sweep."""

    model_config = _STRICT

    values: str | list[str | bool | int | float]
    """A range `LOW:HIGH` or `log:LOW:HIGH`, a distribution of scipy.stats such as `normal:10,0.5`, or a list."""
    unit: str = ""
    """The unit of measurement of these values; that of the parameter, if not given."""
    source: str = ""
    """Where they come from."""


class SweepTable(BaseModel):
    """What `macrostep sweep` does with this scenario where the command says nothing else."""

    model_config = _STRICT

    vary: dict[str, Varied]
    """What varies: by the path of a parameter, or the name of a socket."""
    samples: str | None = None
    """How it is sampled: `sobol:512`, `lhs:100`, `random:100`, `saltelli:64`, or a table, relative to this file."""
    grid: str | None = None
    """The number of values of each variation, in place of samples: `20`, or `20,5`."""
    seed: Annotated[int, Field(ge=0)] = 0
    """Which values are drawn."""
    signals: list[str] = []
    """The signals whose mean and range over all variants are shown, such as `plant.state.y`."""


def _used(names: Sequence[str], where: str) -> dict[str, Given]:
    """The values of parameter files; those of a later one replace those of an earlier one."""
    values: dict[str, Given] = {}
    for name in names:
        known = sorted(PARAMETERS)
        if name not in known:
            remedy = did_you_mean(name, known)
            raise refuse(f"{where}.use", f"the unknown parameter file `{name}`", choices(known), remedy)
        values.update(parameter_set(name))
    return values


@dataclass(frozen=True)
class ScenarioFile:
    """The content of a scenario file."""

    title: str
    description: str
    experiment: ExperimentTable
    units: Mapping[str, SocketFilling]
    """The filling of each socket, by the name of the socket."""
    scene: SceneOverrides
    record: Mapping[str, int]
    """At every how many ticks the signals that match a pattern are recorded, 0 for never; the last match counts."""
    allow_nonfinite: Sequence[str]
    """Patterns of the signals that may be infinite or not a number although a unit reads them."""
    sweep: SweepTable | None = None
    """What a sweep varies where nothing else is asked for."""


def parse_scenario(content: Mapping[str, Any], where: str) -> ScenarioFile:
    """Check the content of a scenario file, which has a table for each socket.

    Args:
        content: The parsed file.
        where: The name of the file, for messages.

    Raises:
        RequestError: Entries are missing, unknown or of another type; the error lists all of them.
    """
    model = checked(scenario_model(), content, where)
    tables = {name: getattr(model, name) for name in type(model).model_fields}
    for given in _all_given(model):
        given.source = given.source or where
    units = {name: filling for name in SOCKETS if (filling := tables.pop(name)) is not None}
    return ScenarioFile(**tables, units=units)


def scenario_model() -> type[BaseModel]:
    """The entries of a scenario file; sockets can be added at run time, so they are not known before it is read."""
    entries: dict[str, Any] = {
        "title": (Annotated[str, Field(description="The title of the scenario.")], ...),
        "description": (Annotated[str, Field(description="What happens in it, and what it shows.")], ""),
        "experiment": (ExperimentTable, ...),
        **{name: (SocketFilling, ... if socket.essential else None) for name, socket in SOCKETS.items()},
        "scene": (SceneOverrides, SceneOverrides()),
        "record": (Annotated[dict[str, Annotated[int, Field(ge=0)]], Field(description=_RECORD)], {}),
        "allow_nonfinite": (Annotated[list[str], Field(description=_NONFINITE)], []),
        "sweep": (SweepTable | None, None),
    }
    return create_model("ScenarioFile", __config__=_STRICT, **entries)


def _all_given(table: object) -> Iterator[Given]:
    """All values of a table and of the tables in it."""
    if isinstance(table, Given):
        yield table
    elif isinstance(table, BaseModel):
        for name in type(table).model_fields:
            yield from _all_given(getattr(table, name))
    elif isinstance(table, dict):
        for item in cast("dict[str, object]", table).values():
            yield from _all_given(item)


def names() -> list[str]:
    """The names of the scenarios that come with macrostep."""
    return sorted(path.stem for path in SCENARIOS.glob("*.toml"))


def read(request: str) -> tuple[str, ScenarioFile]:
    """Read a scenario.

    Args:
        request: The name of a scenario that comes with macrostep, or the path of a `.toml` file.

    Returns:
        The name and the content of the scenario.

    Raises:
        RequestError: There is no such scenario, or its file has wrong entries.
    """
    path = Path(request)
    if path.suffix != ".toml":
        if request not in names():
            remedy = did_you_mean(request, names()) or "`macrostep list` shows them all."
            raise refuse(f"scenario `{request}`", "no such scenario", f"{choices(names())}, or a .toml file", remedy)
        return request, parse_scenario(read_toml(SCENARIOS / f"{request}.toml"), f"{request}.toml")
    return path.stem, parse_scenario(read_toml(path), str(path))
