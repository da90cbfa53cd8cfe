"""Whether wear is above a limit: by the ratio to commissioning where there is one, which is free of the actuator's constant."""

from __future__ import annotations

from dataclasses import dataclass

from frictool.observe.estimate import Estimate, Range

FEWEST_MOVES = 2  # fewer tell nothing unless their interval does


@dataclass(frozen=True)
class Verdict:
    """Against a limit of the wear. exceeded: None where it cannot be told. certain: whether all of the interval says so. reason: in one
    line."""

    limit: float
    exceeded: bool | None
    certain: bool
    reason: str


def judge(estimate: Estimate, limit: float, ratio: Range | None = None) -> Verdict:
    """The wear, or its ratio to commissioning, against the limit."""
    found, name = (estimate.wear, "wear") if ratio is None else (ratio, "ratio to commissioning")
    shown = f"{name} {found.value:.4g} in [{found.low:.4g}, {found.high:.4g}]"
    if found.low > limit or found.high <= limit:
        exceeded = found.low > limit
        return Verdict(limit, exceeded, True, f"{shown} is {'above' if exceeded else 'not above'} {limit:g}")
    if estimate.moves < FEWEST_MOVES:
        return Verdict(limit, None, False, f"{shown} after {estimate.moves} move{'s' * (estimate.moves != 1)}: too few to tell")
    exceeded = found.value > limit
    return Verdict(limit, exceeded, False, f"{shown} is {'above' if exceeded else 'not above'} {limit:g}, but not for certain")
