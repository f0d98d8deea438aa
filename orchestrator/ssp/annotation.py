"""The annotation of this program in an SSP: what of a scenario the standard has no element for, written and read."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import asdict
from fractions import Fraction
from typing import Annotated, Any, Final

import numpy as np
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, PlainValidator
from pydantic_core import PydanticKnownError

from components.interfaces.problem import choices, listed, refuse
from components.interfaces.quantity import Type
from components.interfaces.sockets import SOCKETS
from orchestrator.ssp.archive import Document, Findings, alternatives
from orchestrator.ssp.vocabulary import OURS, Tag, resource
from orchestrator.ssp.xml import qualified
from orchestrator.system.experiment import EVERYTHING, STEP, Algorithm, Scenario
from orchestrator.system.files import checked
from orchestrator.system.input_table import InputTable
from orchestrator.system.source import UnitSource


def _registered_socket(name: Any) -> str:
    """A value that is the name of a socket; the error has the words of pydantic for a `Literal`."""
    if isinstance(name, str) and name in SOCKETS:
        return name
    raise PydanticKnownError("literal_error", {"expected": alternatives(f"'{known}'" for known in SOCKETS)})


def _ratio(value: Any) -> Any:
    """A value that may be a ratio: one such as `1e999999999` would take hours."""
    if isinstance(value, str) and not _RATIO.fullmatch(value):
        raise PydanticKnownError("string_pattern_mismatch", {"pattern": "1/2"})
    return value


_RATIO: Final = re.compile(r"[0-9]{1,9}(/[0-9]{1,9})?")
_Seconds = Annotated[float, Field(gt=0, allow_inf_nan=False)]
_SocketName = Annotated[str, PlainValidator(_registered_socket)]


class ScenarioAnnotation(BaseModel):
    """The content of the annotation; an entry that is missing has its default.

    Attributes:
        step: The macro step [s].
        scene: The values of the scene.
        sockets: The sockets that units fill, by unit.
        held: The values of inputs that nothing drives, by input; bytes are hexadecimal digits.
        algorithm: The name of the master algorithm.
        solve_loops: Whether algebraic loops are solved.
        end_off_road: Whether the run ends where the vehicle leaves the surroundings of the road.
        tolerance: The relative tolerance that all FMUs are told.
        record: The signals that are recorded: by pattern, at every how many ticks.
        allow_nonfinite: Patterns of the signals that may be infinite or not a number although a unit reads them.
        table: The name of the file in the archive that inputs follow, as the name of a resource.
        table_holds: Whether its values hold until the next row.
        steps: The steps of units, as multiples of the macro step.
        isolated: The time [s] that one call may take of a unit for which a process of its own was requested.
        in_process: The FMUs for which the process of the run was requested.
        through_step: The outputs of a unit that its inputs reach through a step only, whatever its file says of them.
        sources: Where the values of the scene and the experiment come from; parameter sets have those of parameters.
    """

    model_config = ConfigDict(extra="forbid")

    step: _Seconds
    scene: dict[str, Any] | None = None
    sockets: dict[str, _SocketName]
    held: dict[str, Any] = {}
    algorithm: str = Algorithm.SEQUENTIAL
    solve_loops: bool = False
    end_off_road: bool = False
    tolerance: Annotated[float, Field(gt=0, allow_inf_nan=False)] | None = None
    record: dict[str, Annotated[int, Field(ge=0)]] = dict(EVERYTHING)
    allow_nonfinite: list[str] = []
    table: str | None = None
    table_holds: bool = False
    steps: dict[str, Annotated[Fraction, BeforeValidator(_ratio)]] = {}
    isolated: dict[str, _Seconds] = {}
    in_process: list[str] = []
    through_step: dict[str, list[str]] = {}
    sources: dict[str, dict[str, Any]] = {}

    def held_values(self, units: Mapping[str, UnitSource]) -> dict[str, Any]:
        """The values of inputs as their units take them: texts of binary inputs become bytes.

        Raises:
            RequestError: A text of a binary input is not hexadecimal.
        """
        types = {f"{n}.{v.name}": v.quantity.type for n, s in units.items() for v in s.interface.inputs}
        return {path: _as_bytes(path, v) if types.get(path) is Type.BINARY else v for path, v in self.held.items()}


_LISTED: Final = 6
"""The outputs that a remark lists."""
NO_ANNOTATION: Final = ScenarioAnnotation(step=STEP, sockets={})
"""What holds for a system of another maker."""


def table_path(table: InputTable) -> str:
    """The path of the file of a table in the archive."""
    return resource(f"inputs{table.file_suffix}")


def annotation_of(scenario: Scenario) -> str:
    """The text of the annotation for a scenario, in JSON."""
    system = scenario.system
    described = {name: source.describe() for name, source in system.units.items()}
    requested = {name: one.isolated for name, one in described.items() if one.requested}
    annotation = ScenarioAnnotation.model_construct(  # what is written has been checked
        step=scenario.h,
        scene=asdict(scenario.scene) if scenario.scene else None,  # type: ignore[call-overload]
        sockets={name: socket.name for name, socket in system.sockets.items()},
        held={path: np.asarray(value, dtype=object).tolist() for path, value in system.held.items()},
        algorithm=scenario.algorithm.value,
        solve_loops=scenario.solve_loops,
        end_off_road=scenario.end_off_road,
        tolerance=scenario.tolerance,
        record=dict(scenario.record),
        allow_nonfinite=list(system.allow_nonfinite),
        table=None if system.table is None else table_path(system.table),
        table_holds=system.table is not None and system.table.hold,
        steps=dict(system.steps),
        isolated={name: seconds for name, seconds in requested.items() if seconds is not None},
        in_process=[name for name, seconds in requested.items() if seconds is None],
        through_step={n: sorted(source.through_step) for n, source in system.units.items() if source.through_step},
        sources={p: dict(s) for p, s in scenario.sources.items() if p.startswith(("scene.", "experiment."))},
    )
    return json.dumps(dict(annotation), default=_as_json)


def _as_json(value: Any) -> Any:
    """A value that JSON has no type for: bytes as hexadecimal digits, a ratio as text, a number of NumPy."""
    if isinstance(value, Fraction):
        return str(value)
    return value.hex() if isinstance(value, bytes) else value.item()


def _as_bytes(path: str, value: Any) -> Any:
    if isinstance(value, list):
        return [_as_bytes(path, item) for item in value]  # type: ignore[unknown]
    try:
        return bytes.fromhex(value)
    except (TypeError, ValueError) as error:
        raise refuse(f"held.{path}", f"`{value}`", "hexadecimal digits, two for each byte") from error


def read_annotation(document: Document) -> ScenarioAnnotation | None:
    """The annotation in a description; None in a system of another maker.

    Raises:
        RequestError: The annotation was changed and cannot be understood.
    """
    node = document.root.find(f".//{qualified(OURS, Tag.SCENARIO)}")
    if node is None or not node.text:
        return None
    valid = "what macrostep wrote"
    try:
        content: Any = json.loads(node.text)
    except (ValueError, RecursionError) as error:
        raise refuse(document.at(node), f"an annotation that is no JSON ({error})", valid) from error
    if not isinstance(content, dict) or not {"step", "sockets"} <= content.keys():
        raise refuse(document.at(node), "an annotation without a step or sockets", valid)
    return checked(ScenarioAnnotation, content, document.at(node))  # type: ignore[unknown]


def acting_through_step(
    units: Mapping[str, UnitSource], known: ScenarioAnnotation, findings: Findings
) -> dict[str, UnitSource]:
    """The units, as the annotation says that they act in time; each that its file says more of is told as a remark.

    Args:
        units: All units of the system.
        known: The annotation.
        findings: Where problems and remarks are gathered.
    """
    acting = {**units}
    for name, outputs in known.through_step.items():
        shown = [v.name for v in units[name].interface.outputs] if name in units else []
        if unknown := [output for output in outputs if output not in shown]:
            findings.add_problem(f"through_step: {name}.{unknown[0]}", "no such output", choices(shown or units))
            continue
        acting[name] = units[name].acting_through_step(outputs)
        how = "follow the inputs through a step only, as the file says, whatever the FMU declares"
        findings.remarks.append(f"{name}: {listed(outputs, _LISTED)} {how}")
    return acting
