"""Check of loops with an axis that rings after it stops, on plants of two inertias.

The rigid model determines neither the ratio of the two inertias nor which body has the encoder. The
loops are checked with each plant of `adapters/two_inertias.py`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from frictool.adapters.two_inertias import TwoInertias, two_inertias
from frictool.documents.controller import Controller
from frictool.documents.resonances import Ringing
from frictool.plant.polytope import PlantPoint
from frictool.presentation.tie_rule import smallest
from frictool.verify.feedback_loops import feedbacks_of
from frictool.verify.loop_values import delays_checked
from frictool.verify.resonant_loop import resonant_check
from frictool.verify.speed_loop import is_required
from frictool.verify.vertices import vertex_points

# a resonance that no log shows: damping ratio, and tried frequencies relative to half the sampling
# rate, from the highest
UNKNOWN_DAMPING = 0.02
TRIED = tuple(2.0 ** (-k / 4.0) for k in range(29))
SLOWER = (2.0, 4.0, 8.0, 16.0)  # tried ratios of the loop's time constants to the present ones


@dataclass(frozen=True)
class RingingCheck:
    """Smallest modulus margin of a controller's loops over all plants of two inertias.

    The margin is 0 if a loop is unstable on a plant.

    - plant: plant with the smallest margin
    - required: required margin
    - slower: smallest factor in SLOWER that gives the required margin if it multiplies all time
      constants of the controller; 1 if the controller already has this margin, None if no factor
      suffices
    """

    plant: TwoInertias
    modulus_margin: float
    required: float
    slower: float | None = 1.0

    @property
    def shown(self) -> bool:
        """Return True if the loops are stable and have the required margin on every plant."""
        return self.modulus_margin > 0.0 and self.modulus_margin >= self.required

    @property
    def doubt(self) -> str:
        """Return the reason why the loops may fail on the axis; "" if they are `shown`."""
        if self.shown:
            return ""
        if self.modulus_margin == 0.0:
            return doubt_words(self.plant, "the loop is unstable", self.slower)
        margin = f"modulus margin {self.modulus_margin:.3g} < {self.required:g}"
        return doubt_words(self.plant, margin, self.slower)


def doubt_words(plant: TwoInertias, failure: str, slower: float | None = None) -> str:
    """Return the reason why a controller may fail on an axis that rings after it stops.

    failure: what fails on `plant`. slower: factor of `RingingCheck`, or None if it is unknown.
    """
    hertz = plant.oscillation.rad_s / (2.0 * math.pi)
    times = "" if slower is None else f" by a factor of {slower:g}"
    return (
        f"the axis rings at {hertz:.3g} Hz; with {plant.name}, {failure}; slow the loop{times}, or "
        "model the compliance (frictool reduce)"
    )


def ringing_doubt(controller: Controller) -> str:
    """Return the reason why the margins at the vertices may be wrong; "" if there is none."""
    if controller.ringing is None:
        return ""
    return ringing_check(controller, vertex_points(controller), controller.ringing).doubt


def ringing_check(
    controller: Controller, points: Sequence[PlantPoint], oscillation: Ringing
) -> RingingCheck:
    """Return the smallest margin of a controller's loops on plants of two inertias.

    points: total inertia and other parameters of the plants. oscillation: oscillation of the axis
    after it stops. The delays are those of the check without the oscillation; a margin is required
    at the bench's delay only.

    To find the factor `slower`, the oscillation is made faster instead of the loop slower; apart
    from the delay, the margins are the same.
    """
    checks = [*_checks(controller, points, oscillation)]
    worst = checks[smallest(_reserves(checks))[1]]
    if worst.shown:
        return worst
    tried = ((factor, oscillation.scaled(factor)) for factor in SLOWER)
    shown = (
        factor
        for factor, faster in tried
        if all(one.shown for one in _checks(controller, points, faster))
    )
    return replace(worst, slower=next(shown, None))


def lowest_tolerated(controller: Controller) -> float | None:
    """Return the lowest frequency [Hz] from which on an unknown resonance leaves the loops stable.

    The loops are checked with two-mass plants, which have the parameters of the vertex with the
    smallest margin and the damping ratio UNKNOWN_DAMPING. Their resonance is moved from half the
    sampling rate downwards (TRIED). The result is the last frequency before a loop becomes
    unstable, at most half the sampling rate. It is None if no tried frequency makes a loop
    unstable.
    """
    vertices = controller.verified.vertices
    worst = smallest([one.modulus_margin for one in vertices])[1]
    points = vertex_points(controller)[worst : worst + 1]
    highest = 0.5 / controller.sample_period_s
    above = highest
    for share in TRIED:
        known = Ringing(2.0 * math.pi * share * highest, UNKNOWN_DAMPING, in_motion=True)
        if any(one.modulus_margin == 0.0 for one in _checks(controller, points, known)):
            return above
        above = share * highest
    return None


def unknown_resonance(controller: Controller) -> list[str]:
    """Return a line on resonances that no log shows; [] if the controller knows a resonance."""
    if controller.ringing is not None or controller.resonances is not None:
        return []
    above = lowest_tolerated(controller)
    if above is None:
        return []
    return [
        f"not tested: an elastic drive train; a resonance below {above:.3g} Hz may make a loop "
        f"unstable (damping ratio {UNKNOWN_DAMPING:g}); to find one, add a chirp up to this "
        "frequency to the drive of the moving axis, and log it"
    ]


def _checks(
    controller: Controller, points: Sequence[PlantPoint], oscillation: Ringing
) -> Iterator[RingingCheck]:
    loops = feedbacks_of(controller)
    lag = controller.bench.actuator.loop_time_constant_s
    specified = controller.verified.modulus_margin_specified
    for plant in two_inertias(oscillation):
        for samples in delays_checked(controller.delay_samples):
            if is_required(samples, controller.delay_samples):
                check = resonant_check(loops, points, lag, samples, plant.resonances())
                required = specified if samples == controller.delay_samples else 0.0
                yield RingingCheck(plant, check.modulus_margin, required)


def _reserves(checks: Sequence[RingingCheck]) -> list[float]:
    return [one.modulus_margin - one.required if one.modulus_margin else -1.0 for one in checks]
