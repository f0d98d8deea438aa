"""The files that a cluster's workers need of a sweep: sent once to each worker, and found there at another place."""

from __future__ import annotations

import hashlib
import tempfile
import tomllib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final, cast

from fmus.toolchain.scratch import scratch_folder
from orchestrator.scenario.catalogue import built_folder
from orchestrator.sweeping.plan import PlannedSweep, Variant
from orchestrator.sweeping.sweep_request import absolute_file
from orchestrator.sweeping.work import SweepTask


@dataclass(frozen=True)
class SentFiles:
    """Files of the machine that asks, with their content."""

    digest: str
    content: Mapping[str, bytes]
    """By absolute path."""

    def task(self, task: SweepTask) -> SweepTask:
        """A task whose files are those of this machine."""
        options = task.options
        replacements = {socket: self._here(str(unit)) for socket, unit in options.replacements.items()}
        table = None if options.input is None else self._here(str(options.input))
        changed = replace(options, replacements=replacements, input=table)
        return replace(task, scenario=self._here(task.scenario), options=changed)

    def variants(self, variants: Sequence[Variant]) -> list[Variant]:
        """Variants whose units are files of this machine."""
        return [replace(v, fillings={s: self._here(unit) for s, unit in v.fillings.items()}) for v in variants]

    def _here(self, text: str) -> str:
        """Where a file is here, perhaps with the name of a model behind it; what is no file stays."""
        path, colon, model = text.partition(":")
        if not any(sent == path or sent.startswith(f"{path}/") for sent in self.content):
            return text
        return f"{_unpacked(self)}{path}{colon}{model}"


def needed_files(planned: PlannedSweep) -> list[str]:
    """The absolute paths of the files that a sweep needs; FMUs that are built here are built there too.

    Args:
        planned: The sweep.
    """
    request = planned.request
    asked = [request.scenario, *map(str, request.options.replacements.values()), str(request.options.input or "")]
    asked += [unit for v in planned.variations if v.is_filling for unit in v.choices]
    units = [source for scenario in planned.scenarios.values() for source in scenario.system.units.values()]
    asked += [str(file) for source in units if (file := source.describe().file) is not None]
    found: dict[str, None] = {}
    for text in asked:
        path = Path(absolute_file(text).partition(":")[0])
        if path.is_absolute() and not path.is_relative_to(built_folder()):
            found |= dict.fromkeys(map(str, _with_named(path)))
    return list(found)


def _with_named(path: Path) -> Iterator[Path]:
    """A file, the files of a folder, and those that a TOML file names."""
    if path.is_dir():
        yield from (file for file in path.iterdir() if file.suffix in {".ssp", ".json"})
    elif path.is_file():
        yield path.resolve()
        if path.suffix == ".toml":
            for text in _texts(tomllib.loads(path.read_text("utf-8"))):
                named = path.parent / text.partition(":")[0]
                if len(text) < _LONGEST and named.is_file():
                    yield from _with_named(named.resolve())


_LONGEST: Final = 1000
"""Characters; a longer text names no file."""


def _texts(content: Any) -> Iterator[str]:
    """All texts in the content of a TOML file."""
    if isinstance(content, str):
        yield content
    elif isinstance(content, dict | list):
        inside = cast("dict[str, Any] | list[Any]", content)
        items: Iterable[Any] = inside.values() if isinstance(inside, dict) else inside
        for item in items:
            yield from _texts(item)


_UNPACKED: Final[dict[str, tempfile.TemporaryDirectory[str]]] = {}
"""The folders of this process, which end with it, by the digest of the files."""


def _unpacked(files: SentFiles) -> str:
    """The folder of this process in which the files are at their paths."""
    if files.digest not in _UNPACKED:
        _UNPACKED[files.digest] = folder = scratch_folder("sweep")
        for path, content in files.content.items():
            there = Path(f"{folder.name}{path}")
            there.parent.mkdir(parents=True, exist_ok=True)
            there.write_bytes(content)
    return _UNPACKED[files.digest].name


def read_files(paths: Iterable[str]) -> SentFiles:
    """Read files, to be sent.

    Args:
        paths: Their absolute paths.
    """
    content = {path: Path(path).read_bytes() for path in paths}
    digest = hashlib.sha256()
    for path, data in sorted(content.items()):
        digest.update(f"{path}\n{len(data)}\n".encode() + data)
    return SentFiles(digest.hexdigest(), content)
