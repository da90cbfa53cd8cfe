"""Friction over a measured temperature: levels, changes and their intervals; refusals."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import pairwise

import msgspec
import numpy as np
import pytest

from frictool.adapters.temperature_factors import temperature_factors
from frictool.documents.laws import FrictionOverTemperature
from frictool.documents.load_terms import LoadTerms
from frictool.documents.quantity import Quantity, Span
from frictool.identify.fit_result import UnusableLogs
from frictool.identify.force_error import force_error, motion_rows
from frictool.identify.identification import Identification, identify_records
from frictool.identify.methods import IdentificationSettings, run
from frictool.identify.motion_record import MotionRecord
from frictool.identify.rows.temperature_shape import shaped
from frictool.identify.text_view import temperature_lines
from tests.support.warm_axes import (
    COLD,
    HOT,
    SAMPLES,
    Histories,
    WarmAxis,
    cold_and_hot,
    simulated,
    warm_axes,
    warming_up,
)

USUAL = IdentificationSettings()


def identified(axis: WarmAxis) -> tuple[Identification, FrictionOverTemperature]:
    """Return the identification of an axis by the default method, and its law."""
    result = identify_records(axis.records, [], axis.bench, "auto", USUAL)
    assert result.laws is not None
    assert result.laws.temperature is not None
    return result, result.laws.temperature


def test_the_simulator_has_the_steady_speed_and_the_stop_of_its_equation() -> None:
    """A constant effort u gives (u - coulomb)/viscous; then the axis stops and stays."""
    (axis,) = warm_axes([5], True, lambda _: [np.full(SAMPLES, HOT)])
    truth = replace(axis.truth, offset=0.0)
    effort = np.where(np.arange(SAMPLES) < SAMPLES // 2, 40.0, 0.5 * truth.coulomb(HOT))
    x = simulated([truth], np.full((SAMPLES, 1), HOT), effort[:, None])[:, 0]
    speed = (x[SAMPLES // 2] - x[SAMPLES // 2 - 100]) / 0.1
    assert speed == pytest.approx((40.0 - truth.coulomb(HOT)) / truth.viscous(HOT), rel=1e-4)
    assert np.ptp(x[-5000:]) == 0.0


@cache
def drawn(
    seed: int, curved: bool, histories: Histories
) -> tuple[WarmAxis, Identification, FrictionOverTemperature]:
    """Return the axis of a seed, its identification and its law."""
    (axis,) = warm_axes([seed], curved, histories)
    return axis, *identified(axis)


@pytest.mark.parametrize(
    ("histories", "curved"), [(warming_up, True), (warming_up, False), (cold_and_hot, True)]
)
@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.accept)])
def test_friction_over_temperature_is_that_of_the_axis(
    histories: Histories, curved: bool, seed: int
) -> None:
    """Viscous friction halves from 30 to 80 degC; the curve is within 1.5 % at both ends."""
    axis, result, law = drawn(seed, curved, histories)
    assert [one.name for one in result.fit.explanations] == ["temperature"]
    at = law.reference.value
    for name in ("viscous", "coulomb"):
        interval, true = result.identified[name], getattr(axis.truth, name)
        assert interval.value == pytest.approx(true(at), rel=0.01)
        for end in (law.over.low, law.over.high):
            factors = dict(
                zip(
                    ("viscous", "coulomb"),
                    temperature_factors(law, np.array([end])),
                    strict=True,
                )
            )
            assert factors[name] * interval.value == pytest.approx(true(end), rel=0.015)
    assert result.fit.force_error < 0.01


@pytest.mark.parametrize(
    ("count", "least"), [(1, 6), pytest.param(6, 41, marks=pytest.mark.accept)]
)
def test_intervals_of_friction_and_its_change_contain_the_true_values(
    count: int, least: int
) -> None:
    """2 `count` axes with 4 intervals each: fewer than `least` once in 300 draws at 95 %."""
    held = []
    axes = [
        *warm_axes(range(20, 20 + count), True, warming_up),
        *warm_axes(range(count), True, cold_and_hot),
    ]
    for axis in axes:
        result, law = identified(axis)
        at = law.reference.value
        assert law.viscous is not None
        assert law.coulomb is not None
        truth = axis.truth
        held += [
            _contains(result.identified["viscous"], float(truth.viscous(at))),
            _contains(result.identified["coulomb"], float(truth.coulomb(at))),
            _contains(law.viscous.slope, np.log(0.5) / (HOT - COLD)),
            _contains(law.coulomb.slope, _relative_slope(axis, law)),
        ]
    assert sum(held) >= least


def _contains(interval: object, value: float) -> bool:
    return bool(interval.low <= value <= interval.high)  # type: ignore[attr-defined]


def _relative_slope(axis: WarmAxis, law: FrictionOverTemperature) -> float:
    """Return the mean slope of the logarithm of Coulomb friction from the reference outwards.

    Between a cold and a hot log, the exponential through both has this slope.
    """
    at, over = law.reference.value, law.over
    if axis.records[0].temperature is not None and len(axis.records) == 1:
        return float(-axis.truth.fall * axis.truth.coulomb_cold / axis.truth.coulomb(at))
    far = over.low if at - over.low > over.high - at else over.high
    return float(np.log(axis.truth.coulomb(far) / axis.truth.coulomb(at)) / (far - at))


def test_a_temperature_that_changes_nothing_leaves_the_intervals_and_is_stated() -> None:
    (axis,) = warm_axes([3], True, lambda _: [np.full(SAMPLES, 25.0)])
    plain = [replace(one, temperature=None) for one in axis.records]
    wave = 25.0 + 5.0 * np.sin(np.arange(SAMPLES) / 2000.0)
    warm = [
        replace(one, temperature=replace(one.temperature, values=wave))
        for one in axis.records
        if one.temperature is not None
    ]
    without = identify_records(plain, [], axis.bench, "auto", USUAL)
    result, law = identified(replace(axis, records=warm))
    assert without.laws is None
    assert law.viscous is None
    assert law.coulomb is None
    assert law.reference.value == pytest.approx(25.0, abs=1.0)
    assert temperature_lines(law)[0].endswith("no change with the temperature")
    for name in ("viscous", "coulomb"):
        assert result.identified[name].value == without.identified[name].value
        assert result.identified[name].half_width < 1.5 * without.identified[name].half_width


def test_without_its_temperature_a_warm_axis_has_wide_intervals() -> None:
    """The channel makes the intervals several times narrower, and both contain the truth."""
    (axis,) = warm_axes([4], True, warming_up)
    plain = [replace(one, temperature=None) for one in axis.records]
    without = identify_records(plain, [], axis.bench, "auto", USUAL)
    result, law = identified(axis)
    assert "warming" in [one.name for one in without.fit.explanations]
    true = float(axis.truth.viscous(law.reference.value))
    assert result.identified["viscous"].low <= true <= result.identified["viscous"].high
    assert 2.0 * result.identified["viscous"].half_width < without.identified["viscous"].half_width


def test_a_declared_temperature_is_fitted_by_a_requested_method() -> None:
    (axis,) = warm_axes([6], True, warming_up)
    bench = msgspec.structs.replace(axis.bench, load=LoadTerms(("offset", "temperature")))
    fit = run("least-squares", shaped(axis.records, bench), bench, USUAL)
    assert fit.laws is not None
    assert fit.laws.temperature is not None
    assert fit.laws.temperature.viscous is not None
    assert fit.laws.temperature.viscous.slope.value == pytest.approx(
        np.log(0.5) / (HOT - COLD), rel=0.05
    )
    values = {name: one.value for name, one in fit.parameters.items()}
    rows = motion_rows(axis.records, bench)
    cold = msgspec.structs.replace(fit.laws, temperature=None)
    assert force_error(rows, values, fit.laws) < 0.2 * force_error(rows, values, cold)


def test_a_declared_temperature_that_the_logs_lack_is_refused() -> None:
    (axis,) = warm_axes([7], True, lambda _: [np.full(SAMPLES, 40.0)])
    bench = msgspec.structs.replace(axis.bench, load=LoadTerms(("offset", "temperature")))
    (record,) = axis.records
    missing = replace(record, temperature=None)
    for records, reason in (
        ([record], r"varies by 0 K \(40 to 40 degC\), and the effect temperature needs 5 K"),
        ([missing], "warm_0 has no temperature, .* name its column under columns.temperature"),
    ):
        with pytest.raises(UnusableLogs, match=reason):
            identify_records(records, [], bench, "least-squares", USUAL)


def test_a_cold_and_a_hot_log_have_one_reference_that_was_measured() -> None:
    (axis,) = warm_axes([8], True, cold_and_hot)
    records = shaped(axis.records, axis.bench)
    signals = [one.temperature for one in records if one.temperature is not None]
    (reference,) = {one.reference for one in signals}
    assert min(float(np.abs(one.values - reference).min()) for one in signals) == 0.0
    assert signals[0].viscous_curvature == 0.0  # two temperatures show no curvature
    assert signals[0].viscous_rate == pytest.approx(np.log(0.5) / (HOT - COLD), rel=0.05)


def test_a_part_of_a_record_keeps_its_temperature_and_its_reference() -> None:
    (axis,) = warm_axes([9], True, warming_up)
    (record,) = axis.records
    part: MotionRecord = record.part(slice(1000, 3000))
    assert part.temperature is not None
    assert record.temperature is not None
    assert part.temperature.reference == record.temperature.reference
    assert part.temperature.values == pytest.approx(record.temperature.values[1000:3000])


def test_factors_are_1_at_the_reference_and_fall_by_the_same_ratio_per_kelvin() -> None:
    law = drawn(1, True, cold_and_hot)[2]
    steps = np.arange(20.0, 90.0, 5.0)
    viscous, coulomb = temperature_factors(law, steps)
    ratios = [after / before for before, after in pairwise(viscous)]
    assert ratios == pytest.approx([ratios[0]] * len(ratios))
    plain = FrictionOverTemperature(Quantity(30.0, unit="degC"), Span(20.0, 40.0, "degC"))
    assert np.all(np.array(temperature_factors(plain, steps)) == 1.0)
    at = np.array([law.reference.value])
    assert np.array(temperature_factors(law, at)).ravel() == pytest.approx([1.0, 1.0])
    assert coulomb[0] > coulomb[-1]
