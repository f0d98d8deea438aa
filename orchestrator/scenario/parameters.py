"""Parameter files and scenario files: each value with its unit and its source, checked as it is read."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, Final, TypeVar

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from components.interfaces.problem import Problem, RequestError, choices, did_you_mean, refuse
from components.interfaces.record import Variable
from orchestrator.system.files import read_toml

SCENARIOS: Final = Path(__file__).parents[1] / "scenarios"
PARAMETERS: Final = SCENARIOS / "parameters"

M = TypeVar("M", bound=BaseModel)


class Given(BaseModel):
    """A value with its unit and where it comes from."""

    model_config = ConfigDict(extra="forbid", strict=True)

    value: Any
    unit: str = "1"
    source: str


class Experiment(BaseModel):
    """How long, and in which steps."""

    model_config = ConfigDict(extra="forbid", strict=True)

    step: Given
    stop_time: Given
    algorithm: str = "sequential"
    solve_loops: bool = False


class Part(BaseModel):
    """What fills a socket."""

    model_config = ConfigDict(extra="forbid", strict=True)

    block: str | None = None
    fmu: str | None = None
    mapping: str | None = None
    """A mapping file: how the FMU that it names, or `fmu`, stands for the socket"""
    use: list[str] = []
    """Parameter files whose values this part takes before its own"""
    step: Given | None = None
    """The unit's own step, a multiple or a part of the macro step"""
    parameters: dict[str, Given] = {}

    def given(self, where: str) -> dict[str, Given]:
        """All values that the scenario gives; its own win. Raises `RequestError` for an unknown parameter file."""
        found: dict[str, Given] = {}
        for name in self.use:
            known = sorted(path.stem for path in PARAMETERS.glob("*.toml"))
            if name not in known:
                remedy = did_you_mean(name, known)
                raise refuse(f"{where}.use", f"the unknown parameter file `{name}`", choices(known), remedy)
            found.update(parameter_set(name))
        return found | self.parameters


class Scene(BaseModel):
    """Values of the scene that differ from the parameter set `scene`."""

    model_config = ConfigDict(extra="forbid", strict=True)

    parameters: dict[str, Given] = {}


class ScenarioFile(BaseModel):
    """A scenario as it stands in its file."""

    model_config = ConfigDict(extra="forbid", strict=True)

    title: str
    description: str
    experiment: Experiment
    plant: Part
    traffic: Part
    controller: Part
    scene: Scene = Scene()
    record: dict[str, Annotated[int, Field(ge=0)]] = {}
    """Signals by pattern, and at every how many ticks they are recorded, 0 for never; the last that fits counts"""


class _Set(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True)

    values: dict[str, Given]


def checked(model: type[M], content: Mapping[str, Any], where: str) -> M:
    """`content` as `model`. Raises one `RequestError` with everything that does not fit."""
    try:
        return model.model_validate(dict(content))
    except ValidationError as error:
        raise RequestError([_problem(model, where, dict(item)) for item in error.errors()]) from error


def _problem(model: type[BaseModel], where: str, item: Mapping[str, Any]) -> Problem:
    place = ".".join(str(part) for part in item["loc"] if part != "values")
    if item["type"] == "missing":
        return Problem(f"{where}: {place}", "nothing", "an entry of this name", _hint(place))
    if item["type"] == "extra_forbidden":
        known = sorted(model.model_fields) if len(item["loc"]) == 1 else sorted(Part.model_fields)
        known = ["value", "unit", "source"] if len(item["loc"]) > 2 else known  # noqa: PLR2004
        return Problem(
            f"{where}: {place}", "an unknown entry", choices(known), did_you_mean(str(item["loc"][-1]), known)
        )
    return Problem(
        f"{where}: {place}", f"`{item['input']}`", item["msg"].removeprefix("Input should be "), _hint(place)
    )


def _hint(place: str) -> str:
    if place.rpartition(".")[2] in {"source", "value", "unit"} or "parameters" in place:
        return 'Write NAME = { value = ..., unit = "...", source = "..." }.'
    return ""


def parameter_set(name: str) -> dict[str, Given]:
    """A parameter file and all the files it uses; its own values win."""
    path = PARAMETERS / f"{name}.toml"
    content = read_toml(path)
    found: dict[str, Given] = {}
    for used in content.pop("use", []):
        found.update(parameter_set(used))
    found.update(checked(_Set, {"values": content}, path.name).values)
    return found


@dataclass(frozen=True)
class Setting:
    """A value given on the command line, in the parameter's own unit: ``--set UNIT.NAME[INDEX]=VALUE``."""

    unit: str
    name: str
    index: int | None
    value: Any


def values_of(
    where: str,
    declared: Sequence[Variable],
    defaults: Mapping[str, Given],
    own: Mapping[str, Given],
    settings: Sequence[Setting] = (),
) -> tuple[dict[str, Any], list[Problem]]:
    """Numbers for the declared parameters: `settings` over `own` over `defaults`.

    A shorter array leaves the rest as it was. Defaults that are not declared belong to others and are passed over;
    other unknown names are problems, as is whatever does not fit its quantity.
    """
    known = {v.name: v for v in declared}
    problems: list[Problem] = []
    values: dict[str, Any] = {}
    for name, given in [*defaults.items(), *own.items()]:
        variable = known.get(name)
        if variable is None:
            problems += [_unknown(where, name, known)] if name in own else []
        elif given.unit != variable.quantity.unit:
            problems.append(Problem(f"{where}.{name}", f"unit `{given.unit}`", f"unit `{variable.quantity.unit}`"))
        else:
            values[name] = _overlaid(values.get(name), given.value)
    for setting in settings:
        if setting.name not in known:
            problems.append(_unknown(where, setting.name, known))
        elif setting.index is None:
            values[setting.name] = _overlaid(values.get(setting.name), setting.value)
        else:
            problems += _set_element(f"{where}.{setting.name}", known[setting.name], values, setting)
    for name, value in values.items():
        problems += known[name].quantity.problems(f"{where}.{name}", value)
    return values, problems


def _unknown(where: str, name: str, known: Mapping[str, Variable]) -> Problem:
    return Problem(f"{where}.{name}", "an unknown parameter", choices(known), did_you_mean(name, known))


def _overlaid(before: Any, value: Any) -> Any:
    """A list over the first elements of a longer one, or the value itself."""
    if not isinstance(value, list):
        return value
    return [*value, *before[len(value) :]] if isinstance(before, list) else value  # type: ignore[unknown]


def _set_element(where: str, variable: Variable, values: dict[str, Any], setting: Setting) -> list[Problem]:
    size = variable.size if variable.quantity.shape else 0
    if setting.index is None or not 1 <= setting.index <= size:
        return [
            Problem(f"{where}[{setting.index}]", "no such element", f"1 to {size}" if size else "a scalar parameter")
        ]
    element = replace(variable.quantity, shape=())
    if problems := element.problems(f"{where}[{setting.index}]", setting.value):
        return problems
    values[setting.name] = [*values[setting.name]]
    values[setting.name][setting.index - 1] = setting.value
    return []
