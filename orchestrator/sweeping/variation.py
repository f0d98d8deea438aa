"""What varies in a sweep: a parameter over a range, a list or a distribution, or what fills a socket."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from components.interfaces.maths import Array
from components.interfaces.problem import Problem, did_you_mean, raise_if_any, refuse
from components.interfaces.quantity import Quantity, Type
from components.interfaces.sockets import SOCKETS
from orchestrator.system.value_texts import behind, from_text, plain

MOST: Final = 10_000_000
"""The most variants of a sweep."""
VARY: Final = "--vary"
"""The option of the command, for messages."""
_FORMS: Final = "LOW:HIGH, log:LOW:HIGH, a list A,B,C, or a distribution of scipy.stats such as normal:10,0.5"
_NUMBER: Final = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
_ALIASES: Final = {"normal": "norm", "exponential": "expon"}
"""Names that people know, and those of scipy.stats."""

Quantile: TypeAlias = Callable[[Array], NDArray[Any]]
"""Numbers in [0, 1), `(n,)`, to values, `(n,)`."""


@dataclass(frozen=True)
class Variation:
    """One thing that varies."""

    path: str
    """The path of a parameter as `--set` takes it, or the name of a socket."""
    text: str
    """What was asked for, such as `1500:2500`."""
    choices: tuple[str, ...] = ()
    """The values one by one, as `--set` and the sockets' options take them; none where `quantile` gives them."""
    quantile: Quantile | None = None
    """The value below which a share of all values lies."""
    whole: tuple[int, int] | None = None
    """The least and the largest value, where all are whole numbers."""

    @property
    def is_filling(self) -> bool:
        """Whether it is a socket that is filled by one unit or another."""
        return self.path in SOCKETS

    def at(self, shares: Array) -> list[str]:
        """The values at some shares.

        Args:
            shares: Numbers in [0, 1), `(n,)`; values are as frequent as they are likely if these are uniform.
        """
        if self.quantile is None:
            return [self.choices[int(share * len(self.choices))] for share in shares]
        return [_text(value) for value in self.quantile(np.asarray(shares, dtype=float)).tolist()]

    def place(self, share: float) -> float:
        """The middle of the shares that have the same value as a share: two places are one if their values are."""
        if self.quantile is None:
            return (int(share * len(self.choices)) + 0.5) / len(self.choices)
        if self.whole is not None:
            low, high = self.whole
            return (int(self.at(np.array([share]))[0]) - low + 0.5) / (high - low + 1)
        return share

    def grid(self, count: int) -> list[str]:
        """Evenly spaced values: both ends of a range and those between them, the middles of shares of a distribution.

        Args:
            count: How many there are; a list is taken as it is, and so are fewer whole numbers.
        """
        if self.quantile is None:
            return list(self.choices)
        if self.whole is not None:
            low, high = self.whole
            return [
                str(i) for i in dict.fromkeys(np.linspace(low, high, min(count, high - low + 1)).round().astype(int))
            ]
        if ":" in self.text and _is_range(self.text):
            return [
                _text(x) for x in self.quantile(np.linspace(0, 1, count) if count > 1 else np.array([0.5])).tolist()
            ]
        return self.at((np.arange(count) + 0.5) / count)


def variation(path: str, text: str, quantity: Quantity | None) -> Variation:
    """Read what varies.

    Args:
        path: The path of a parameter, or the name of a socket.
        text: A range, a list or a distribution, perhaps with a unit of measurement: `1500:2500`, `30:50 [km/h]`.
        quantity: What the parameter is; None for a socket.

    Raises:
        RequestError: The text has another form, or does not fit the quantity.
    """
    where, text = f"{VARY} {path}={text}", text.strip()
    if not text:
        raise refuse(where, "nothing", _FORMS)
    head = text.partition(":")[0].strip()
    if quantity is None or ":" not in text:
        return _list(where, path, text, quantity)
    if _NUMBER.fullmatch(head) and not _is_range(text):
        raise refuse(where, "a range with an end that is no finite number", _FORMS)
    if quantity.shape or not (quantity.type.is_float or quantity.type.is_integer):
        valid = "a list A,B,C" if not quantity.shape else f"an element of it, such as {path}[1]"
        raise refuse(where, "a range" if _is_range(text) else "a distribution", valid)
    if _is_range(text):
        return _range(where, path, text, quantity)
    return _distribution(where, path, text, head, quantity)


def twice(variations: Sequence[tuple[str, str]]) -> Iterator[Problem]:
    """The problems of what varies more than once."""
    seen: set[str] = set()
    for path, text in variations:
        if path in seen:
            yield Problem(f"{VARY} {path}={text}", "a path that varies twice", "each path once")
        seen.add(path)


def spelled(values: object) -> str:
    """Values as they are typed: a text as it is, a list with commas between its items."""
    if isinstance(values, str):
        return values
    values = plain(values)
    items: list[object] = list(values) if isinstance(values, tuple | list) else [values]  # type: ignore[unknown]
    return ",".join(str(item).lower() if isinstance(item, bool) else str(item) for item in items)


def split(text: str) -> tuple[str, str]:
    """The path and the values of `PATH=VALUES`. Raises `RequestError` where a text has another form."""
    path, sign, values = text.partition("=")
    if not sign or not path.strip():
        remedy = "Try plant.m=1500:2500, controller.b_3=log:1e-3:1e-1 or plant=bicycle,MyVehicle.fmu."
        raise refuse(f"{VARY} {text}", "text of another form", "PATH=VALUES", remedy)
    return path.strip(), values


def _is_range(text: str) -> bool:
    parts = _bare(text).removeprefix("log:").split(":")
    return all(_NUMBER.fullmatch(part.strip()) for part in parts)


def _bare(text: str) -> str:
    """A text without the unit of measurement behind it."""
    parts = behind(text)
    return text if parts is None else parts[0]


def _list(where: str, path: str, text: str, quantity: Quantity | None) -> Variation:
    bare, parts = _bare(text), behind(text)
    unit = f" [{parts[1]}]" if parts is not None and quantity is not None else ""
    items = re.split(r",(?![^\[]*\])", bare if unit else text)  # an array's own commas are in brackets
    values = tuple(f"{item.strip()}{unit}" for item in items if item.strip())
    read = values if quantity is None else [str(from_text(value, quantity)) for value in values]
    same = [_same(value) for value in read]
    if len(set(same)) < len(same):
        raise refuse(where, "a value twice", "a list of different values")
    if not values:
        raise refuse(where, "an empty list", _FORMS)
    return Variation(path, text, values)


def _same(value: str) -> float | str:
    """A key that is the same for the same number, however it is written."""
    return float(value) if _NUMBER.fullmatch(value) else value


def _range(where: str, path: str, text: str, quantity: Quantity) -> Variation:
    ends = _bare(text).removeprefix("log:").split(":")
    unit = text.removeprefix(_bare(text))
    is_log = text.startswith("log:")
    if len(ends) != 2:  # noqa: PLR2004 - a range has two ends
        raise refuse(where, f"a range with {len(ends)} numbers", _FORMS)
    low, high = (from_text(f"{end.strip()}{unit}", quantity) for end in ends)
    raise_if_any(quantity.problems(where, low) or quantity.problems(where, high))
    if not low < high:
        raise refuse(where, f"a range from {low} to {high}", "a range whose first number is the smaller one")
    if is_log and low <= 0:
        raise refuse(where, f"a logarithmic range from {low}", "one from a number above 0")
    if quantity.type.is_integer:
        return Variation(path, text, quantile=_whole(int(low), int(high), is_log=is_log), whole=(int(low), int(high)))
    if is_log:
        return Variation(path, text, quantile=lambda u: np.clip(low * (high / low) ** u, low, high))
    return Variation(path, text, quantile=lambda u: np.clip(low + (high - low) * u, low, high))


def _whole(low: int, high: int, *, is_log: bool) -> Quantile:
    """All whole numbers from `low` to `high`, each as likely as the others, or less likely the larger they are."""
    if is_log:
        first, last = low - 0.5, high + 0.5
        return lambda u: np.clip(np.rint(first * (last / first) ** u), low, high).astype(np.int64)
    return lambda u: np.minimum(low + np.floor(u * (high - low + 1)), high).astype(np.int64)


def _distribution(where: str, path: str, text: str, head: str, quantity: Quantity) -> Variation:
    from scipy import stats  # noqa: PLC0415 - slow to import, and only distributions need it

    known = {name: d for name, d in vars(stats).items() if isinstance(d, stats.rv_continuous | stats.rv_discrete)}
    name = _ALIASES.get(head, head)
    if name not in known:
        raise refuse(where, f"the unknown distribution `{head}`", _FORMS, did_you_mean(head, [*known, *_ALIASES]))
    bare = _bare(text)
    unit = text.removeprefix(bare)
    try:
        numbers = [float(part) for part in bare.partition(":")[2].split(",") if part.strip()]
        if not numbers:
            raise ValueError("it has none")  # noqa: TRY301 - told as what SciPy tells
        frozen: Any = known[name](*numbers)
        is_sound = bool(np.isfinite(frozen.ppf(0.5)))
    except (ValueError, TypeError) as error:
        raise refuse(where, f"parameters that `{name}` does not take ({error})", _FORMS) from None
    if not is_sound:
        raise refuse(
            where, f"parameters that `{name}` does not take", f"those of scipy.stats.{name}: shapes, loc, scale"
        )

    def quantile(shares: Array) -> NDArray[Any]:
        values = np.asarray(frozen.ppf(np.clip(shares, 1e-12, 1 - 1e-12)), dtype=float)
        if unit:
            values = np.array([from_text(f"{value!r}{unit}", quantity) for value in values.tolist()], dtype=float)
        return np.rint(values).astype(np.int64) if quantity.type.is_integer else values

    return Variation(path, text, quantile=quantile)


def value_problems(
    variation: Variation, values: Sequence[str], quantity: Quantity | None, rows: str = ""
) -> list[Problem]:
    """The problems of the values that are to be run, of which for numbers the extremes are looked at.

    Args:
        variation: What varies.
        values: Its values.
        quantity: What the parameter is; None for a socket.
        rows: Where the values stand, if each has a place of its own: the number of the row follows.
    """
    if quantity is None:
        return []
    places = dict.fromkeys(values, f"{VARY} {variation.path}={variation.text}")
    if rows:
        places = {text: f"{rows}{i}, {variation.path}" for i, text in reversed([*enumerate(values, 1)])}
    elif not variation.choices:
        numbers = {from_text(text, quantity): text for text in values}
        places = {numbers[end]: places[numbers[end]] for end in {min(numbers), max(numbers)}} if numbers else {}
    return [problem for text, where in places.items() for problem in _problems(where, text, quantity)]


def _problems(where: str, text: str, quantity: Quantity) -> list[Problem]:
    value: Any = from_text(text, quantity)
    if quantity.shape and (given := np.shape(value)):  # a shorter list leaves the other elements as they are
        quantity = replace(quantity, shape=given[: len(quantity.shape)])
    return quantity.problems(where, value)


def typed(values: Sequence[str], quantity: Quantity | None) -> list[Any]:
    """Values as they stand in the tables of a sweep: numbers, truth values, names."""
    if quantity is None or quantity.enumeration is not None or quantity.shape or quantity.type is Type.BINARY:
        return list(values)
    read: Mapping[str, Any] = {text: from_text(text, quantity) for text in dict.fromkeys(values)}
    kind: Callable[[Any], Any] = float if quantity.type.is_float else lambda value: value
    return [kind(read[text]) for text in values]


def _text(value: float) -> str:
    """A number as `--set` takes it, from which the same number is read."""
    return repr(value)
