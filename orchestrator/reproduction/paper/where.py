"""Where a claim holds, in whole words: `against LQR and Stanley on linear tyres`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

Factors = Mapping[str, str]
"""What was compared in a case: the value of each factor, by its name."""
_Group = dict[str, tuple[str, ...]]
"""The cases whose factors have one of these values each; any value of a factor that is not named."""

_PHRASES: Final = {
    "setting": "with {}",
    "method": "for {}",
    "against": "against {}",
    "task": "in the task{s} {}",
    "tyre": "on {} tyres",
}
"""The words for a factor, by its name; `{s}` is the ending where there are several values."""


def groups(chosen: Sequence[Factors], others: Sequence[Factors]) -> list[_Group]:
    """What the chosen cases have in common and no other case has, in few groups.

    A case joins the first group that does not come to hold one of the others by that; then each group forgets the
    factors that it can do without.

    Args:
        chosen: The factors of the chosen cases.
        others: Those of the cases that have to stay outside.
    """
    found: list[_Group] = []
    for factors in chosen:
        own = {name: (value,) for name, value in factors.items()}
        joints = [_joined(group, own) for group in found]
        if (at := next((i for i, joint in enumerate(joints) if not _holds_any(joint, others)), None)) is None:
            found.append(own)
        else:
            found[at] = joints[at]
    return [_shortened(group, others) for group in found]


def in_words(found: Sequence[_Group]) -> str:
    """Groups as one phrase."""
    return ", and ".join(" ".join(_phrase(name, values) for name, values in group.items()) for group in found)


def counted(n: int) -> str:
    """A number of cases."""
    return f"{n} case{'' if n == 1 else 's'}"


def _joined(group: _Group, other: _Group) -> _Group:
    """The least group that holds both; what only one of them has a value for does not matter in it."""
    return {name: tuple(dict.fromkeys((*values, *other[name]))) for name, values in group.items() if name in other}


def _holds_any(group: _Group, cases: Sequence[Factors]) -> bool:
    return any(all(case.get(name) in values for name, values in group.items()) for case in cases)


def _shortened(group: _Group, others: Sequence[Factors]) -> _Group:
    for name in list(group):
        rest = {other: values for other, values in group.items() if other != name}
        if not _holds_any(rest, others):
            group = rest
    return group


def _phrase(name: str, values: Sequence[str]) -> str:
    *most, last = values
    text = f"{', '.join(most)} and {last}" if most else last
    return _PHRASES.get(name, f"for {name} {{}}").format(text, s="s" if most else "")
