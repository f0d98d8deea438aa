"""The form of a scenario file as a JSON schema, with which editors complete and check it."""

from __future__ import annotations

from collections.abc import Iterator
from copy import deepcopy
from typing import Any

from components import BLOCKS
from components.interfaces.quantity import Quantity
from components.interfaces.record import variables
from components.interfaces.sockets import SOCKETS
from orchestrator.scenario.parameters import PARAMETERS
from orchestrator.scenario.scenario_file import scenario_model
from orchestrator.system.experiment import Algorithm
from orchestrator.system.scene import Scene


def scenario_schema() -> dict[str, Any]:
    """The JSON schema (draft 2020-12) of a scenario file, with the sockets, blocks and parameters known here."""
    schema = scenario_model().model_json_schema()
    schema |= {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": "A scenario of macrostep"}
    parts = schema["$defs"]
    parts["ExperimentTable"]["properties"]["algorithm"]["enum"] = [*Algorithm]
    filling = parts.pop("SocketFilling")
    for socket in SOCKETS.values():
        named = parts[f"{socket.name}.filling"] = deepcopy(filling)
        blocks = [block for block in BLOCKS.values() if block.socket == socket]
        named["title"] = f"The unit of the socket {socket.name}"
        named["properties"]["block"] = {"description": "A block.", "enum": [block.name for block in blocks]}
        named["properties"]["use"]["items"]["enum"] = sorted(PARAMETERS)
        described = ((v.name, v.quantity, block.name) for block in blocks for v in block.parameters())
        named["properties"]["parameters"]["properties"] = _parameters(described)
        schema["properties"][socket.name] = {"$ref": f"#/$defs/{socket.name}.filling"}
    scene = ((v.name, v.quantity, "") for v in variables(Scene))
    parts["SceneOverrides"]["properties"]["parameters"]["properties"] = _parameters(scene)
    return schema


def _parameters(found: Iterator[tuple[str, Quantity, str]]) -> dict[str, Any]:
    """The parameters by name, each with its meaning, what is valid, and the blocks that have it."""
    meanings: dict[str, dict[str, list[str]]] = {}
    for name, quantity, block in found:
        meaning = f"{quantity.description}; {quantity.range}"
        meanings.setdefault(name, {}).setdefault(meaning, []).append(block)
    return {name: {"$ref": "#/$defs/Given", "description": _joined(told)} for name, told in meanings.items()}


def _joined(told: dict[str, list[str]]) -> str:
    return "; or ".join(f"{meaning} ({', '.join(names)})" if any(names) else meaning for meaning, names in told.items())
