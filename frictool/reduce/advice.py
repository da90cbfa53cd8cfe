"""Advice after a failed reduction: a bandwidth, tolerance or travel that would succeed."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable

import numpy as np

from frictool.adapters.mechanism.sources_and_sensors import controlled_names
from frictool.documents.mechanism import Mechanism
from frictool.plant.mechanism.linearisation import linearise
from frictool.reduce.assembly_cache import assemble_cached
from frictool.reduce.compliance import link_resonances, middle, rigid
from frictool.reduce.coordinate_change import from_source
from frictool.reduce.rigid_lumping import lump_rigid_links
from frictool.reduce.step_report import StepReport
from frictool.typing import Vector

MOST_TOLERANCE = 1.0  # largest value of --tolerance
# lowest bandwidth tried, relative to the slowest resonance; number of bandwidths tried
LOWEST = 1e-4
POINTS = 2000
# margin at each end of a part, relative to the part's width; a load law of the part alone differs
END_MARGIN = 0.02
WORTH = 0.1  # smallest useful part, relative to the travel


def passing_bandwidth(whole: Mechanism, tolerance: float) -> float | None:
    """Return the largest bandwidth [rad/s] for which all compliant links can be made rigid.

    Up to this bandwidth, which is below every resonance, rigid links change the gain by at most
    `tolerance`. The result is None if no bandwidth suffices or no link is compliant. Raises
    ElementError or NoSolutionError if the mechanism cannot be reduced.
    """
    source, sensor = controlled_names(whole)
    seen, _ = from_source(whole, source)
    one, _ = lump_rigid_links(seen, seen.sources[source].on)
    yielding = link_resonances(one, one.sources[source].on)
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
    """Return `value` rounded down to three significant digits."""
    step = 10.0 ** (math.floor(math.log10(value)) - 2)
    return math.floor(value / step) * step


def needed_tolerance(reports: Iterable[StepReport], play: float) -> float:
    """Return the smallest --tolerance, rounded up to 0.01, that allows the errors of all steps.

    play: backlash at the sensor [rad | m].
    """
    errors = [0.0]
    for one in reports:
        errors += [one.predicted] if one.covered is None else []
        errors += (
            [(one.measured.distance - play) / one.measured.travelled]
            if one.measured is not None and one.measured.travelled > 0.0
            else []
        )
    return math.ceil(100.0 * max(errors) * (1.0 + 1e-9)) / 100.0


def other_tolerance(reports: Iterable[StepReport], play: float) -> str:
    """Return advice for a message: a sufficient --tolerance, or an alternative if none suffices."""
    needed = needed_tolerance(reports, play)
    if needed <= MOST_TOLERANCE:
        return f"--tolerance {needed:g}"
    return "the mechanism itself (frictool simulate), since no --tolerance allows this error"


def parts_of_travel(x: Vector, holds: Callable[[slice], bool]) -> list[tuple[float, float]]:
    """Return the widest ranges of positions that begin at an end of the travel and satisfy `holds`.

    - x (n,): positions of the travel
    - holds: function that returns True if a slice of x satisfies the condition

    The limits of the ranges are rounded inwards. Ranges narrower than the fraction WORTH of the
    travel are left out.
    """
    parts = []
    for from_low in (True, False):
        # invariant: `holds` for `low` points, not for `high`
        low = 2
        high = len(x)
        while high - low > 1:
            middle_count = (low + high) // 2
            part = slice(0, middle_count) if from_low else slice(len(x) - middle_count, len(x))
            low, high = (middle_count, high) if holds(part) else (low, middle_count)
        ends = (float(x[0]), float(x[low - 1])) if from_low else (float(x[-low]), float(x[-1]))
        margin = END_MARGIN * (ends[1] - ends[0])
        ends = (ends[0], ends[1] - margin) if from_low else (ends[0] + margin, ends[1])
        if ends[1] - ends[0] >= WORTH * float(x[-1] - x[0]):
            parts.append(_inwards(ends))
    return parts


def _inwards(ends: tuple[float, float]) -> tuple[float, float]:
    step = 10.0 ** (math.floor(math.log10(ends[1] - ends[0])) - 3)
    return round(math.ceil(ends[0] / step) * step, 12), round(math.floor(ends[1] / step) * step, 12)
