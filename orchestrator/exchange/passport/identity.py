"""What an FMU says that it is, and what the file is."""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final, cast

from fmus.reading.archive import Archive
from fmus.reading.library import platforms

_CAPABILITIES: Final = {
    "canHandleVariableCommunicationStepSize": "variable communication step",
    "canGetAndSetFMUstate": "saves its state",
    "canSerializeFMUstate": "writes its state",
    "canInterpolateInputs": "interpolates inputs",
    "hasEventMode": "event mode",
    "mightReturnEarlyFromDoStep": "may return early",
    "providesDirectionalDerivative": "directional derivatives",
    "providesDirectionalDerivatives": "directional derivatives",
    "needsExecutionTool": "needs the tool that made it",
    "canBeInstantiatedOnlyOncePerProcess": "only one instance per process",
}
_MOST_LICENCES: Final = 10


def file_facts(path: Path) -> dict[str, Any]:
    """What the file is, whatever it contains."""
    content = path.read_bytes()
    return {"file": path.name, "size": len(content), "sha256": hashlib.sha256(content).hexdigest()}


def facts(archive: Archive) -> dict[str, Any]:
    """What the model description says; None or empty where it says nothing."""
    d, used = archive.description, archive.interface_type
    counts = Counter(str(v.causality or "local") for v in d.modelVariables)
    experiment = d.defaultExperiment
    return {
        "model": d.modelName,
        "description": d.description,
        "maker": d.author,
        "tool": d.generationTool,
        "generated": d.generationDateAndTime,
        "model_version": d.version,
        "copyright": d.copyright,
        "licence": d.license,
        "licence_files": sorted(n for n in archive.files if "licen" in n.lower())[:_MOST_LICENCES],
        "fmi_version": d.fmiVersion,
        "interface_types": [kind.in_words for kind in archive.interface_types],
        "measured_as": archive.chosen.in_words,
        "token": d.guid,
        "platforms": platforms(archive),
        "sources": any(name.startswith("sources/") for name in archive.files),
        "capabilities": [text for name, text in _CAPABILITIES.items() if getattr(used, name, False)],
        "variables": dict(sorted(counts.items())),
        "default_experiment": {
            name: _number(getattr(experiment, attribute, None))
            for name, attribute in (
                ("start_time", "startTime"),
                ("stop_time", "stopTime"),
                ("step", "stepSize"),
                ("tolerance", "tolerance"),
            )
        },
    }


def _number(text: Any) -> float | None:
    return None if text in (None, "") else float(text)


LABELS: Final[Mapping[str, str]] = {
    "file": "file",
    "model": "model",
    "description": "description",
    "maker": "maker",
    "tool": "made with",
    "generated": "made on",
    "model_version": "version",
    "copyright": "copyright",
    "licence": "licence",
    "licence_files": "licence files",
    "fmi_version": "FMI",
    "interface_types": "interfaces",
    "measured_as": "measured as",
    "platforms": "platforms",
    "sources": "sources inside",
    "capabilities": "capabilities",
    "variables": "variables",
    "default_experiment": "default experiment",
    "token": "token",
    "size": "size",
    "sha256": "SHA-256",
}
"""What each fact is called on the page, in its order there."""


def shown(content: Mapping[str, Any]) -> list[tuple[str, str]]:
    """The facts as rows of texts; what the file does not tell stands in the last of them."""
    rows = [(label, fact_text(key, content[key])) for key, label in LABELS.items() if key in content]
    untold = [label for label, text in rows if not text]
    return [row for row in rows if row[1]] + ([("not told", ", ".join(untold))] if untold else [])


def fact_text(key: str, value: Any) -> str:
    """A fact as text; empty where there is none."""
    if value is None or value in ("", [], {}):
        return ""
    if key == "size":
        return f"{value:,} bytes".replace(",", " ")
    if isinstance(value, bool):
        return "yes" if value else "no"
    if key == "default_experiment":
        seconds = {"step": " s", "stop_time": " s", "start_time": " s"}
        told = {name: item for name, item in value.items() if item is not None}
        return ", ".join(f"{n.replace('_', ' ')} {item:g}{seconds.get(n, '')}" for n, item in told.items())
    if key == "variables":
        return ", ".join(f"{item} {n}" for n, item in value.items())
    return ", ".join(map(str, cast(list[Any], value))) if isinstance(value, list) else str(value)
