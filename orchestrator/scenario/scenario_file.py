"""Scenario files: what fills each socket, the experiment, the scene and what is recorded, as they stand in TOML."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Final

from pydantic import BaseModel, ConfigDict, Field, create_model

from components.interfaces.problem import choices, did_you_mean, refuse
from components.interfaces.sockets import SOCKETS
from orchestrator.scenario.parameters import PARAMETERS, parameter_set
from orchestrator.system.files import Given, checked, read_toml

SCENARIOS: Final = Path(__file__).parents[1] / "scenarios"
_STRICT: Final = ConfigDict(extra="forbid", strict=True)


class ExperimentTable(BaseModel):
    """How long, in which steps, and by which algorithm."""

    model_config = _STRICT

    step: Given
    stop_time: Given
    algorithm: str = "sequential"
    solve_loops: bool = False


class SocketFilling(BaseModel):
    """What fills a socket."""

    model_config = _STRICT

    block: str | None = None
    fmu: str | None = None
    mapping: str | None = None
    """A mapping file: how the FMU that it names, or `fmu`, stands for the socket."""
    use: list[str] = []
    """Parameter files whose values are taken before its own."""
    step: Given | None = None
    """The unit's own step, a multiple or a part of the macro step."""
    parameters: dict[str, Given] = {}

    def given(self, where: str) -> dict[str, Given]:
        """All values that the scenario gives; its own win. Raises `RequestError` for an unknown parameter file."""
        found: dict[str, Given] = {}
        for name in self.use:
            known = sorted(PARAMETERS)
            if name not in known:
                remedy = did_you_mean(name, known)
                raise refuse(f"{where}.use", f"the unknown parameter file `{name}`", choices(known), remedy)
            found.update(parameter_set(name))
        return found | self.parameters


class SceneOverrides(BaseModel):
    """Values of the scene that differ from the parameter set `scene`."""

    model_config = _STRICT

    parameters: dict[str, Given] = {}


@dataclass(frozen=True)
class ScenarioFile:
    """A scenario as it stands in its file."""

    title: str
    description: str
    experiment: ExperimentTable
    units: Mapping[str, SocketFilling]
    """What fills each socket, by the name of the socket."""
    scene: SceneOverrides
    record: Mapping[str, int]
    """Signals by pattern, and at every how many ticks they are recorded, 0 for never; the last that fits counts."""


def parse_scenario(content: Mapping[str, Any], where: str) -> ScenarioFile:
    """Check the content of a scenario file, which has a table for each socket.

    Args:
        content: What was read from the file.
        where: What messages call the file.

    Raises:
        RequestError: With everything that does not fit.
    """
    entries: dict[str, Any] = {
        "title": (str, ...),
        "description": (str, ...),
        "experiment": (ExperimentTable, ...),
        **{name: (SocketFilling, ... if socket.essential else None) for name, socket in SOCKETS.items()},
        "scene": (SceneOverrides, SceneOverrides()),
        "record": (dict[str, Annotated[int, Field(ge=0)]], {}),
    }
    # the sockets are data, so that the file's entries are known only when it is read
    made = checked(create_model("ScenarioFile", __config__=_STRICT, **entries), content, where)
    found = {name: getattr(made, name) for name in entries}
    units = {name: filling for name in SOCKETS if (filling := found.pop(name)) is not None}
    return ScenarioFile(**found, units=units)


def names() -> list[str]:
    """The scenarios that come with macrostep."""
    return sorted(path.stem for path in SCENARIOS.glob("*.toml"))


def read(request: str) -> tuple[str, ScenarioFile]:
    """Read a scenario.

    Args:
        request: The name of a scenario that comes with macrostep, or the path of a `.toml` file.

    Returns:
        Its name and its content.

    Raises:
        RequestError: When there is none, or it does not fit.
    """
    path = Path(request)
    if path.suffix != ".toml":
        if request not in names():
            remedy = did_you_mean(request, names()) or "`macrostep list` shows them all."
            raise refuse(f"scenario `{request}`", "no such scenario", f"{choices(names())}, or a .toml file", remedy)
        return request, parse_scenario(read_toml(SCENARIOS / f"{request}.toml"), f"{request}.toml")
    return path.stem, parse_scenario(read_toml(path), str(path))
