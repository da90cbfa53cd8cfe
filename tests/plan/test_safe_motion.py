"""Motion of the axes of a bench: ramps begin at rest, and strokes stay in the travel."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from msgspec import structs

from frictool.documents.bench import Bench, Encoder
from frictool.documents.quantity import Quantity, Span
from frictool.errors import NoSolutionError
from frictool.identify.excite.breakaway_ramps import RATIOS
from frictool.identify.excite.excitation_kinds import ExcitationSettings, excite
from frictool.identify.excite.excitation_sequence import ExcitationSequence
from frictool.identify.excite.precise_strokes import (
    PreciseTest,
    PrecisionRequest,
    precise_strokes,
)
from frictool.logs.log import Log
from frictool.plan.assumed_axis import assumed_axis
from frictool.plan.contained_motion import ContainedDesign, overrun
from frictool.simulate import play
from frictool.simulate.default_servo import default_servo, feedforward
from tests.support.linear_axis import linear_bench

TRAVEL = 0.4  # m
COARSE = 2e-3  # m, encoder step that makes the position loop slow


def slippery_bench(step: float = 1e-6, travel: float = TRAVEL) -> Bench:
    """Return a bench whose Coulomb friction is known to a factor of ten."""
    bench = linear_bench()
    mechanics = structs.replace(
        bench.mechanics,
        viscous=Quantity(4.0, 0.0, 8.0, "N s/m"),
        coulomb=Quantity(5.0, 1.0, 10.0, "N"),
        travel=Span(0.0, travel, "m"),
        top_speed=Quantity(2.0, unit="m/s"),
    )
    encoder = Encoder(step=Quantity(step, unit="m"))
    return structs.replace(bench, mechanics=mechanics, encoder=encoder)


@pytest.fixture(scope="module")
def ramps() -> Log:
    return excite("breakaway", slippery_bench(), ExcitationSettings()).as_log("ramps")


@pytest.mark.parametrize(
    ("inertia", "coulomb"),
    [
        (3.0, 1.0),
        (7.0, 10.0),
        *(pytest.param(*one, marks=pytest.mark.accept) for one in ((3.0, 10.0), (7.0, 1.0))),
    ],
)
@pytest.mark.parametrize("ratio", RATIOS)
def test_every_axis_rests_before_the_next_ramp_rises(
    ramps: Log, inertia: float, coulomb: float, ratio: float
) -> None:
    bench = slippery_bench()
    values = {"inertia": inertia, "viscous": 0.0, "coulomb": coulomb, "offset": 0.0}
    axis = assumed_axis(bench, {**values, "breakaway": ratio * coulomb})
    log = play(axis, ramps)
    position, drive = (log.main.signals[name] for name in ("position", "current"))
    begins = np.flatnonzero((drive[:-1] == 0.0) & (drive[1:] != 0.0))
    assert begins.size >= 40
    np.testing.assert_array_equal(position[begins], position[begins - 1])


def strokes(bench: Bench) -> PreciseTest:
    return precise_strokes(bench, PrecisionRequest({"inertia": 0.1}, duration=10.0))


def least_distance(sequence: ExcitationSequence, bench: Bench) -> float:
    """Return the least distance [m] of extreme axes from the ends of the travel."""
    test, known = sequence.as_log("test"), bench.mechanics
    least = np.inf
    for inertia, coulomb in product(known.inertia.interval, known.coulomb.interval):
        values = {"inertia": inertia, "viscous": 0.0, "coulomb": coulomb, "offset": 0.0}
        axis = assumed_axis(bench, {**values, "breakaway": 1.1 * coulomb})
        log = play(axis, test, servo=default_servo(bench), forward=feedforward(bench, test))
        position = log.main.signals["position"]
        least = min(least, position.min(), TRAVEL - position.max() - bench.encoder.resolution)
    return float(least)


def test_strokes_of_a_slow_position_loop_stay_clear_of_the_end_stops() -> None:
    bench = slippery_bench(COARSE)
    assert least_distance(strokes(bench).sequence, bench) < COARSE  # at the stop
    contained = ContainedDesign.of(bench).test(strokes)
    assert overrun(contained.sequence, bench) == 0.0
    assert least_distance(contained.sequence, bench) >= 0.025 * TRAVEL


def test_strokes_of_a_stiff_position_loop_keep_the_whole_travel() -> None:
    bench = slippery_bench()
    reference = ContainedDesign.of(bench).test(strokes).sequence.columns["reference"]
    np.testing.assert_array_equal(reference, strokes(bench).sequence.columns["reference"])


def test_a_travel_that_no_stroke_keeps_is_refused() -> None:
    with pytest.raises(NoSolutionError, match=r"travel: .*use a finer encoder"):
        ContainedDesign.of(slippery_bench(COARSE, 0.04)).test(strokes)
