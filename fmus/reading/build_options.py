"""The options with which a build description wants the sources of an FMU compiled: the harmless ones of them.

Options of a compiler can write files, run programs and load libraries. Those that only say how C is understood and
translated are used; all others are left out, and named.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

from fmus.toolchain.file_names import path_problem

_HARMLESS: Final = re.compile(
    r"-O[0-3sg]?|-Ofast|-g[0-3]?|-w|-ansi|-pedantic|-pthread"
    r"|-std=[a-z0-9+:]{1,16}"
    r"|-W(?![lap],)[a-z][a-z0-9+-]*(=[0-9]{1,4})?"
    r"|-m(32|64|arch=[\w.+-]{1,40}|tune=[\w.+-]{1,40}|sse[0-9.a-z]*|ssse3|avx[0-9a-z]*|fma|f16c|bmi2?|fpmath=[a-z0-9+,]+)"
    r"|-f(no-)?(strict-aliasing|wrapv|common|fast-math|math-errno|trapping-math|signed-zeros|finite-math-only"
    r"|unsafe-math-optimizations|associative-math|reciprocal-math|rounding-math|omit-frame-pointer|inline"
    r"|inline-(small-)?functions|unroll-loops|tree-vectorize|exceptions|rtti|openmp|signed-char|unsigned-char"
    r"|short-enums|ms-extensions|stack-protector|strict-overflow|gnu89-inline|builtin|asynchronous-unwind-tables"
    r"|unwind-tables|data-sections|function-sections|plt|semantic-interposition|pic|PIC|permissive|threadsafe-statics)"
    r"|-ffp-contract=(off|on|fast)|-fvisibility=(default|hidden|protected|internal)|-fexcess-precision=(fast|standard)"
)
_DEFINITION: Final = re.compile(r"-D([A-Za-z_]\w*(?:\([\w, .]*\))?)(?:=([^\x00-\x1f\x7f]*))?|-U[A-Za-z_]\w*")
_OF_SYSTEM: Final = re.compile(r"-l([A-Za-z0-9_][\w.+-]*)")
_LONGEST: Final = 10_000
"""The most characters of one option."""


@dataclass(frozen=True)
class BuildOptions:
    """The options that are used, and what is left out."""

    used: tuple[str, ...]
    left_out: tuple[str, ...]


def harmless(options: Iterable[str]) -> BuildOptions:
    """Those of some options for the compiler that can do no harm.

    Args:
        options: The options, each with its value in one text.
    """
    used: list[str] = []
    left_out: list[str] = []
    for option in options:
        (used if _is_harmless(option) else left_out).append(option)
    return BuildOptions(tuple(used), tuple(left_out))


def _is_harmless(option: str) -> bool:
    if len(option) > _LONGEST:
        return False
    if option.startswith("-I"):  # in the folder of the sources
        return option[2:] in {".", "./"} or not path_problem(option[2:])
    return any(pattern.fullmatch(option) for pattern in (_HARMLESS, _DEFINITION, _OF_SYSTEM))
