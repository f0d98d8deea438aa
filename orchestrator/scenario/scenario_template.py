"""A scenario file to begin with: that of another scenario, with everything that may stand in it as comments."""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

from components import BLOCKS
from components.interfaces.quantity import Quantity
from components.interfaces.record import variables
from components.interfaces.sockets import SOCKETS
from orchestrator.mapping.mapping_file import toml_value
from orchestrator.mapping.template import relative
from orchestrator.scenario.parameters import block_parameters, parameter_set
from orchestrator.scenario.scenario_file import SocketFilling, read
from orchestrator.system.experiment import Algorithm
from orchestrator.system.files import Given
from orchestrator.system.scene import Scene


def scenario_template(base: str, path: Path) -> str:
    """The text of a new scenario file, which runs as it is.

    Args:
        base: The scenario whose values it has: a name, or a file.
        path: The file that it is for.

    Raises:
        RequestError: There is no such scenario, or its file has wrong entries.
    """
    name, content = read(base)
    times = content.experiment
    lines = [
        f"# Run it: macrostep run {shlex.quote(str(path))}",
        '# A value is { value = ..., unit = "...", source = "..." }; `source` may be left out. What is commented out',
        "# has the value that it shows. For an editor that completes and checks this file:",
        "# macrostep scenario --schema > FILE.json, and `#:schema FILE.json` as the first line here.",
        f"title = {toml_value(content.title)}",
        f"description = {toml_value(f'The scenario `{name}`, to be changed.')}",
        "",
        "[experiment]",
        f"step = {_given(times.step)}",
        f"stop_time = {_given(times.stop_time)}",
        f"{'' if times.start_time else '# '}start_time = {_given(times.start_time or Given(value=0.0, unit='s'))}",
        f"{'' if times.tolerance else '# '}tolerance = {_given(times.tolerance or Given(value=1e-6))}  # for all FMUs",
        f"algorithm = {toml_value(times.algorithm)}  # {', '.join(Algorithm)}",
        f"solve_loops = {toml_value(times.solve_loops)}  # algebraic loops are solved by iteration",
        f"end_off_road = {toml_value(times.end_off_road)}  # the run ends where the vehicle leaves the surroundings",
    ]
    for socket, filling in content.units.items():
        lines += ["", f"[{socket}]", *_filling(socket, _beside(filling, base, path))]
    scene = [(v.name, v.quantity) for v in variables(Scene)]
    lines += ["", "[scene.parameters]  # the road and the vehicle's size, for metrics and pictures"]
    lines += _parameters(scene, parameter_set("scene"), content.scene.parameters)
    every = dict(content.record) or {"*": 1}
    lines += ["", "[record]  # at every how many ticks signals are recorded, 0 for never; the last that fits counts"]
    lines += [f"{toml_value(pattern)} = {ticks}" for pattern, ticks in every.items()]
    lines += ["", "# [sweep]  # what `macrostep sweep` does with this file", '# samples = "sobol:64"']
    lines += ["# [sweep.vary]", '# "plant.m" = { values = "1500:2500", unit = "kg", source = "..." }']
    return "\n".join(lines) + "\n"


def _beside(filling: SocketFilling, base: str, path: Path) -> SocketFilling:
    """The filling with the paths of its files relative to the new file."""
    named = {part: file for part in ("fmu", "mapping") if (file := getattr(filling, part)) is not None}
    folder = Path(base).parent
    return filling.model_copy(update={part: relative(folder / file, path.parent) for part, file in named.items()})


def _filling(socket: str, filling: SocketFilling) -> Iterator[str]:
    others = ", ".join(name for name, block in BLOCKS.items() if block.socket == SOCKETS[socket])
    if filling.block is not None:
        yield f"block = {toml_value(filling.block)}  # {others}"
        yield '# fmu = "mine.fmu"  # in place of the block: an FMU or a Modelica file; mapping = "mine.toml" if need be'
    else:
        yield f"fmu = {toml_value(filling.fmu)}  # or block = one of {others}"
        if filling.mapping is not None:
            yield f"mapping = {toml_value(filling.mapping)}"
    if filling.interface is not None:
        yield f"interface = {toml_value(filling.interface)}"
    if filling.use:
        yield f"use = {toml_value(filling.use)}  # files of values"
    yield f"{'' if filling.step else '# '}step = {_given(filling.step or Given(value=0.1, unit='s'))}  # its own step"
    yield ""
    yield f"[{socket}.parameters]"
    if filling.block is not None:
        declared = [(v.name, v.quantity) for v in BLOCKS[filling.block].parameters()]
        used = {n: g for name in filling.use for n, g in parameter_set(name).items()}
        yield from _parameters(declared, block_parameters(filling.block) | used, filling.parameters)
    else:
        yield from _parameters([], {}, filling.parameters)


def _parameters(
    declared: Iterable[tuple[str, Quantity]], defaults: Mapping[str, Given], own: Mapping[str, Given]
) -> Iterator[str]:
    """A line for each parameter, commented out where the value is not the scenario's own."""
    quantities = dict(declared)
    for name in dict.fromkeys((*quantities, *own)):
        given = own.get(name) or defaults.get(name)
        if given is not None:
            told = [quantities[name].description, quantities[name].range] if name in quantities else []
            remark = "; ".join([*told, *([given.source] if given.source else [])])
            yield f"{'' if name in own else '# '}{name} = {_given(given)}  # {remark}"


def _given(given: Given) -> str:
    """A value without its source: who changes the value does not claim that it is the source's."""
    return f"{{ value = {toml_value(given.value)}, unit = {toml_value(given.unit)} }}"
