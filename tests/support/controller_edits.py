"""Single edits of a controller document, as somebody makes them in an editor, and all of them.

Each number times 1.5 and 0.5, each element of a list dropped or swapped with the next, each block's
gain times 10, vertices removed, bounds deleted. Titles and the provenance are left alone: nothing
is claimed of them.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

TITLES = ("format", "name", "provenance", "sign_convention")
# of each block the numbers that are its gain
GAINS: dict[str, tuple[str, ...]] = {
    "linear.discrete": ("c", "d"),
    "linear.continuous": ("c", "d"),
    "linear": ("anti_windup",),
    "position_law": ("gain",),
    "prefilter": ("natural_frequency_rad_s",),
    "velocity": ("bandwidth_rad_s",),
    "certificate.weights.error": ("gain",),
    "certificate.weights.noise": ("gain",),
}


@dataclass(frozen=True)
class Edit:
    """label: what was edited, for the report of a test. document: the edited one, of dictionaries
    and lists."""

    label: str
    document: dict[str, Any]

    @property
    def block(self) -> str:
        """The key at the top under which the edit is."""
        return self.label.partition(" ")[0].partition(".")[0].partition("[")[0]


def edits(document: dict[str, Any]) -> tuple[Edit, ...]:
    """Every edit that changes the document."""
    return tuple(edit for edit in _all(document) if edit.document != document)


def edits_of_keys(document: dict[str, Any]) -> Iterator[Edit]:
    """Yield the edits of numbers and lists of any document."""
    for name in document:
        if name not in TITLES:
            yield from _of(document, (name,))


def _all(document: dict[str, Any]) -> Iterator[Edit]:
    yield from edits_of_keys(document)
    for name, keys in GAINS.items():
        path = tuple(name.split("."))
        if _has(document, path):
            yield Edit(
                f"{name} gain x10",
                _changed(
                    document, path, lambda block, keys=keys: {**block, **_tenfold(block, keys)}
                ),
            )
    vertices = ("verified", "vertices")
    for kept in (0, 1, 8, 15):
        yield Edit(
            f"verified.vertices first {kept} kept",
            _changed(document, vertices, lambda block, kept=kept: block[:kept]),
        )
    bounds = ("certificate", "bounds")
    yield Edit("certificate.bounds deleted", _changed(document, bounds, lambda _: []))


def _of(document: dict[str, Any], path: tuple[Any, ...]) -> Iterator[Edit]:
    value, name = _at(document, path), _words(path)
    if isinstance(value, bool) or value is None:
        return
    if isinstance(value, (int, float)):
        for factor in (1.5, 0.5):
            if value:
                yield Edit(
                    f"{name} x{factor}",
                    _changed(document, path, lambda number, factor=factor: _scaled(number, factor)),
                )
    elif isinstance(value, dict):
        for key in value:
            yield from _of(document, (*path, key))
    elif isinstance(value, list):
        for index in range(len(value)):
            yield Edit(
                f"{name} without {index}",
                _changed(
                    document, path, lambda block, index=index: block[:index] + block[index + 1 :]
                ),
            )
            if index + 1 < len(value) and value[index] != value[index + 1]:
                yield Edit(
                    f"{name} {index} swapped",
                    _changed(document, path, lambda block, index=index: _swapped(block, index)),
                )
            yield from _of(document, (*path, index))


def _scaled(number: float, factor: float) -> float:
    """A whole number stays one, so that a count is read and then judged."""
    return (
        round(number * factor)
        if isinstance(number, int) and round(number * factor) != number
        else number * factor
    )


def _swapped(block: list[Any], index: int) -> list[Any]:
    return [*block[:index], block[index + 1], block[index], *block[index + 2 :]]


def _tenfold(block: dict[str, Any], keys: tuple[str, ...]) -> dict[str, Any]:
    return {key: _times(block[key], 10.0) for key in keys if key in block}


def _times(value: Any, factor: float) -> Any:
    return [_times(one, factor) for one in value] if isinstance(value, list) else value * factor


def _at(document: Any, path: tuple[Any, ...]) -> Any:
    for key in path:
        document = document[key]
    return document


def _has(document: Any, path: tuple[Any, ...]) -> bool:
    for key in path:
        if key not in document:
            return False
        document = document[key]
    return True


def _changed(
    document: dict[str, Any], path: tuple[Any, ...], change: Callable[[Any], Any]
) -> dict[str, Any]:
    found = copy.copy(document)
    if len(path) == 1:
        found[path[0]] = change(found[path[0]])
    else:
        found[path[0]] = _changed(found[path[0]], path[1:], change)
    return found


def _words(path: tuple[Any, ...]) -> str:
    return "".join(f"[{key}]" if isinstance(key, int) else f".{key}" for key in path).removeprefix(
        "."
    )
