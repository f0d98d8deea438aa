"""The plan of a sweep: what was asked for, checked as a whole before anything runs, and the values of every variant."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from itertools import product

from components.interfaces.problem import Gathered, Problem, RequestError, raise_if_any, refuse
from components.interfaces.progress import SILENT, Progress
from components.interfaces.quantity import Quantity
from components.interfaces.record import variables
from components.interfaces.sockets import SOCKETS
from orchestrator.loading import load
from orchestrator.scenario.options import Options
from orchestrator.scenario.resolution import Setting, resolve, resolve_unit
from orchestrator.sweeping.sampling import SAMPLES_OPTION, SEARCH, TABLES, Columns, Sampling, read_sampling, sampled
from orchestrator.sweeping.sweep_request import SweepRequest, absolute_file
from orchestrator.sweeping.variation import VARY, Variation, split, twice, value_problems, variation
from orchestrator.sweeping.watched_signals import SIGNALS_OPTION, UNWATCHED, WatchedSignals, watched_signals
from orchestrator.system.experiment import Scenario
from orchestrator.system.named_variables import UnitVariable, look_up, named, settable
from orchestrator.system.scene import Scene


@dataclass(frozen=True)
class Variant:
    """One run of many."""

    number: int
    settings: tuple[str, ...]
    """The values of its parameters, as `--set` takes them."""
    fillings: Mapping[str, str] = field(default_factory=dict[str, str])
    """What fills the sockets that vary."""


@dataclass(frozen=True)
class PlannedSweep:
    """A request that has been checked, with the values of all variants."""

    request: SweepRequest
    sampling: Sampling
    variations: tuple[Variation, ...]
    columns: Columns
    """The value of each path in each variant, as `--set` takes it."""
    quantities: Mapping[str, Quantity | None]
    """What each path is; None for a socket."""
    scenarios: Mapping[str, Scenario]
    """The scenario with each combination of units that fill sockets, before anything else varies."""
    watched: WatchedSignals = UNWATCHED
    """The signals that are kept; none in a search, which looks where failures are."""

    @property
    def scenario(self) -> Scenario:
        """The first of the scenarios."""
        return next(iter(self.scenarios.values()))

    def __len__(self) -> int:
        return len(next(iter(self.columns.values())))

    @cached_property
    def _fillings(self) -> list[str]:
        return [path for path in self.columns if path in SOCKETS]

    def variant(self, number: int) -> Variant:
        """One of the variants, which are numbered from 0 on."""
        settings = tuple(f"{path}={values[number]}" for path, values in self.columns.items() if path not in SOCKETS)
        return Variant(number, settings, {path: self.columns[path][number] for path in self._fillings})

    def unit(self, path: str) -> str:
        """The unit of measurement of what varies; empty for a socket."""
        quantity = self.quantities[path]
        return "" if quantity is None else quantity.unit

    def options_of(self, variant: Variant) -> Options:
        """The options with which `macrostep run` runs a variant."""
        return options_of(self.request.options, variant)


def options_of(options: Options, variant: Variant) -> Options:
    """The options of one variant.

    Args:
        options: Those of all variants.
        variant: The variant, whose settings come last.
    """
    return replace(
        options,
        settings=(*options.settings, *variant.settings),
        replacements={**options.replacements, **variant.fillings},
    )


def plan(request: SweepRequest, progress: Progress = SILENT) -> PlannedSweep:
    """Check a request, build the FMUs that it needs, and sample its variants.

    Args:
        request: What was asked for.
        progress: Receives reports on what is being built.

    Raises:
        RequestError: Something is wrong with it; the error has all problems.
    """
    wrong = Gathered()
    if request.seed < 0:
        wrong.problems.append(Problem("--seed", f"{request.seed}", "a whole number, 0 or more"))
    asked, columns = _asked(request, wrong)
    fillings = {path: one.choices for path, one in asked.items() if isinstance(one, Variation)}
    scenarios = wrong.attempt(lambda: _scenarios(request, fillings, progress), dict[str, Scenario]())
    quantities: dict[str, Quantity | None] = {}
    variations: list[Variation] = []
    for path, one in asked.items() if scenarios else ():
        found = wrong.attempt(lambda path=path: [_quantity(path, scenarios)], list[Quantity | None]())
        for quantity in found:  # it is one, or there is none
            quantities[path] = quantity
            read = partial(_variation, path, one, quantity, columns.get(path))
            variations += wrong.attempt(lambda read=read: [read()], list[Variation]())
    everything = bool(asked) and len(variations) == len(asked)
    sampling = wrong.attempt(lambda: _sampling(request, variations), None)
    if sampling is not None and everything and not wrong.problems:
        columns = columns or _values(sampling, variations, request.seed)
        where = f"{SAMPLES_OPTION} {request.samples}, row " if sampling.table is not None else ""
        wrong.problems += [p for v in variations for p in value_problems(v, columns[v.path], quantities[v.path], where)]
    watched = UNWATCHED
    if scenarios and request.find is None:
        count = len(next(iter(columns.values()), ()))
        watched = wrong.attempt(lambda: watched_signals(request.signals, scenarios, count), watched)
    raise_if_any(dict.fromkeys(wrong.problems))
    assert sampling is not None  # noqa: S101 - it would be a problem
    return PlannedSweep(request, sampling, tuple(variations), columns, quantities, scenarios, watched)


def _values(sampling: Sampling, variations: Sequence[Variation], seed: int) -> Columns:
    if sampling.kind == SEARCH:
        return {v.path: list[str]() for v in variations}
    return sampled(sampling, variations, seed)


def _sampling(request: SweepRequest, variations: Sequence[Variation]) -> Sampling:
    if request.find is None:
        return read_sampling(request.samples, request.grid, variations)
    from orchestrator.sweeping.search import FIND, read_aim, read_budget  # noqa: PLC0415 - that module leads here

    read_aim(request.find)
    read_budget(request.budget)
    if request.signals:
        raise refuse(f"{FIND} {request.find}", f"it beside {SIGNALS_OPTION}", "one of them")
    if request.samples is not None or request.grid is not None:
        raise refuse(f"{FIND} {request.find}", "it beside --samples or --grid", "one of them")
    return Sampling(SEARCH)


def _asked(request: SweepRequest, wrong: Gathered) -> tuple[dict[str, Variation | str], Columns]:
    """What varies, a socket with its units and a parameter by its text; and the values where a table has them."""
    pairs = [pair for text in request.vary if (pair := wrong.attempt(lambda text=text: split(text), None))]
    wrong.problems += twice(pairs)
    columns: Columns = {}
    texts = dict(pairs)
    if request.samples is not None and request.samples.endswith(TABLES):
        if pairs:
            wrong.problems.append(Problem(VARY, f"it beside the table {request.samples}", "one of them"))
        columns = wrong.attempt(lambda: sampled(read_sampling(request.samples, request.grid, ()), (), 0), columns)
        texts = {path: f"{len(values)} values of the table" for path, values in columns.items()}
    elif not request.vary:
        wrong.problems.append(Problem(VARY, "nothing that varies", "PATH=VALUES", "Try --vary plant.m=1500:2500."))
    asked: dict[str, Variation | str] = {}
    for path, text in texts.items():
        if path in SOCKETS:
            values = columns.get(path)
            asked |= wrong.attempt(lambda p=path, t=text, v=values: {p: _filling(p, t, v)}, dict[str, Variation]())
        else:
            asked[path] = text
    for path in columns.keys() & SOCKETS.keys():
        columns[path] = [absolute_file(unit) for unit in columns[path]]
    return asked, columns


def _filling(socket: str, text: str, values: Sequence[str] | None) -> Variation:
    """The units that fill a socket, files by their absolute paths. Raises `RequestError`."""
    found = variation(socket, text, None) if values is None else Variation(socket, text, tuple(dict.fromkeys(values)))
    units = tuple(absolute_file(unit) for unit in found.choices)
    if len(set(units)) < len(units) and values is None:
        raise refuse(f"{VARY} {socket}={text}", "a unit twice", "a list of different units")
    return replace(found, choices=tuple(dict.fromkeys(units)))


def _variation(path: str, asked: Variation | str, quantity: Quantity | None, values: Sequence[str] | None) -> Variation:
    if isinstance(asked, Variation):
        return asked
    return variation(path, asked, quantity) if values is None else Variation(path, asked, tuple(dict.fromkeys(values)))


def _scenarios(request: SweepRequest, fillings: Mapping[str, Sequence[str]], progress: Progress) -> dict[str, Scenario]:
    """The scenario with each combination of units that fill sockets, which is named, without the values that vary."""
    scenarios: dict[str, Scenario] = {}
    wrong = Gathered()
    for chosen in product(*fillings.values()):
        filled = dict(zip(fillings, chosen, strict=True))
        options = replace(request.options, replacements={**request.options.replacements, **filled})
        scenario = wrong.attempt(lambda options=options: load(request.scenario, options, progress), None)
        if scenario is not None:
            scenarios[", ".join(f"{socket}={unit}" for socket, unit in filled.items())] = scenario
    raise_if_any(dict.fromkeys(wrong.problems))
    return scenarios


def _quantity(path: str, scenarios: Mapping[str, Scenario]) -> Quantity | None:
    """What a path is in every scenario; None for a socket. Raises `RequestError` where it is nothing."""
    if path in SOCKETS:
        return None
    found: list[UnitVariable] = []
    for filled, scenario in scenarios.items():
        try:
            found.append(_variable(path, scenario))
        except RequestError as error:
            told = [replace(p, found=f"{p.found}, with {filled}" if filled else p.found) for p in error.problems]
            raise RequestError(told) from None
    kinds = {
        (v.variable.quantity.type, v.variable.quantity.unit): filled for v, filled in zip(found, scenarios, strict=True)
    }
    if len(kinds) > 1:
        told = ", ".join(f"{kind} [{unit}] with {filled}" for (kind, unit), filled in kinds.items())
        raise refuse(f"{VARY} {path}", told, "one type and unit of measurement in all units", "Sweep them one by one.")
    variable = found[0]
    return replace(variable.variable.quantity, shape=()) if variable.index else variable.variable.quantity


def _variable(path: str, scenario: Scenario) -> UnitVariable:
    unit, _, name = path.partition(".")
    units = scenario.system.units
    if unit == "scene" and unit not in units:
        found = look_up(name, named(variables(Scene)))
        told = resolve(unit, variables(Scene), settings=[Setting(unit, f"{name}=0")]).problems
    elif unit in units:
        source = units[unit]
        found = look_up(name, settable(source))
        told = [] if found else resolve_unit(unit, source, settings=[Setting(unit, f"{name}=0")]).problems
    else:
        valid = ", ".join([*units, "scene", *(f"the socket {name}" for name in SOCKETS)])
        raise refuse(f"{VARY} {path}", f"the unknown unit `{unit}`", f"a parameter of {valid}")
    if found is None:
        raise_if_any(told)
        raise refuse(f"{VARY} {path}", "an unknown parameter", "one that `macrostep check` lists")
    return found


def iterate(plan: PlannedSweep, done: set[int]) -> Iterator[Variant]:
    """The variants that are not done yet, in their order."""
    return (plan.variant(number) for number in range(len(plan)) if number not in done)
