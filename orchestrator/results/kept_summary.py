"""The summary of a run that was written at some time, read back: what is damaged is left out, and named."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any, Final

from pydantic import BaseModel, ConfigDict, TypeAdapter, ValidationError

from components.interfaces.problem import RequestError
from orchestrator.system.contents import read_json

DAMAGED: Final = "damaged"
"""The entry that names those which were left out."""


class _Unit(BaseModel):
    model_config = ConfigDict(extra="allow", strict=True)

    kind: str
    runs_as: str


class _Fault(BaseModel):
    model_config = ConfigDict(extra="allow", strict=True)

    tick: int
    time: float
    unit: str
    reason: str


class _Outside(BaseModel):
    model_config = ConfigDict(extra="allow", strict=True)

    time: float
    value: float
    declared: str


_ENTRIES: Final[Mapping[str, Any]] = {
    "scenario": str,
    "title": str,
    "status": str,
    "units": dict[str, _Unit],
    "versions": dict[str, str],
    "fault": _Fault,
    "verdicts": dict[str, bool],
    "metrics": dict[str, float],
    "out_of_range": dict[str, _Outside],
}
"""What is read of a summary, with its types; infinite metrics are texts in the file."""
_EVERY: Final = ("scenario", "title", "status", "units", "versions")
"""What every summary has."""


def kept_summary(path: Path) -> Mapping[str, Any]:
    """The content of the summary of a run.

    Args:
        path: The file.

    Returns:
        The entries whose content is of the right type, and those of which nothing is read; with an entry `DAMAGED`,
        a text, if others were left out. Nothing at all if there is no such file.
    """
    if not path.is_file():
        return {}
    try:
        content = read_json(path, path.name, "what a run wrote")
    except RequestError as error:
        return {DAMAGED: "; ".join(f"{problem.where}: {problem.found}" for problem in error.problems)}
    if not isinstance(content, dict):
        return {DAMAGED: f"{path.name}: another JSON"}
    sound: dict[str, Any] = dict(content)  # type: ignore[unknown]
    wrong: list[str] = []
    for name in _ENTRIES:
        if name in content or name in _EVERY:
            try:
                sound[name] = _adapter(name).dump_python(_adapter(name).validate_python(content.get(name)))  # type: ignore[unknown]
            except ValidationError:
                wrong.append(name)
                sound.pop(name, None)
    return sound | ({DAMAGED: f"{path.name}: {', '.join(wrong)}"} if wrong else {})


@cache
def _adapter(name: str) -> TypeAdapter[Any]:
    return TypeAdapter(_ENTRIES[name])
