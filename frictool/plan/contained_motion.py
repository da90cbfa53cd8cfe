"""Tests of strokes in which every possible axis of a bench stays within the travel.

A test of strokes is a reference of the position loop. A real axis does not follow this reference
exactly. If the inertia or the friction of the axis differs from the bench's value, the axis
overshoots the reversals. A coarse encoder or a long delay makes the loop slow, and the overshoot
larger. The test is simulated on axes whose parameters are at the ends of the a-priori intervals.
The reference keeps a margin to each end of the travel. If such an axis uses more than half of this
margin, the test is designed again for a shorter travel.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import product

from msgspec import structs

from frictool.documents.bench import Bench
from frictool.documents.quantity import si_unit
from frictool.errors import NoSolutionError
from frictool.identify.excite.bench_limits import MARGIN
from frictool.identify.excite.excitation_sequence import ExcitationSequence
from frictool.identify.excite.precise_strokes import PreciseTest
from frictool.identify.model_document import BREAKAWAY_RATIO
from frictool.plan.assumed_axis import assumed_axis
from frictool.simulate import play
from frictool.simulate.default_servo import default_servo, feedforward

KEPT = 0.5  # least share of the reference's margin that every axis keeps
DESIGNS = 5  # largest number of designs, each for a shorter travel
OVERSHORTENED = 1.2  # factor on the excess by which the travel is shortened at each end


@dataclass
class ContainedDesign:
    """Design of tests in which every possible axis stays within the travel of the bench.

    - bench: bench with its a-priori intervals and its travel
    - usable: bench with the travel for which tests are designed, shortened if an axis came
      too close to an end
    """

    bench: Bench
    usable: Bench

    @classmethod
    def of(cls, bench: Bench) -> ContainedDesign:
        """Return a design that begins with the whole travel of a bench."""
        return cls(bench, bench)

    def test(self, design: Callable[[Bench], PreciseTest]) -> PreciseTest:
        """Return a test by `design`, shortened until every axis stays within the bench's travel.

        Raises
        ------
        NoSolutionError
            If `design` makes no test, or if an axis leaves the allowed positions in each of DESIGNS
            tests.
        """
        for _ in range(DESIGNS):
            test = design(self.usable)
            beyond = overrun(test.sequence, self.bench)
            if beyond <= 0.0:
                return test
            # shorten by more than the excess, because the excess changes a little with the test
            more = max(OVERSHORTENED * beyond, self.bench.encoder.resolution)
            self.usable = _shortened(self.usable, more)
        unit = si_unit("position", self.bench.axis)
        raise NoSolutionError(
            f"travel: within the ranges of `mechanics`, an axis comes {beyond:.3g} {unit} too "
            "close to an end of the travel; narrow `mechanics`, use a finer encoder or more travel"
        )


def overrun(sequence: ExcitationSequence, bench: Bench) -> float:
    """Return the largest excursion of an axis beyond the allowed positions, rad | m.

    At each end of the travel, the allowed positions exclude half of the margin that the reference
    keeps to this end. The result is 0 if every axis stays within the allowed positions, or if the
    bench has no travel.
    """
    travel = bench.mechanics.travel
    if travel is None:
        return 0.0
    kept = KEPT * MARGIN * (travel.high - travel.low)
    test = sequence.as_log("test")
    servo, forward = default_servo(bench), feedforward(bench, test)
    # simulated without stops, because the motion would end at a stop
    endless = structs.replace(bench, mechanics=structs.replace(bench.mechanics, travel=None))
    beyond = 0.0
    for values in _extreme_axes(bench):
        log = play(assumed_axis(endless, values), test, servo=servo, forward=forward)
        position = log.main.signals["position"]
        low, high = float(position.min()), float(position.max()) + bench.encoder.resolution
        beyond = max(beyond, travel.low + kept - low, high - (travel.high - kept))
    return beyond


def _extreme_axes(bench: Bench) -> Iterator[dict[str, float]]:
    """Yield the axes with inertia, Coulomb friction and offset at the ends of their intervals.

    Viscous friction is at the lower end of its interval. The drive's constant has the value of the
    bench. The motion depends on the ratios of the parameters to the constant. Each interval is
    therefore widened by the relative range of the constant.
    """
    known, constant = bench.mechanics, bench.actuator.constant
    scales = [constant.value / end for end in constant.interval]

    def ends(interval: tuple[float, float]) -> tuple[float, float]:
        low, high = interval
        return min(low * scale for scale in scales), max(high * scale for scale in scales)

    offsets = set(ends(known.offset.interval)) if known.offset is not None else {0.0}
    for inertia, coulomb, offset in product(
        ends(known.inertia.interval), ends(known.coulomb.interval), offsets
    ):
        yield {
            "inertia": inertia,
            "viscous": ends(known.viscous.interval)[0],
            "coulomb": coulomb,
            "offset": offset,
            "breakaway": BREAKAWAY_RATIO * coulomb,
        }


def _shortened(bench: Bench, length: float) -> Bench:
    """Return the bench with less travel: tests stay `length` [rad | m] farther from both ends."""
    travel = bench.mechanics.travel
    assert travel is not None
    cut = length / (1.0 - 2.0 * MARGIN)
    shorter = structs.replace(travel, low=travel.low + cut, high=travel.high - cut)
    if shorter.high <= shorter.low:
        raise NoSolutionError(
            "travel: every stroke on this bench can reach an end of the travel; narrow "
            "`mechanics`, use a finer encoder or more travel"
        )
    return structs.replace(bench, mechanics=structs.replace(bench.mechanics, travel=shorter))
