"""Interval of the sum of offset and load over the position."""

from __future__ import annotations

import msgspec
import numpy as np
import pytest

from frictool.documents.quantity import Span
from frictool.identify.fit_warnings import extrapolated_spring_warnings, logged_positions
from frictool.identify.methods import IdentificationSettings, run
from frictool.identify.text_view import total_line
from frictool.identify.total_load import total_load
from frictool.synth.load_disturbance import amplitude
from tests.support.loaded_axis import loaded_axis

CONFIDENCE = 0.95


@pytest.mark.parametrize("seed", [1, 4])
def test_the_total_load_contains_the_truth_and_is_narrower_than_its_terms(seed: int) -> None:
    """The travel is longer than the motion; offset, sine and cosine are nearly collinear."""
    axis = loaded_axis(seed, "gravity")
    low, high = float(axis.record.position.min()), float(axis.record.position.max())
    travel = Span(low - 0.1, high + 0.1, "rad")
    mechanics = msgspec.structs.replace(axis.bench.mechanics, travel=travel)
    bench = msgspec.structs.replace(axis.bench, mechanics=mechanics)
    fit = run("least-squares", [axis.record], bench, IdentificationSettings(CONFIDENCE))
    offset = fit.parameters["offset"]
    total = total_load(fit, offset, [axis.record], bench, CONFIDENCE)
    assert total is not None
    angle, truth = np.linspace(travel.low, travel.high, 200), axis.truth
    load = truth["gravity_sine"] * np.sin(angle) + truth["gravity_cosine"] * np.cos(angle)
    load += truth["offset"]
    assert total.least.interval[0] <= np.min(load) <= total.least.interval[1]
    assert total.largest.interval[0] <= np.max(load) <= total.largest.interval[1]
    assert fit.laws is not None
    assert fit.laws.load is not None
    gravity = fit.laws.load.gravity
    assert gravity is not None
    apart = max(abs(offset.low), abs(offset.high)) + amplitude(gravity.sine, gravity.cosine)
    assert max(-total.least.interval[0], total.largest.interval[1]) < apart


def test_a_spring_needs_a_travel_and_is_extrapolated_beyond_the_motion_with_a_warning() -> None:
    axis = loaded_axis(1, "spring")
    fit = run("least-squares", [axis.record], axis.bench, IdentificationSettings(CONFIDENCE))
    assert axis.bench.mechanics.travel is None
    found = total_load(fit, fit.parameters["offset"], [axis.record], axis.bench, CONFIDENCE)
    assert found is None
    logged = logged_positions([axis.record], axis.bench)
    assert logged is not None
    low, high = logged.low, logged.high
    for beyond, warned in ((0.09, False), (0.11, True)):
        travel = Span(low - beyond * (high - low), high, "rad")
        mechanics = msgspec.structs.replace(axis.bench.mechanics, travel=travel)
        bench = msgspec.structs.replace(axis.bench, mechanics=mechanics)
        assert bool(extrapolated_spring_warnings(fit, logged, bench)) is warned
        total = total_load(fit, fit.parameters["offset"], [axis.record], bench, CONFIDENCE)
        assert total is not None
        assert "if the spring outside the logs (" in total_line(total, logged)
        assert total_line(total, travel).endswith("at any position")
