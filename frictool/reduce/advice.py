"""What to try where a reduction is refused, as numbers: the bandwidth, the tolerance, the travel
that would pass."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable

import numpy as np

from frictool.documents.mechanism import Mechanism
from frictool.plant.mechanism.linearisation import linearise
from frictool.plant.mechanism.sources_and_sensors import controlled_names
from frictool.reduce.assembly_cache import assemble_cached
from frictool.reduce.block_resistance import Vector
from frictool.reduce.compliance import middle, rigid, swings
from frictool.reduce.coordinate_change import from_source
from frictool.reduce.rigid_lumping import lump_rigid_links
from frictool.reduce.step_report import StepReport

MOST_TOLERANCE = 1.0  # that --tolerance takes
LOWEST, POINTS = 1e-4, 2000  # of the slowest resonance; bandwidths that are looked at
# of the part: on another travel the line nearest to the load is another, by points that lie
# elsewhere
ROOM = 0.02
WORTH = 0.1  # of the travel: a narrower part is no use


def passing_bandwidth(whole: Mechanism, tolerance: float) -> float | None:
    """The largest bandwidth [rad/s], rounded down, below every resonance, up to which all links
    rigid change the gain by no more than `tolerance`; None where there is none. Raises WrongElement
    and NoSolutionError as the steps of the reduction do."""
    source, sensor = controlled_names(whole)
    seen, _ = from_source(whole, source)
    one, _ = lump_rigid_links(seen, seen.sources[source].on)
    yielding = swings(one, one.sources[source].on)
    slowest = min((each.frequency for each in yielding), default=math.inf)
    if not math.isfinite(slowest):
        return None
    stiff = rigid(one, {each.link.name for each in yielding})
    w = np.geomspace(LOWEST * slowest, slowest * (1.0 - 1e-9), POINTS)
    before, after = (
        linearise(assemble_cached(each), middle(each)).transfer(source, sensor).response(w)[:, 0, 0]
        for each in (one, stiff)
    )
    within = np.abs(np.abs(after / before) - 1.0) <= tolerance
    count = int(np.argmin(within)) if not bool(np.all(within)) else POINTS
    return None if count == 0 else rounded_down(float(w[count - 1]))


def rounded_down(value: float) -> float:
    """To three digits."""
    step = 10.0 ** (math.floor(math.log10(value)) - 2)
    return math.floor(value / step) * step


def needed_tolerance(told: Iterable[StepReport], play: float) -> float:
    """The least at which no error that decides is beyond it, rounded up to a hundredth; `play` is
    allowed beside it."""
    errors = [0.0]
    for one in told:
        errors += [one.predicted] if one.covered is None else []
        errors += (
            [(one.measured.distance - play) / one.measured.way]
            if one.measured is not None and one.measured.way > 0.0
            else []
        )
    return math.ceil(100.0 * max(errors) * (1.0 + 1e-9)) / 100.0


def other_tolerance(told: Iterable[StepReport], play: float) -> str:
    """A sentence's end: which tolerance passes, or that none does."""
    needed = needed_tolerance(told, play)
    if needed <= MOST_TOLERANCE:
        return f"--tolerance {needed:g}"
    return "the mechanism itself (frictool simulate): no --tolerance allows this error"


def parts_of_travel(x: Vector, holds: Callable[[slice], bool]) -> list[tuple[float, float]]:
    """Of positions x (n,), the widest part from the low end and that from the high end on which
    `holds` is true, rounded inwards; those that are short are left out."""
    found = []
    for from_low in (True, False):
        low, high = 2, len(x)  # holds of two points, not of all
        while high - low > 1:
            middle_count = (low + high) // 2
            part = slice(0, middle_count) if from_low else slice(len(x) - middle_count, len(x))
            low, high = (middle_count, high) if holds(part) else (low, middle_count)
        ends = (float(x[0]), float(x[low - 1])) if from_low else (float(x[-low]), float(x[-1]))
        room = ROOM * (ends[1] - ends[0])
        ends = (ends[0], ends[1] - room) if from_low else (ends[0] + room, ends[1])
        if ends[1] - ends[0] >= WORTH * float(x[-1] - x[0]):
            found.append(_inwards(ends))
    return found


def _inwards(ends: tuple[float, float]) -> tuple[float, float]:
    """Rounded to four digits of the width."""
    step = 10.0 ** (math.floor(math.log10(ends[1] - ends[0])) - 3)
    return round(math.ceil(ends[0] / step) * step, 12), round(math.floor(ends[1] / step) * step, 12)
