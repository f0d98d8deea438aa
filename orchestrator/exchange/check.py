"""Checking a file before it is used: what it is, which rules it breaks, whether it starts, and which socket it fits."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from components import BLOCKS
from components.interfaces.problem import Problem, RequestError, choices, did_you_mean, refuse
from components.interfaces.progress import SILENT, Progress
from components.interfaces.sockets import SOCKETS
from fmus.modelica.build_modelica import file_of, is_modelica
from fmus.reading.archive import Archive
from fmus.toolchain.door import reading
from fmus.unit_interface import Interface
from orchestrator.exchange.catalogue_in_words import block_in_words, modelica_in_words
from orchestrator.exchange.conversions_in_words import conversions_in_words
from orchestrator.exchange.fmu_in_words import aligned, described, rule_breaches, variables
from orchestrator.exchange.trial import Trial, try_first_step
from orchestrator.mapping.fitting import fit
from orchestrator.mapping.fitting_result import Fitting
from orchestrator.mapping.mapping_file import MappingFile
from orchestrator.mapping.mapping_reader import read_mapping
from orchestrator.mapping.template import relative, template, write_template
from orchestrator.scenario.requested_fmus import RequestedFmus
from orchestrator.stepping.schedule import schedule
from orchestrator.system.contents import is_file
from orchestrator.system.source import Fmu


@dataclass(frozen=True)
class Checked:
    """The result of a check."""

    lines: tuple[str, ...]
    """The description of the file."""
    good: bool
    """Whether the file keeps all rules, and fits the socket that was asked for."""
    problems: tuple[Problem, ...] = ()


def check(  # noqa: PLR0913 - each is an option of the command
    path: Path,
    socket: str | None = None,
    out: Path | None = None,
    *,
    static: bool = False,
    lenient: bool = False,
    progress: Progress = SILENT,
) -> Checked:
    """Check an FMU, an SSP, a mapping or a Modelica file, or describe a block; write a template of a mapping if of use.

    Args:
        path: The file, `FILE.mo:MODEL`, or the name of a block.
        socket: The socket that an FMU is meant for; the fit to every socket is described if not given.
        static: Whether an FMU is only read, and not tried.
        lenient: Whether rules may be broken that do not keep the file from running; notes say which.
        out: Where the template goes; to NAME.SOCKET.toml in the working folder if not given, unless that file exists.
        progress: Is told before a Modelica model is built, and before sources of an FMU are compiled.

    Returns:
        The description of the file, with everything that is wrong with it.

    Raises:
        RequestError: The request itself is wrong.
    """
    if socket is not None and socket not in SOCKETS:
        raise refuse("--socket", f"`{socket}`", choices(SOCKETS), did_you_mean(socket, SOCKETS))
    if str(path) in BLOCKS and out is None and not path.exists():
        return Checked(tuple(block_in_words(str(path))), good=True)
    _refuse_wrong(path, socket, out)
    try:
        with reading(str(path), "a file that can be checked"):
            filling = modelica_in_words(str(path), socket) if out is None and is_modelica(str(path)) else None
            if filling is not None:
                lines, fills = filling
                return Checked((*lines, *_to_run([_typed("run", "static", f"--{fills}", path)])), good=True)
            if path.suffix == ".ssp":
                return _ssp(path, lenient=lenient)
            mapping = read_mapping(path, socket) if path.suffix == ".toml" else None
            where = path if mapping is None else mapping.fmu
            if where is None:
                raise refuse(f"{path}: fmu", "nothing", "the path of the FMU, relative to this file")
            fmu = RequestedFmus(progress=progress).fmu(str(where))
            archive, broken = opened(fmu)
            tried = None if static else try_first_step(fmu, progress, lenient=bool(broken))
            return _fmu(path, _Found(where, archive, broken, tried, lenient), mapping, socket, out)
    except RequestError as error:
        return Checked((f"{path}: cannot be used",), good=False, problems=error.problems)


def _refuse_wrong(path: Path, socket: str | None, out: Path | None) -> None:
    """Refuse a file that cannot be checked, and a template that cannot be written. Raises `RequestError`."""
    modelica = is_modelica(str(path))
    if not modelica and (path.suffix not in {".fmu", ".ssp", ".toml"} or not is_file(path)):
        found = "no such file" if not is_file(path) else f"a file ending in `{path.suffix}`"
        valid = "an .fmu, an .ssp, the .toml that maps an FMU, a Modelica file (FILE.mo or FILE.mo:MODEL), or a block"
        raise refuse(str(path), found, valid, did_you_mean(str(path), BLOCKS))
    if out is not None and (socket is None or not (modelica or path.suffix == ".fmu")):
        valid = "FILE.fmu or FILE.mo with --socket SOCKET --out FILE.toml"
        raise refuse("--out", "a template without an FMU or a Modelica file and its socket", valid)
    if out is not None and out.exists():
        raise refuse(str(out), "a file", "a new file", "Choose another name, or remove it.")


def _ssp(path: Path, *, lenient: bool) -> Checked:
    """Describe the system in an SSP file."""
    from orchestrator.scenario.options import Options  # noqa: PLC0415 - as the reader
    from orchestrator.ssp import reader as ssp_reader  # noqa: PLC0415 - slow to import

    scenario = ssp_reader.read(path, options=Options(lenient=lenient))
    system = scenario.system
    lines = [f"{path.name}: {scenario.title or scenario.name}", f"{scenario.h:g} s steps to {scenario.until:g} s", ""]
    lines += ["units"]
    lines += aligned(
        (f"  {name}", source.interface.kind, f"socket {system.sockets[name].name}" if name in system.sockets else "")
        for name, source in system.units.items()
    )
    lines += ["", "connections", *(f"  {wire}" for wire in system.connections)]
    lines += [f"  {path} = {value}" for path, value in system.held.items()]
    lines += [f"note: {remark}" for remark in scenario.remarks]
    try:
        schedule(system, scenario.algorithm, solve_loops=scenario.solve_loops)
    except RequestError as error:
        return Checked(tuple(lines), good=False, problems=error.problems)
    return Checked((*lines, *_to_run([_typed("run", path, *["--lenient"] * lenient)])), good=True)


@dataclass(frozen=True)
class _Found:
    """An FMU that has been read, with the problems that a strict reader has, and how its trial went."""

    where: Path
    """The FMU, or the Modelica model that it was built of."""
    archive: Archive
    broken: tuple[Problem, ...]
    tried: Trial | None
    lenient: bool

    @property
    def problems(self) -> tuple[Problem, ...]:
        """What is wrong with it, without what may be broken."""
        return (*(() if self.lenient else self.broken), *(self.tried.problems if self.tried else ()))


def _fmu(path: Path, found: _Found, mapping: MappingFile | None, socket: str | None, out: Path | None) -> Checked:
    """Describe an FMU, and how it fits a socket by itself or with its mapping file."""
    where, archive, broken, tried = found.where, found.archive, found.broken, found.tried
    problems, leniently = found.problems, ["--lenient"] * bool(broken)  # as `run` needs it
    theirs = archive.interface
    lines = [*described(where.name, archive), *rule_breaches(archive, broken)]
    if tried is not None:
        lines += [f"  {tried.reached}", *(f"  note: {remark}" for remark in tried.remarks)]
    lines += ["", *variables(archive), ""]
    socket_name = socket or (mapping.socket if mapping else None)
    if socket_name is None:
        fittings = {name: fit(name, SOCKETS[name], theirs, str(where), mapping) for name in SOCKETS}
        lines += _sockets(path, fittings)
        lines += _next(path, archive, fittings, leniently) if not tried or not tried.problems else []
        return Checked(tuple(lines), good=not problems, problems=problems)
    fitting = fit(socket_name, SOCKETS[socket_name], theirs, str(where), mapping)
    lines += [f"socket {socket_name}: {fit_in_words(fitting)}", *_rows(fitting)]
    if fitting.needed and not fitting.problems:
        lines += ["conversions", *(f"  {line}" for line in conversions_in_words(fitting, theirs))]
    if mapping is None and (out is not None or fitting.needed):
        try:
            lines.append(_template(where, socket_name, fitting, theirs, out))
        except RequestError as error:
            if out is not None:
                raise
            lines += [f"not written, the mapping: {problem}" for problem in error.problems]
    problems += tuple(fitting.problems)
    lines += [] if problems else _to_run([_typed("run", "static", f"--{socket_name}", path, *leniently)])
    return Checked(tuple(lines), good=not problems, problems=problems)


def _sockets(path: Path, fittings: Mapping[str, Fitting]) -> list[str]:
    """How an FMU fits every socket, with the signals of the one that it fits best."""
    best = max(fittings, key=lambda name: _share(fittings[name]))
    lines = ["sockets", *aligned((f"  {name}", fit_in_words(fitting)) for name, fitting in fittings.items())]
    if _share(fittings[best]):
        lines += ["", *_rows(fittings[best])]
        if fittings[best].problems:
            lines.append(f"For a mapping file: {_typed('check', path, '--socket', best)}")
    return lines


def _next(path: Path, archive: Archive, fittings: Mapping[str, Fitting], leniently: Sequence[str]) -> list[str]:
    """The commands that run an FMU: by itself, and in the sockets that it fits."""
    stop = ["--stop-time", "10"] if archive.suggested.stop is None else []
    fitting = [name for name, found in fittings.items() if not found.problems]
    alone = [] if is_modelica(str(path)) else [_typed("run", path, *stop, *leniently)]
    return _to_run([*alone, *(_typed("run", "static", f"--{n}", path, *leniently) for n in fitting)])


def _typed(*words: object) -> str:
    """A command as a person types it, whatever signs a path has."""
    return shlex.join(["macrostep", *map(str, words)])


def _to_run(commands: Sequence[str]) -> list[str]:
    """What to type next."""
    return ["", "To run it:", *(f"  {command}" for command in commands)] if commands else []


def opened(fmu: Fmu) -> tuple[Archive, tuple[Problem, ...]]:
    """Read an FMU, leniently where it breaks rules; return it with the problems that a strict reader finds.

    Raises:
        RequestError: The FMU cannot be read leniently either.
    """
    try:
        return fmu.archive, ()
    except RequestError as error:
        return replace(fmu, lenient=True).archive, error.problems


def _template(path: Path, socket: str, fitting: Fitting, theirs: Interface, out: Path | None) -> str:
    """Write the template, unless its default file exists already."""
    target = out or Path(f"{file_of(str(path)).stem}.{socket}.toml")
    if out is None and target.exists():
        return f"{target} is kept as it is; another mapping goes to --out FILE.toml"
    text = template(fitting, SOCKETS[socket], theirs, relative(path, target.parent), str(target))
    write_template(text, target)
    return f"written: {target}, a mapping {'to fill in' if fitting.problems else 'to change as you like'}"


def _rows(fitting: Fitting) -> list[str]:
    """What stands for each signal of the socket, without the optional signals that are absent."""
    shown = [row for row in fitting.rows if row.theirs or row.needed or row.note]
    lines = aligned(
        (
            f"  {row.signal.name}",
            f"[{row.signal.quantity.unit}]" if row.signal.quantity.type.is_float else f"{row.signal.quantity.type}",
            row.theirs or ("missing" if row.needed else "-"),
            row.note,
        )
        for row in shown
    )
    shown_signals = {row.signal.name for row in shown}
    return [*lines, *(f"  note: {r.text}" for r in fitting.noticed if r.signal not in shown_signals)]


def fit_in_words(fitting: Fitting) -> str:
    """Whether an FMU fits a socket, as a phrase."""
    needed = [row for row in fitting.rows if row.needed]
    present = sum(bool(row.theirs) for row in needed)
    if fitting.problems:
        return f"does not fit, {present} of {len(needed)} signals found"
    return "fits, with the conversions below" if fitting.needed else "fits as it is"


def _share(fitting: Fitting) -> float:
    """How well an FMU fits: the share of the needed signals that it has, and one more where it fits."""
    needed = [row for row in fitting.rows if row.needed]
    return sum(bool(row.theirs) for row in needed) / len(needed) + (not fitting.problems)
