"""The kinds of files that the product reads: what is damaged in each, and how it is read."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from random import Random
from typing import Any, Final, TypeAlias

from lxml import etree

from tests.fuzz import hostile, seeds
from tests.fuzz.damage import bytes_damaged, encoded, repeatedly, text_damaged
from tests.fuzz.hostile import pick
from tests.fuzz.parquets import parquet_damaged
from tests.fuzz.seeds import Files
from tests.fuzz.trees import json_damaged, toml_damaged, xml_damaged
from tests.fuzz.zips import packed, zip_damaged

Damage: TypeAlias = Callable[[bytes, Random, Sequence[bytes]], bytes]
"""Damages the content of a file; further contents of the same kind are given."""


@dataclass(frozen=True)
class Kind:
    """A kind of file."""

    name: str
    seeds: Callable[[], list[Files]]
    """Makes files that are in order."""
    damages: Sequence[tuple[str, Damage]]
    """What is damaged: regular expressions of paths, each with the way in which."""
    read: Callable[[Path], object]
    """Reads what is in a folder; raises `RequestError`, or returns problems, where it is refused in words."""

    def damaged(self, random: Random, sound: Sequence[Files]) -> Files:
        """One of the sound sets of files with a file that is damaged."""
        files = dict(pick(random, sound))
        places = [(path, way) for path in sorted(files) for pattern, way in self.damages if re.fullmatch(pattern, path)]
        path, way = pick(random, places)
        others = [one[p] for one in sound for p in sorted(one) if Path(p).suffix == Path(path).suffix]
        files[path] = way(files[path], random, others)
        return files


@dataclass(frozen=True)
class _ArchiveKind(Kind):
    """Archives themselves."""

    def damaged(self, random: Random, sound: Sequence[Files]) -> Files:
        """An archive of one of the sound sets of files, damaged."""
        files = pick(random, sound)
        name = next(iter(files)).partition("/")[0]
        return {name: zip_damaged({path.partition("/")[2]: content for path, content in files.items()}, random)}


def write(files: Files, folder: Path) -> None:
    """Write files into a folder; those below `NAME.fmu/` and `NAME.ssp/` become archives."""
    archives: dict[str, dict[str, bytes]] = {}
    for name, content in files.items():
        parts = re.fullmatch(r"(.*?\.(?:fmu|ssp))/(.*)", name)
        if parts:
            archives.setdefault(parts[1], {})[parts[2]] = content
        else:
            path = folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
    for name, inside in archives.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(packed(inside))


def _in_text(damage: Callable[..., str]) -> Damage:
    return lambda content, random, others: encoded(
        damage(content.decode(), random, [other.decode() for other in others]), random
    )


def _annotation_damaged(content: bytes, random: Random, _others: Sequence[bytes]) -> bytes:
    """A description whose annotation of ours was changed."""
    root = etree.fromstring(content)
    node = next(element for element in root.iter() if str(element.tag).endswith("}Scenario"))
    changed = json_damaged((node.text or "{}").encode(), random, [b"{}"]).decode("utf-8", "replace")
    node.text = "placeholder"
    escaped = changed.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
    return encoded(etree.tostring(root, encoding="unicode").replace("placeholder", escaped), random)


def _options_made(_content: bytes, random: Random, _others: Sequence[bytes]) -> bytes:
    """Options as nobody should type them."""
    chosen: dict[str, Any] = {}
    names = ("n", "i", "b", "t", "d", "e", "u", "v", "v[1,1]", "q", "x", "c", "f", hostile.text(random))
    values = (
        hostile.text(random),
        f"[{hostile.text(random)}]",
        f"{hostile.text(random)} [{hostile.text(random)}]",
        "[[1,2],[3,4]]",
    )

    def once() -> None:
        kind = random.randrange(8)
        value = pick(random, values)
        if kind <= 2:
            unit = pick(random, ("fmu", "fmu", "fmu", hostile.text(random)))
            chosen.setdefault("settings", []).append(f"{unit}.{pick(random, names)}={value}")
        elif kind == 3:
            pattern = pick(random, ("fmu.*", "*", "fmu.y", "fmu.v[*", hostile.text(random)))
            chosen.setdefault("record", []).append(f"{pattern}:{pick(random, (*hostile.NUMBERS, '10'))}")
        elif kind == 4:
            chosen[pick(random, ("step", "stop_time", "start_time", "tolerance"))] = pick(random, hostile.NUMBERS)
        elif kind == 5:
            chosen.setdefault("isolate", []).append(pick(random, (f"fmu:{pick(random, hostile.NUMBERS)}", value)))
        elif kind == 6:
            chosen.setdefault(pick(random, ("interface", "allow_nonfinite", "settings")), []).append(value)
        else:
            chosen[pick(random, ("algorithm", "input"))] = pick(random, (value, pick(random, hostile.PATHS)))

    repeatedly(random, once)
    return json.dumps(chosen).encode()


def _read_fmu(folder: Path) -> object:
    from orchestrator.exchange.check import check  # noqa: PLC0415

    checked = check(folder / "model.fmu", static=True)
    _loaded(folder / "model.fmu", lenient=bool(checked.problems), stop_time=1.0)
    return checked.problems


def _loaded(request: Path, **options: Any) -> None:
    from orchestrator.loading import load  # noqa: PLC0415
    from orchestrator.scenario.options import Options  # noqa: PLC0415
    from orchestrator.stepping.master import Simulation  # noqa: PLC0415

    scenario = load(str(request), Options(**{"mode": "blocks"} if request.suffix == ".toml" else {}, **options))
    assert all(isinstance(remark, str) for remark in scenario.remarks)
    assert scenario.grid.last_tick >= 0
    Simulation(scenario.system, h=scenario.h, until=scenario.until, start=scenario.start, record=scenario.record)


def _read_sources(folder: Path) -> object:
    from fmus.reading.opening import open_fmu  # noqa: PLC0415
    from fmus.reading.recompile import declared_sources  # noqa: PLC0415

    declared_sources(open_fmu(folder / "model.fmu"))
    return ()


def _read_ssp(folder: Path) -> object:
    from components.interfaces.problem import RequestError  # noqa: PLC0415
    from orchestrator.exchange.check import check  # noqa: PLC0415

    try:
        _loaded(folder / "system.ssp")
    except RequestError as error:
        _loaded(folder / "system.ssp", lenient=True)
        return error.problems
    return check(folder / "system.ssp").problems


def _read_archive(folder: Path) -> object:
    return _read_fmu(folder) if (folder / "model.fmu").is_file() else _read_ssp(folder)


def _read_modelica(folder: Path) -> object:
    from fmus.modelica.block import modelica_block  # noqa: PLC0415

    return modelica_block(folder / "Car.mo") and ()


def _read_scenario(folder: Path) -> object:
    return _loaded(folder / "scenario.toml")


def _read_mapping(folder: Path) -> object:
    from orchestrator.exchange.check import check  # noqa: PLC0415
    from orchestrator.loading import load  # noqa: PLC0415
    from orchestrator.scenario.options import Options  # noqa: PLC0415

    problems = check(folder / "theirs.toml", static=True).problems
    load("static", Options(mode="blocks", replacements={"plant": str(folder / "theirs.toml")}))
    return problems


def _read_values(folder: Path) -> object:
    return _loaded(folder / "vectors.fmu", settings=[f"@{folder / 'values.txt'}"], stop_time=1.0)


def _read_options(folder: Path) -> object:
    given = json.loads((folder / "options.json").read_text("utf-8"))
    for name in given.keys() & {"step", "stop_time", "start_time", "tolerance"}:
        try:
            given[name] = float(given[name])
        except ValueError:
            return ["the command refuses it"]
    return _loaded(folder / "model.fmu", **given)


def _read_table(folder: Path) -> object:
    table = next(path for path in folder.iterdir() if path.stem == "table")
    return _loaded(folder / "model.fmu", input=str(table))


def _read_run(folder: Path) -> object:
    """As `show` does it for one run and for two, and as `run` does it; what each refuses in words is refused."""
    from components.interfaces.problem import RequestError  # noqa: PLC0415
    from orchestrator.viewing import viewer  # noqa: PLC0415

    problems: list[object] = []
    said: list[str] = []

    def attempt(action: Callable[[], object]) -> None:
        try:
            action()
        except RequestError as error:
            problems.extend(error.problems)

    def opened(*names: str) -> None:
        scratch = folder / "-".join(("scratch", *names))
        scratch.mkdir()
        viewer.recording(viewer._found([folder / name for name in names], []), [], scratch, said.append)

    attempt(lambda: opened("run"))
    attempt(lambda: opened("other", "run"))
    attempt(lambda: _loaded(folder / "run"))
    return problems or said


def _read_summary(folder: Path) -> object:
    """What `show` makes of a summary beside that of a run in order."""
    from orchestrator.pictures import pages  # noqa: PLC0415
    from orchestrator.results.run_folder import KeptRun, find  # noqa: PLC0415
    from orchestrator.viewing import repair  # noqa: PLC0415

    said: list[str] = []
    runs = [run for name in ("other", "run") if isinstance(run := find(folder / name), KeptRun)]
    pages.comparison(["other", "run"], [run.summary for run in runs], [_scenario(runs[0])] * 2)
    repair.tell_of_summary(runs[1], said.append)
    return said


@cache
def _sound_scenario() -> list[Any]:
    return []


def _scenario(run: Any) -> Any:
    """The scenario of a run in order, which is read once: the summaries are what is damaged."""
    if not _sound_scenario():
        _sound_scenario().append(run.scenario)
    return _sound_scenario()[0]


def _read_recording(folder: Path) -> object:
    from orchestrator.recording.kept_series import kept_series  # noqa: PLC0415
    from orchestrator.viewing import repair, viewer  # noqa: PLC0415

    (folder / "scratch").mkdir()
    (run,) = viewer._found([folder / "alone.rrd"], [])
    kept_series(repair.whole_recording(run, folder / "scratch", lambda _: None), "recording", "one")
    return ()


def _read_passport(folder: Path) -> object:
    from orchestrator.exchange.passport.passport_comparison import compared_with, read_passport  # noqa: PLC0415

    compared_with(
        read_passport(folder / "other.passport.json"), json.loads(seeds.passports()[0]["other.passport.json"])
    )
    return ()


_DESCRIPTION: Final = (("model.fmu/modelDescription.xml", xml_damaged),)
_FMU: Final = "model.fmu/"
_SSP: Final = "system.ssp/"
_WHOLE: Final = (("", lambda content, *_: content),)
KINDS: Final = {
    kind.name: kind
    for kind in (
        Kind("fmi1", seeds.fmi1, _DESCRIPTION, _read_fmu),
        Kind("fmi2", seeds.fmi2, _DESCRIPTION, _read_fmu),
        Kind("fmi3", seeds.fmi3, _DESCRIPTION, _read_fmu),
        Kind(
            "terminals", seeds.fmi3, ((f"{_FMU}(?:terminalsAndIcons/.*|modelDescription).xml", xml_damaged),), _read_fmu
        ),
        Kind("build_description", seeds.builds, ((f"{_FMU}sources/.*xml", xml_damaged),), _read_sources),
        Kind("ssd", seeds.systems, ((f"{_SSP}.*ssd", xml_damaged),), _read_ssp),
        Kind("ssv_ssm_ssb", seeds.systems, ((rf"{_SSP}.*\.ss[vmb]", xml_damaged),), _read_ssp),
        Kind("annotation", seeds.own_systems, ((f"{_SSP}.*ssd", _annotation_damaged),), _read_ssp),
        _ArchiveKind("archive", seeds.archives, _WHOLE, _read_archive),
        Kind("modelica", seeds.modelica, (("Car.mo", _in_text(text_damaged)),), _read_modelica),
        Kind("scenario", seeds.scenarios, ((".*toml", toml_damaged),), _read_scenario),
        Kind("mapping", seeds.mappings, ((".*toml", toml_damaged),), _read_mapping),
        Kind("values", seeds.values, ((".*txt", _in_text(text_damaged)),), _read_values),
        Kind("options", seeds.options, ((".*json", _options_made),), _read_options),
        Kind("csv", seeds.tables, ((".*csv", _in_text(text_damaged)),), _read_table),
        Kind("parquet", seeds.parquet_tables, ((".*parquet", parquet_damaged),), _read_table),
        Kind("summary", seeds.runs, (("run/summary.json", json_damaged),), _read_summary),
        Kind(
            "run_folder",
            seeds.runs,
            (
                (r"run/.*\.(?:rrd|ssp)", bytes_damaged),
                (r"run/.*\.parquet", parquet_damaged),
                ("run/.*json", json_damaged),
            ),
            _read_run,
        ),
        Kind("rrd", seeds.recordings, ((".*rrd", bytes_damaged),), _read_recording),
        Kind("passport", seeds.passports, ((".*json", json_damaged),), _read_passport),
    )
}


def named(names: Iterable[str]) -> list[Kind]:
    """The kinds of names; all of them if none is named. Raises `KeyError`."""
    return [KINDS[name] for name in names] or [*KINDS.values()]
