"""Wear at changing temperatures: taken out with the channel, and what is said where it is not."""

from __future__ import annotations

from pathlib import Path

import msgspec
import numpy as np
import pytest

from frictool.documents.bench import Bench
from frictool.documents.laws import Laws
from frictool.documents.model import Model
from frictool.documents.registry import load
from frictool.identify.identification import identify_records
from frictool.identify.methods import IdentificationSettings
from frictool.identify.model_document import model_of
from frictool.observe.friction_tracker import FrictionTracker
from frictool.observe.log_observer import LogObserver, ObservationSettings
from frictool.observe.motion_block import MotionBlock
from frictool.observe.wear.wear_estimator import WearEstimator
from frictool.observe.wear_limit import judge
from tests.support.loaded_axis import BENCH, COUNT
from tests.support.provenance import HERE
from tests.support.warm_axes import WarmAxis, changing, warm_axes, warming_up
from tests.support.warm_models import REFERENCE, warm_model, wear_of

WEARS = (1.0, 1.2, 1.5)
MEAN_ERROR = 0.02  # largest mean error of the wear under 30 to 80 degC


@pytest.mark.parametrize(
    ("curved", "axes"),
    [
        (True, 3),
        (False, 3),
        *(pytest.param(curved, 9, marks=pytest.mark.accept) for curved in (True, False)),
    ],
)
def test_the_temperature_is_taken_out_of_the_wear(curved: bool, axes: int) -> None:
    """Viscous friction halves from 30 to 80 degC, by the law of the model or by a line."""
    warm = warm_axes(range(500, 500 + axes), curved, changing, WEARS)
    with_channel, without = (
        np.array([wear_of(warm_model(one), one, known).wear.value / one.truth.wear for one in warm])
        for known in (True, False)
    )
    error = np.mean(np.abs(with_channel - 1.0))
    assert error <= MEAN_ERROR
    assert error < (0.1 if curved else 0.5) * np.mean(np.abs(without - 1.0))


def test_wear_at_other_temperatures_than_those_of_the_identification() -> None:
    """The model is identified along a warming up; later logs have other temperatures and wears."""
    (new,) = warm_axes([31], True, warming_up)
    result = identify_records(new.records, [], new.bench, "auto", IdentificationSettings())
    model = model_of(result, new.bench, HERE)
    for wear in WEARS:
        (later,) = warm_axes([31], True, changing, (wear,))
        estimate = wear_of(model, later)
        assert estimate.wear.value == pytest.approx(wear, rel=0.01)
        assert judge(estimate, 1.1).exceeded == (wear > 1.1)


@pytest.mark.parametrize(
    ("number", "least"), [(6, 4), pytest.param(20, 16, marks=pytest.mark.accept)]
)
def test_a_wrong_slope_is_in_the_interval(number: int, least: int) -> None:
    """The slope of the Coulomb friction is wrong by a random error; at 25 K it shifts the wear."""
    held = []
    axes = warm_axes(range(40, 40 + number), True, lambda _: [np.full(20_000, REFERENCE + 25.0)])
    for seed, axis in enumerate(axes):
        estimate = wear_of(warm_model(axis, (0.0, 5e-4), seed), axis)
        held.append(estimate.wear.low <= 1.0 <= estimate.wear.high)
    assert sum(held) >= least  # fewer once in 400 draws at 95 %
    exact = wear_of(warm_model(axes[0]), axes[0]).wear
    wide = wear_of(warm_model(axes[0], (0.0, 5e-4)), axes[0]).wear
    assert wide.high - wide.value == pytest.approx(
        np.hypot(exact.high - exact.value, 1.96 * 25.0 * 5e-4 * wide.value), rel=1e-6
    )


def test_a_log_in_blocks_gives_the_same_wear() -> None:
    (axis,) = warm_axes([61], True, changing, (1.3,))
    model = warm_model(axis)
    record = axis.records[0]
    assert record.temperature is not None
    whole = wear_of(model, axis)
    estimator = WearEstimator(model)
    for first in range(0, record.time.size, 777):
        part = slice(first, first + 777)
        estimator.take(
            MotionBlock(
                record.time[part],
                record.position[part],
                record.effort[part],
                first > 0,
                None,
                record.temperature.values[part],
            )
        )
    estimator.finish()
    assert estimator.estimate == whole


def test_the_friction_along_a_log_is_that_at_its_temperature() -> None:
    """At constant speed the friction is coulomb exp(q h) + viscous exp(r h) v."""
    (axis,) = warm_axes([62], True, changing)
    model = warm_model(axis)
    warm = np.linspace(30.0, 80.0, 200)
    time = 1e-3 * np.arange(warm.size)
    speed = 2.0 * np.ones(warm.size)
    block = MotionBlock(time, speed * time, np.zeros(warm.size), False, None, warm)
    estimate = WearEstimator(model).estimate
    known = [(0, estimate)]
    friction = FrictionTracker(model).take(block, np.stack([speed, speed, speed]), known)
    true = axis.truth.viscous(warm) * speed + axis.truth.coulomb(warm)
    assert friction[0] == pytest.approx(true, rel=0.01)  # the Coulomb friction falls along a line


def observed(folder: Path, axis: WarmAxis, model: Model, temperature: bool) -> tuple[str, ...]:
    """Return the remarks of `observe run` on the first log of an axis."""
    record = axis.records[0]
    assert record.temperature is not None
    columns = [record.time, np.rint(record.position / COUNT), record.effort]
    names = ["time [s]", "encoder", "torque [N m]"]
    if temperature:
        columns.append(record.temperature.values)
        names.append("motor [degC]")
    path = folder / "log.csv"
    np.savetxt(path, np.column_stack(columns), "%.9g", ",", header=",".join(names), comments="")
    entry = "  temperature: {column: motor, unit: degC}\n" if temperature else ""
    (folder / "bench.yaml").write_text(BENCH + entry)
    own = msgspec.structs.replace(model, bench=load(folder / "bench.yaml", Bench))
    observer = LogObserver(path, own, ObservationSettings())
    observer.wear_alone()
    return observer.outcome().remarks


def test_a_temperature_that_cannot_be_taken_out_is_a_warning(tmp_path: Path) -> None:
    (axis,) = warm_axes([63], True, warming_up)
    model = warm_model(axis)
    law = model.laws.temperature if model.laws is not None else None
    assert law is not None
    assert observed(tmp_path, axis, model, True) == ()
    (missing,) = observed(tmp_path, axis, model, False)
    assert missing == (
        "the log has no temperature: the wear assumes 55 degC, the model's reference; map the "
        "temperature in columns.temperature of the bench"
    )
    narrow = msgspec.structs.replace(law, over=msgspec.structs.replace(law.over, high=60.0))
    (extrapolated,) = observed(
        tmp_path, axis, msgspec.structs.replace(model, laws=Laws(temperature=narrow)), True
    )
    assert (
        "are not within the 30 to 60 degC of the model's logs: friction is extrapolated"
        in extrapolated
    )
    (unknown,) = observed(tmp_path, axis, msgspec.structs.replace(model, laws=None), True)
    assert unknown.startswith("the model's friction does not depend on temperature")
    assert all(len(text) <= 200 for text in (missing, extrapolated, unknown))
