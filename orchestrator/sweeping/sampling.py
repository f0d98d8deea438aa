"""How the variants of a sweep are sampled: a grid, random numbers, a Latin hypercube, Sobol's sequence, or a table."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any, Final, TypeAlias

import numpy as np

from components.interfaces.maths import Array
from components.interfaces.problem import did_you_mean, refuse
from orchestrator.sweeping.variation import MOST, Variation
from orchestrator.system.value_texts import behind

SAMPLES_OPTION: Final = "--samples"
GRID_OPTION: Final = "--grid"
VARIANT: Final = "variant"
"""The column of the tables of a sweep that has the number of the variant."""
TABLES: Final = (".csv", ".parquet")
"""The endings of tables."""
SEARCH: Final = "search"
"""The kind of sampling that looks for failures."""

Columns: TypeAlias = dict[str, list[str]]
"""The value of each path in each variant, as `--set` takes it."""


@dataclass(frozen=True)
class Sampling:
    """How variants are sampled."""

    kind: str
    """`grid`, `table`, `SEARCH`, or one of `SAMPLINGS`."""
    count: int = 0
    """The number that was asked for."""
    counts: tuple[int, ...] = ()
    """For a grid: the number of values of each variation, or one number for all."""
    table: Path | None = None
    """For a table: the file."""

    def __str__(self) -> str:
        if self.kind == SEARCH:
            return "a search"
        if self.kind == "grid":
            return f"{GRID_OPTION} {','.join(map(str, self.counts))}" if self.counts else "every combination"
        return (
            f"{SAMPLES_OPTION} {self.table}" if self.table is not None else f"{SAMPLES_OPTION} {self.kind}:{self.count}"
        )


def _random(count: int, dimensions: int, generator: np.random.Generator) -> Array:
    return generator.random((count, dimensions))


def _lhs(count: int, dimensions: int, generator: np.random.Generator) -> Array:
    from scipy.stats import qmc  # noqa: PLC0415 - slow to import, and a grid has no need of it

    return qmc.LatinHypercube(dimensions, rng=generator).random(count)


def _sobol(count: int, dimensions: int, generator: np.random.Generator) -> Array:
    from scipy.stats import qmc  # noqa: PLC0415

    return qmc.Sobol(dimensions, rng=generator).random_base2(math.ceil(math.log2(count)) if count > 1 else 0)[:count]


def _saltelli(count: int, dimensions: int, generator: np.random.Generator) -> Array:
    """Saltelli's scheme, from which Sobol indices follow: two matrices A and B, and A with each column of B."""
    both = _sobol(count, 2 * dimensions, generator)
    a, b = both[:, :dimensions], both[:, dimensions:]
    mixed = [np.where(np.arange(dimensions) == j, b, a) for j in range(dimensions)]
    return np.concatenate([a, b, *mixed])


SAMPLINGS: Final[Mapping[str, Callable[[int, int, np.random.Generator], Array]]] = {
    "random": _random,
    "lhs": _lhs,
    "sobol": _sobol,
    "saltelli": _saltelli,
}
"""Shares for each variant and variation, by the name of the kind; `saltelli:N` makes N (d + 2) variants."""
_VALID: Final = f"KIND:NUMBER ({', '.join(SAMPLINGS)}), or a table FILE.csv"


def read_sampling(samples: str | None, grid: str | None, variations: Sequence[Variation]) -> Sampling:
    """Read how variants are sampled.

    Args:
        samples: The value of `--samples`: `sobol:512`, `lhs:100`, `random:100`, `saltelli:64`, or the name of a table.
        grid: The value of `--grid`: the number of values of each variation, `20` or `20,5`.
        variations: What varies.

    Raises:
        RequestError: Both are given, or one has another form, or neither is given where something is no list.
    """
    if samples is not None and grid is not None:
        raise refuse(f"{SAMPLES_OPTION}, {GRID_OPTION}", "both", "one of them")
    if grid is not None:
        return _grid(grid, variations)
    if samples is None:
        ranges = [f"{v.path}={v.text}" for v in variations if not v.choices]
        if ranges:
            remedy = f"Try {SAMPLES_OPTION} sobol:64, or {GRID_OPTION} 10."
            raise refuse(SAMPLES_OPTION, f"nothing that says how {ranges[0]} is sampled", _VALID, remedy)
        return Sampling("grid")
    if samples.endswith(TABLES):
        return Sampling("table", table=Path(samples))
    kind, _, number = samples.partition(":")
    if kind not in SAMPLINGS:
        raise refuse(f"{SAMPLES_OPTION} {samples}", f"the unknown kind `{kind}`", _VALID, did_you_mean(kind, SAMPLINGS))
    if not re.fullmatch(r"[0-9]{1,9}", number) or int(number) < 1:
        raise refuse(f"{SAMPLES_OPTION} {samples}", f"`{number}` variants", _VALID)
    sampling = Sampling(kind, int(number))
    _check_count(str(sampling), int(number) * (len(variations) + 2 if kind == "saltelli" else 1))
    return sampling


def _grid(text: str, variations: Sequence[Variation]) -> Sampling:
    parts = text.split(",")
    if not all(re.fullmatch(r"\s*[0-9]{1,9}\s*", part) and int(part) > 0 for part in parts):
        raise refuse(f"{GRID_OPTION} {text}", "text of another form", "a whole number, or one for each variation: 20,5")
    if len(parts) not in (1, len(variations)):
        found = f"{len(parts)} numbers for {len(variations)} variations"
        raise refuse(f"{GRID_OPTION} {text}", found, "one number, or one for each variation")
    counts = tuple(map(int, parts))
    each = counts * len(variations) if len(counts) == 1 else counts
    sizes = [len(v.choices) or n for v, n in zip(variations, each, strict=True)]
    _check_count(f"{GRID_OPTION} {text}", math.prod(sizes))
    return Sampling("grid", counts=counts)


def _check_count(where: str, count: int) -> None:
    if count > MOST:
        raise refuse(where, f"{count} variants", f"{MOST} of them at most")


def sampled(sampling: Sampling, variations: Sequence[Variation], seed: int) -> Columns:
    """The values of all variants.

    Args:
        sampling: How they are sampled.
        variations: What varies; for a table it says nothing of the values, which the table has.
        seed: The seed of the random numbers; the same one gives the same values.

    Raises:
        RequestError: The table cannot be read, or has other columns.
    """
    if sampling.table is not None:
        return read_table(sampling.table)
    if sampling.kind == "grid":
        counts = sampling.counts or (1,)
        each = counts * len(variations) if len(counts) == 1 else counts
        rows = [*product(*(v.grid(n) for v, n in zip(variations, each, strict=True)))]
        return {v.path: [row[i] for row in rows] for i, v in enumerate(variations)}
    shares = SAMPLINGS[sampling.kind](sampling.count, len(variations), np.random.default_rng(seed))
    return {v.path: v.at(shares[:, i]) for i, v in enumerate(variations)}


def read_table(path: Path) -> Columns:
    """The variants of a table: a column for each path, a row for each variant.

    Raises:
        RequestError: The file cannot be read, or is no table of this kind.
    """
    import pandas as pd  # noqa: PLC0415 - slow to import, and only a table needs it

    where = f"{SAMPLES_OPTION} {path}"
    try:
        if path.suffix == ".parquet":
            frame = pd.read_parquet(path)
        else:
            frame = pd.read_csv(path, dtype=str, keep_default_na=False, skipinitialspace=True)
    except FileNotFoundError:
        raise refuse(where, "no such file", "a table with a column for each path") from None
    except (OSError, ValueError, UnicodeError) as error:
        reason = str(error).strip().splitlines()[0]
        raise refuse(where, f"a file that cannot be read ({reason})", "a table with a column for each path") from None
    columns: Columns = {}
    for heading in frame.columns:
        name, unit = behind(str(heading).strip()) or (str(heading).strip(), "")
        if name in columns:
            raise refuse(where, f"the column {name} twice", "each path once")
        values = [_cell(value) for value in frame[heading].tolist()]
        if "" in values:
            row = values.index("") + 1
            raise refuse(f"{where}, row {row}, {name}", "an empty cell", "a value in each cell")
        if name != VARIANT:
            columns[name] = [f"{value} [{unit}]" for value in values] if unit else values
    if not columns or not len(frame):
        raise refuse(where, "a table without values", "a column for each path, and a row for each variant")
    return columns


def _cell(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return value.strip() if isinstance(value, str) else repr(value)
