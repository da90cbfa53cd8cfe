"""Verdict on the wear: comparison of the wear with a limit.

If the wear at commissioning is known, the wear is divided by the wear at commissioning before the
comparison. An error of the actuator's constant cancels in this ratio. The first rule that applies
to the interval of wear or ratio decides:

    interval                                   exceeded       certain   reason
    no move yet                                undecided      no        only the prior is known
    entirely at or below 0                     undecided      no        friction is not negative
    entirely above the limit                   yes            yes
    entirely at or below the limit             no             yes
    fewer than FEWEST_MOVES moves              undecided      no        too few data
    lower end at most 1, limit above 1         undecided      no        the unit may be healthy
    else                                       by the value   no

One direction or zone may be worn although the mean over all directions and zones is small. The
limit is therefore also exceeded if the whole interval of one direction or zone is above the limit.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from frictool.observe.wear_estimate import EstimateRange, WearEstimate

FEWEST_MOVES = 2  # fewest moves for a verdict if the interval contains the limit
HEALTHY = 1.0  # wear of a unit with the friction of the model


@dataclass(frozen=True)
class WearVerdict:
    """Verdict on the wear, compared with a limit.

    - exceeded: True if the wear is above the limit; None if undecided
    - certain: True if the whole interval is on one side of the limit
    - reason: one line of text
    """

    limit: float
    exceeded: bool | None
    certain: bool
    reason: str


def judge(
    estimate: WearEstimate,
    limit: float,
    ratio: EstimateRange | None = None,
    doubts: Sequence[str] = (),
) -> WearVerdict:
    """Return the verdict on the wear, or on the ratio of the wear to the wear at commissioning.

    The ratio is compared with the limit; if `ratio` is None, the wear is. `doubts` contains reasons
    why the log may be from another rig (rig_plausibility.py). With a doubt, a wear below the limit
    is undecided, but a wear above the limit still exceeds the limit.
    """
    verdict = _of_all_and_parts(estimate, limit, ratio)
    return verdict if verdict.exceeded or not doubts else WearVerdict(limit, None, False, doubts[0])


def _of_all_and_parts(
    estimate: WearEstimate, limit: float, ratio: EstimateRange | None
) -> WearVerdict:
    judged, name = (estimate.wear, "wear") if ratio is None else (ratio, "ratio to commissioning")
    of_all = _judged(name, judged, estimate.moves, limit)
    if of_all.exceeded:
        return of_all
    for part, worn in _parts(estimate, ratio):
        if worn.low > limit:
            return WearVerdict(
                limit,
                True,
                True,
                f"{_shown(f'{name} {part}', worn)} is above {limit:g}; the mean over "
                f"directions and zones is {judged.value:.4g}",
            )
    return of_all


def _judged(name: str, estimate: EstimateRange, moves: int, limit: float) -> WearVerdict:
    shown = _shown(name, estimate)
    if moves == 0:
        return WearVerdict(
            limit,
            None,
            False,
            "no move determines the wear yet: a move is the motion from one rest or reversal to "
            "the next",
        )
    if estimate.high <= 0.0:
        return WearVerdict(
            limit,
            None,
            False,
            f"{shown} is below 0, which is impossible: the log contradicts the bench",
        )
    if estimate.low > limit or estimate.high <= limit:
        exceeded = estimate.low > limit
        return WearVerdict(
            limit, exceeded, True, f"{shown} is {'above' if exceeded else 'not above'} {limit:g}"
        )
    if moves < FEWEST_MOVES:
        return WearVerdict(
            limit, None, False, f"{shown} after {moves} move{'s' * (moves != 1)}: too few to decide"
        )
    if estimate.low <= HEALTHY < limit:
        return WearVerdict(
            limit,
            None,
            False,
            f"{shown} contains both {HEALTHY:g} and {limit:g}: "
            "a longer log or faster moves may decide",
        )
    exceeded = estimate.value > limit
    return WearVerdict(
        limit,
        exceeded,
        False,
        f"{shown} is {'above' if exceeded else 'not above'} {limit:g}, which its interval contains",
    )


def _parts(
    estimate: WearEstimate, ratio: EstimateRange | None
) -> Iterator[tuple[str, EstimateRange]]:
    """Yield name and wear of each direction or zone; with `ratio`, relative to commissioning."""
    if estimate.kind == "directional":
        sides = (("forward", estimate.forward), ("backward", estimate.backward))
        parts = [(name, worn) for name, worn in sides if worn is not None]
    else:
        parts = [(f"from {zone.low:.4g} to {zone.high:.4g}", zone.wear) for zone in estimate.zones]
    for name, worn in parts:
        yield name, worn if ratio is None else worn.over(_reference(estimate.wear, ratio))


def _reference(wear: EstimateRange, ratio: EstimateRange) -> EstimateRange:
    """Return the wear at commissioning, computed from wear and ratio.

    The computation is the inverse of `EstimateRange.over`.
    """
    value = wear.value / ratio.value

    def widened(whole: float, part: float) -> float:
        return value * math.sqrt(max(whole**2 - part**2, 0.0))

    above = widened(1.0 - ratio.low / ratio.value, 1.0 - wear.low / wear.value)
    below = widened(ratio.high / ratio.value - 1.0, wear.high / wear.value - 1.0)
    return EstimateRange(value, value - below, value + above)


def _shown(name: str, estimate: EstimateRange) -> str:
    return f"{name} {estimate.value:.4g} in [{estimate.low:.4g}, {estimate.high:.4g}]"
