"""Propagation of the intervals of a mechanism's quantities to the numbers of the reduced model.

One quantity after another is set to the ends of its interval, and the mechanism is reduced again.
For each number of the model, the resulting changes are added. This is exact if the number is a sum
of quantities. If it contains products, the joint effect of several changes is neglected. With at
most MOST_CORNERS quantities, the mechanism is therefore also reduced for every combination of
interval ends. The Coulomb friction and the breakaway of an element are changed together, because
the Coulomb friction must not exceed the breakaway.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from typing import Any

import msgspec

from frictool.documents.mechanism import FrictionOf, Mechanism
from frictool.documents.quantity import Quantity, factor_between
from frictool.documents.struct_fields import fields_of
from frictool.errors import NoSolutionError

MOST_CORNERS = 3  # largest number of quantities for which all combinations of ends are reduced
Path = tuple[str, ...]
Numbers = dict[str, float]
Ends = dict[str, tuple[float, float]]
Uncertain = tuple[tuple[Path, Quantity], ...]


def uncertain(mechanism: Mechanism) -> Uncertain:
    """Return every quantity that has an interval, and its path of keys in the document."""
    return tuple(
        (path, one)
        for path, one in _quantities(mechanism, ())
        if one.low is not None or one.high is not None
    )


def _quantities(node: Any, path: Path) -> Iterator[tuple[Path, Quantity]]:
    if isinstance(node, Quantity):
        yield path, node
    elif isinstance(node, msgspec.Struct):
        for field in fields_of(type(node)):
            yield from _quantities(getattr(node, field.name), (*path, field.name))
    elif isinstance(node, dict):
        for name, value in node.items():
            yield from _quantities(value, (*path, str(name)))


def at(node: Any, path: Path, value: float) -> Any:
    """Return a copy of the document in which the quantity at the keys `path` is exactly `value`."""
    if isinstance(node, Quantity):
        return Quantity(value, unit=node.unit)
    head = path[0]
    rest = path[1:]
    if isinstance(node, dict):
        return {**node, head: at(node[head], rest, value)}
    return msgspec.structs.replace(node, **{head: at(getattr(node, head), rest, value)})


def _together(intervals: Uncertain) -> list[Uncertain]:
    sets: dict[Path, list[tuple[Path, Quantity]]] = {}
    for path, one in intervals:
        joined = path[-2:] in (("parameters", "coulomb"), ("parameters", "breakaway"))
        sets.setdefault(path[:-1] if joined else path, []).append((path, one))
    return [tuple(one) for one in sets.values()]


def _at_corners(
    mechanism: Mechanism, moved: Uncertain, numbers: Callable[[Mechanism], Numbers]
) -> Iterator[Numbers]:
    for corner in itertools.product(*(one.interval for _, one in moved)):
        there = mechanism
        said = []
        for (path, _), value in zip(moved, corner, strict=True):
            there = at(there, path, value)
            said.append(f"{'.'.join(path)} at {value:.6g}")
        try:
            yield numbers(consistent(there))
        except NoSolutionError as error:
            ends = "an end of its interval" if len(said) == 1 else "ends of their intervals"
            raise NoSolutionError(f"with {', '.join(said)}, {ends}: {error}") from None


def consistent(mechanism: Mechanism) -> Mechanism:
    """Return the mechanism with no breakaway below the Coulomb friction of its element.

    At an end of its interval, a breakaway may be smaller than the Coulomb friction. Such a
    breakaway is set to the Coulomb friction.
    """
    links = dict(mechanism.links)
    for name, link in links.items():
        if not isinstance(link, FrictionOf) or not {"coulomb", "breakaway"} <= set(link.parameters):
            continue
        slip, rest = link.parameters["coulomb"], link.parameters["breakaway"]
        if rest.value * factor_between(rest.unit, slip.unit) < slip.value:
            links[name] = msgspec.structs.replace(
                link, parameters={**link.parameters, "breakaway": slip}
            )
    return msgspec.structs.replace(mechanism, links=links)


def propagated(
    mechanism: Mechanism, numbers: Callable[[Mechanism], Numbers], progress: Callable[[str], None]
) -> Ends:
    """Return the interval (low, high) of each number of the reduced model.

    If no quantity of the mechanism has an interval, low equals high. `numbers` is the function that
    reduces a mechanism to these numbers.
    """
    centre = numbers(mechanism)
    low, high = dict(centre), dict(centre)
    intervals = uncertain(mechanism)
    for moved in _together(intervals):
        progress(f"interval of {', '.join('.'.join(path) for path, _ in moved)}")
        ends = list(_at_corners(mechanism, moved, numbers))
        for name, value in centre.items():
            low[name] += min(0.0, *(each.get(name, value) - value for each in ends))
            high[name] += max(0.0, *(each.get(name, value) - value for each in ends))
    if 2 <= len(intervals) <= MOST_CORNERS:
        for each in _at_corners(mechanism, intervals, numbers):
            for name, value in centre.items():
                low[name], high[name] = (
                    min(low[name], each.get(name, value)),
                    max(high[name], each.get(name, value)),
                )
    return {name: (low[name], high[name]) for name in centre}
