"""Files and functions stay short enough to read; what is longer stands here with its reason."""

from __future__ import annotations

import ast
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SOURCES = sorted(p for package in ("components", "fmus", "orchestrator") for p in (ROOT / package).rglob("*.py"))
RUNTIME = sorted((ROOT / "fmus" / "runtime").glob("*.[ch]"))
LONGEST_FILE, LONGEST_FUNCTION = 300, 40

LONGER_FILES: dict[str, str] = {
    "orchestrator/stepping/master.py": "one class that people step by hand, most of it what they read of each method"
}
LONGER_FUNCTIONS: dict[str, str] = {}


def functions() -> dict[str, int]:
    """Lines of every function, from its name to its last statement; the docstring is free."""
    found: dict[str, int] = {}
    for source in SOURCES:
        for node in ast.walk(ast.parse(source.read_text(encoding="utf-8"))):
            if isinstance(node, ast.FunctionDef):
                first = node.body[0]
                described = ast.get_docstring(node) is not None
                free = (first.end_lineno or 0) - first.lineno + 1 if described else 0
                key = f"{source.relative_to(ROOT).as_posix()}:{node.name}"
                found[key] = (node.end_lineno or 0) - node.lineno + 1 - free
    return found


def test_no_file_is_too_long_without_a_reason():
    lines = {p.relative_to(ROOT).as_posix(): p.read_text("utf-8").count("\n") for p in [*SOURCES, *RUNTIME]}
    long = {name: n for name, n in lines.items() if n > LONGEST_FILE}
    assert {n: k for n, k in long.items() if n not in LONGER_FILES} == {}
    assert set(LONGER_FILES) <= set(lines), "a reason for a file that is gone"


def test_no_function_is_too_long_without_a_reason():
    lines = functions()
    long = {name: n for name, n in lines.items() if n > LONGEST_FUNCTION}
    assert {n: k for n, k in long.items() if n not in LONGER_FUNCTIONS} == {}
    assert set(LONGER_FUNCTIONS) <= set(lines), "a reason for a function that is gone"
