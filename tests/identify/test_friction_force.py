"""Friction force over speed from strokes in one direction, against known parameters."""

from __future__ import annotations

from dataclasses import replace

import msgspec
import numpy as np
import pytest
import scipy

from frictool.documents.bench import Bench
from frictool.documents.quantity import Quantity
from frictool.identify.estimators.friction_force import friction_force
from frictool.identify.fit_result import UnusableLogs
from frictool.identify.methods import METHODS, IdentificationSettings
from frictool.identify.motion_record import MotionRecord, make_record
from studies.rigs.identification_rigs import clutch, record
from studies.rigs.sample_logs import sines
from tests.support.linear_axis import ENCODER_STEP, PERIOD, linear_bench

INERTIA, VISCOUS, COULOMB, OFFSET = 5.0, 12.0, 8.0, 0.5  # kg, N s/m, N, N
REST = 100  # samples at rest before and after the stroke
NOISE = 0.05  # N, standard deviation


def stroke(side: float, duration: float = 0.5, speed: float = 0.4) -> MotionRecord:
    """Return a half sine of the speed between rests, in which a controller holds half the friction.

    `side` is the direction, +-1.
    """
    samples = round(duration / PERIOD)
    moving = speed * np.sin(np.pi * (np.arange(samples) + 0.5) / samples)
    velocity = side * np.concatenate((np.zeros(REST), moving, np.zeros(REST)))
    friction = np.where(velocity == 0.0, 0.5 * side * COULOMB, side * COULOMB)
    effort = INERTIA * np.gradient(velocity, PERIOD) + VISCOUS * velocity + friction + OFFSET
    effort += NOISE * np.random.default_rng(4).standard_normal(effort.size)
    position = scipy.integrate.cumulative_simpson(velocity, dx=PERIOD, initial=0.0)
    counts = np.floor(position / ENCODER_STEP) * ENCODER_STEP
    time = np.arange(velocity.size) * PERIOD
    return make_record(f"stroke{side:+g}", time, counts, effort, ENCODER_STEP, lag=1.0)


def with_inertia(inertia: Quantity) -> Bench:
    bench = linear_bench()
    return msgspec.structs.replace(
        bench, mechanics=msgspec.structs.replace(bench.mechanics, inertia=inertia)
    )


@pytest.mark.parametrize("nominal", [3.5, 5.0, 6.5])
def test_an_inertia_of_the_bench_that_is_wrong_within_its_range_moves_no_truth_out(
    nominal: float,
) -> None:
    bench = with_inertia(Quantity(nominal, 3.0, 7.0, "kg"))
    fit = friction_force([stroke(1.0), stroke(-1.0)], bench, IdentificationSettings())
    for name, truth in (("coulomb", COULOMB), ("viscous", VISCOUS), ("offset", OFFSET)):
        assert fit.parameters[name].low <= truth <= fit.parameters[name].high


def test_the_intervals_allow_for_samples_at_rest() -> None:
    """The fit alone states a Coulomb friction between that in motion and the effort at rest."""
    bench = with_inertia(Quantity(INERTIA, 4.9, 5.1, "kg"))
    fit = friction_force([stroke(1.0), stroke(-1.0)], bench, IdentificationSettings())
    coulomb = fit.parameters["coulomb"]
    assert coulomb.value < 0.9 * COULOMB
    assert coulomb.low <= COULOMB <= coulomb.high


def test_a_log_that_reverses_is_refused() -> None:
    """Even with the true inertia, sines would give a Coulomb friction that is far too small."""
    with pytest.raises(UnusableLogs, match="reverses, but friction-force needs a stroke in one"):
        friction_force([record(sines(1))], clutch(), IdentificationSettings())
    both = record(sines(1))
    assert "reverses" in str(METHODS["friction-force"].why_not([both]))
    assert METHODS["friction-force"].why_not([stroke(1.0)]) is None


def test_a_log_without_motion_and_one_with_gaps_are_refused() -> None:
    one = stroke(1.0)
    still = replace(one, position=np.zeros(one.position.size))
    gap = replace(one, piece=(np.arange(one.position.size) > 300).astype(np.int64))
    for log, reason in ((still, "does not move"), (gap, "has gaps")):
        with pytest.raises(UnusableLogs, match=reason):
            friction_force([log], linear_bench(), IdentificationSettings())
