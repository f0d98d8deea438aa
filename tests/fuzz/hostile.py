"""What is put into files in the place of values: texts, numbers, names and paths that readers may stumble over."""

from __future__ import annotations

from collections.abc import Sequence
from random import Random
from typing import Any, Final, TypeVar

_Item = TypeVar("_Item")

NUMBERS: Final = (
    *("0", "-0", "1", "-1", "2", "1e999", "-1e999", "1e-999", "nan", "NaN", "inf", "INF", "-INF", "Infinity", "1+0"),
    *("²", "½", "٣", "1_0", "0x10", "1e", "1.", ".5", "+1", " 1 ", "1,0", "1;2", "1 2 3", "--1", "1e5", "1e-5"),
    *("2147483647", "2147483648", "-2147483649", "4294967295", "4294967296", "9223372036854775807"),
    *("9223372036854775808", "18446744073709551615", "18446744073709551616", "1e308", "1e309", "5e-324", "0.1"),
    *("9" * 400, "9" * 5000, "-" + "9" * 5000, "0." + "0" * 5000 + "1", "1e" + "9" * 30, "1/0", "0/0", "3/7"),
)
TEXTS: Final = (
    *("", " ", "\t", "\n", "a", "true", "false", "null", "None", "yes", "[]", "{}", "[", "]", "{", "'", '"', "\\"),
    *("a.b", ".", "..", "a..b", "a[0]", "a[1]", "a[-1]", "a[2e9]", "a[²]", "a[1,]", "a[1][1]", "a[99999999999]", "[1]"),
    *("%s%n", "{0}", "$(id)", "`id`", "\x1b[31m", "[red]", "[/]", "ä", "ﬁ", "\u202e", "\U0001f600", "\ufeff", "\ufffe"),
    *("\x00", "\x01", "\x7f", "\x85", "\u2028", "\ud800", "\udcff", "a" * 1000, "a" * 70000, "é" * 300, "=", "a=b"),
    *(
        "#",
        ";",
        ",",
        ":",
        "&",
        "<",
        "&amp;",
        "&#0;",
        "&x;",
        "]]>",
        "<!--",
        "<?a?>",
        "m/s",
        "km/h",
        "m/",
        "m//s",
        "(" * 99,
    ),
    *(
        "m^2",
        "m**99",
        "m2e9",
        "t9999999",
        "1e400 m",
        "degC",
        "K",
        "%",
        "°",
        "\u00b5",
        "CoSimulation",
        "1.0",
        "2.0",
        "3.0",
    ),
    *(
        "2007-13-45T99:99:99Z",
        "0000-00-00",
        "-1-01-01T00:00:00Z",
        "1979-05-27T07:32:00+99:99",
        "time",
        "input",
        "output",
    ),
)
PATHS: Final = (
    *(
        "../../x",
        "/etc/passwd",
        "/dev/zero",
        "/dev/stdin",
        "/proc/self/mem",
        "C:\\x",
        "\\\\host\\x",
        "file:///etc/passwd",
    ),
    *(
        "http://[::1",
        "http://x/",
        "http://[x]/a",
        "//",
        "./.",
        "a/../..",
        "~",
        "a" * 300,
        "a/" * 900 + "a",
        "%00",
        "%ff",
    ),
    *(
        "resources",
        "resources/",
        "x.fmu",
        "x.ssp",
        "x.toml",
        "x.csv",
        "x.mo",
        "con",
        "a?b#c",
        "#a",
        "?",
        "a%2fb",
        "urn:x",
    ),
)
BYTES: Final = (
    *(
        b"",
        b"\x00",
        b"\xff",
        b"\x00" * 64,
        b"\xff" * 8,
        b"\xc3\x28",
        b"\xed\xa0\x80",
        b"\xfe\xff",
        b"\xef\xbb\xbf",
        b"PK",
    ),
    *(
        b"<",
        b">",
        b"&",
        b'"',
        b"'",
        b"\n",
        b"\r",
        b"[",
        b"]",
        b"{",
        b"}",
        b"=",
        b",",
        b";",
        b"\x1b[2J",
        b"\x7f\xff\xff\xff",
    ),
)
DEEP: Final = (10, 300, 2000, 100_000)
"""How deep what is nested is nested."""


def pick(random: Random, items: Sequence[_Item]) -> _Item:
    """One of the items."""
    return items[random.randrange(len(items))]


def text(random: Random) -> str:
    """A text that stands for a value."""
    return pick(random, pick(random, (NUMBERS, NUMBERS, TEXTS, TEXTS, PATHS)))


def scalar(random: Random) -> Any:
    """A value as JSON and TOML have them, which is no list and no table."""
    return pick(
        random,
        (
            None,
            random.random() < 0.5,
            *(0, -1, 1, 2**31, 2**63, 2**64, -(2**63) - 1, 10**400, 10**4000),
            *(0.0, -0.0, 0.1, 1e308, 5e-324, float("inf"), float("-inf"), float("nan")),
            *(text(random), text(random), text(random), text(random), text(random)),
        ),
    )


def value(random: Random) -> Any:
    """A value as JSON and TOML have them."""
    kind = random.randrange(8)
    if kind == 0:
        return [scalar(random) for _ in range(random.randrange(4))]
    if kind == 1:
        return {
            pick(random, ("value", "unit", "a", "", "x.y", "source")): scalar(random)
            for _ in range(random.randrange(3))
        }
    if kind == 2:
        return [[scalar(random)], [scalar(random), scalar(random)]]
    return scalar(random)
