"""Blocks and scenarios in words: parameters, inputs and outputs with units of measurement, ranges and meaning."""

from __future__ import annotations

import inspect
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from components import BLOCKS
from components.interfaces.block import Block
from components.interfaces.problem import choices, did_you_mean, refuse
from components.interfaces.record import Variable
from fmus.modelica.block import OWN_NAMES
from fmus.modelica.build_modelica import read_modelica
from orchestrator.exchange.fmu_in_words import aligned
from orchestrator.scenario import scenario_file
from orchestrator.scenario.parameters import block_parameters


def modelica_in_words(request: str, socket: str | None) -> tuple[list[str], str] | None:
    """What a model of a Modelica file is as a block, and the socket that it fills by its names.

    Args:
        request: The file, or the file and the model.
        socket: The name of the socket that it is meant for; None for any.

    Returns:
        The lines and the name of the socket; None for a model with names of its own.

    Raises:
        RequestError: The model cannot become a block.
    """
    model = read_modelica(request, socket)
    if model.block.socket is OWN_NAMES:
        return None
    return _in_words(model.block, model.start, {}), model.block.socket.name


def in_words(name: str) -> list[str]:
    """What a block or a scenario of the catalogue is, by its name. Raises `RequestError` where there is none."""
    if name in BLOCKS:
        return block_in_words(name)
    known = [*BLOCKS, *scenario_file.names()]
    if name not in known:
        raise refuse(name, "no block or scenario of this name", choices(known), did_you_mean(name, known))
    return _scenario(name)


def block_in_words(name: str) -> list[str]:
    """What a block is, by its name in `BLOCKS`."""
    given = block_parameters(name)
    values, sources = ({n: getattr(g, part) for n, g in given.items()} for part in ("value", "source"))
    return _in_words(BLOCKS[name], values, sources)


def _scenario(name: str) -> list[str]:
    content = scenario_file.read(name)[1]
    times = content.experiment
    rows = [("unit", "is", "parameters of its own")]
    for unit, filling in content.units.items():
        own = [
            *(f"those of `{u}`" for u in filling.use),
            *(f"{n}={_text(g.value)}" for n, g in filling.parameters.items()),
        ]
        rows.append((f"  {unit}", filling.block or filling.fmu or "", ", ".join(own)))
    step, stop = (f"{_text(given.value)} {given.unit}" for given in (times.step, times.stop_time))
    return [
        f"{name}: {content.title}",
        *(f"  {line}" for line in content.description.splitlines()),
        f"  {times.algorithm}, steps of {step} up to {stop}",
        "",
        *aligned(rows),
        "",
        "The parameters of a block: macrostep list BLOCK",
    ]


def _in_words(block: type[Block[Any, Any, Any]], values: Mapping[str, Any], sources: Mapping[str, str]) -> list[str]:
    about = inspect.cleandoc(block.__doc__ or "").splitlines()
    lines = [f"{block.name}: a block of the socket {block.socket.name}", *(f"  {line}".rstrip() for line in about), ""]
    if block.parameters():
        rows = [("parameter", "value", "valid", "meaning", "source")]
        rows += [
            (
                f"  {p.name}",
                _text(values.get(p.name)),
                p.quantity.range,
                p.quantity.description,
                sources.get(p.name, ""),
            )
            for p in block.parameters()
        ]
        lines += [*aligned(rows), ""]
    for heading, variables in (("input", block.inputs()), ("output", block.outputs())):
        lines += [*aligned([(heading, "unit", "meaning"), *_signals(variables)]), ""]
    return lines[:-1]


def _signals(variables: tuple[Variable, ...]) -> Iterator[tuple[str, str, str]]:
    for v in variables:
        size = f"[{','.join(map(str, v.shape))}]" if v.shape else ""
        yield f"  {v.name}{size}", v.quantity.unit, v.quantity.description


def _text(value: Any) -> str:
    return "" if value is None else str(np.asarray(value).tolist())
