"""Effects that a model lacks widen its intervals; those of a true model stay as they are."""

from __future__ import annotations

import re
from dataclasses import replace

import msgspec
import numpy as np
import pytest

from frictool.adapters.parameter_intervals import absolute
from frictool.documents.bench import Bench
from frictool.documents.load_terms import LoadTerms
from frictool.documents.quantity import Quantity
from frictool.identify.effect_regression import effect_regression
from frictool.identify.estimators.auto import auto
from frictool.identify.estimators.least_squares import least_squares
from frictool.identify.estimators.total_least_squares import total_least_squares
from frictool.identify.fit_result import SLIDING, SlidingFit
from frictool.identify.identification import identify_records
from frictool.identify.methods import DEFAULT, METHODS, IdentificationSettings
from frictool.identify.motion_record import MotionRecord, delayed, make_record
from frictool.identify.unmodelled_effects import SLOW_FRICTION, WidenedFit, widened
from frictool.typing import Vector
from studies.rigs.identification_rigs import record
from studies.rigs.sample_logs import sines
from tests.support.identification_statistics import experiment
from tests.support.loaded_axis import rotary_bench

INERTIA, VISCOUS, COULOMB, OFFSET = (1e-3, 0.01, 0.1, 0.02)
PERIOD = 1e-3


def effort_at(time: Vector) -> Vector:
    """Return the effort (n,) of the motion with two sines."""
    velocity = 16.0 * np.cos(4.0 * time) + 18.2 * np.cos(9.1 * time)
    acceleration = -64.0 * np.sin(4.0 * time) - 165.62 * np.sin(9.1 * time)
    moving = INERTIA * acceleration + VISCOUS * velocity + COULOMB * np.sign(velocity)
    return np.asarray(moving + OFFSET)


def axis(effect: Vector | float = 0.0, seed: int = 1) -> tuple[MotionRecord, Vector, Vector]:
    """Return a record of two sines with an additional effort, its time and its velocity."""
    time = np.arange(12_000) * PERIOD
    position = 4.0 * np.sin(4.0 * time) + 2.0 * np.sin(9.1 * time)
    velocity = 16.0 * np.cos(4.0 * time) + 18.2 * np.cos(9.1 * time)
    effort = effort_at(time)
    noise = np.random.default_rng(seed).normal(0.0, 3e-3, time.size)
    record = make_record("log", time, position, effort + effect + noise, resolution=1e-5, lag=1.0)
    return record, time, velocity


def both(record: MotionRecord, bench: Bench) -> tuple[SlidingFit, WidenedFit]:
    """Return the fit of least squares and the widened fit."""
    settings = IdentificationSettings()
    fit = least_squares([record], bench, settings)
    return fit, widened(fit, [record], bench, settings.confidence)


@pytest.fixture
def bench() -> Bench:
    return rotary_bench(None)


@pytest.mark.parametrize("axes", [3, pytest.param(8, marks=pytest.mark.accept)])
def test_the_intervals_of_a_true_model_stay_nearly_as_they_are(bench: Bench, axes: int) -> None:
    ratios = []
    for seed in range(axes):
        fit, result = both(axis(seed=seed)[0], bench)
        assert result.notes(result.fit.parameters) == ()
        ratios += [
            result.fit.parameters[name].half_width / fit.parameters[name].half_width
            for name in SLIDING
        ]
    assert min(ratios) >= 1.0
    assert float(np.median(ratios)) < 1.1


def test_a_lacking_effect_widens_the_interval_to_the_truth_and_is_named(bench: Bench) -> None:
    _, _, velocity = axis()
    effect = 0.03 * np.sign(velocity) * np.exp(-np.abs(velocity) / 3.0)
    fit, result = both(axis(effect)[0], bench)
    plain, wide = fit.parameters["coulomb"], result.fit.parameters["coulomb"]
    assert not plain.low <= COULOMB <= plain.high
    assert wide.low <= COULOMB <= wide.high
    # the end moves by the error that the effect causes, and not by a multiple of it
    assert wide.value - wide.low < 1.6 * (wide.value - COULOMB)
    assert wide.value == plain.value
    assert result.doubts(result.fit.parameters) == {}
    (note,) = result.notes(result.fit.parameters)
    assert result.notes({"coulomb": plain}) == ()
    assert "friction that falls with speed (" in note
    assert "coulomb" in note
    assert note.endswith("declare load.terms: [offset, stribeck]")


def test_a_refusal_names_the_effect_and_how_to_measure_it(bench: Bench) -> None:
    """The effect widens the interval of the Coulomb friction to the bench's range."""
    _, _, velocity = axis()
    record = axis(0.03 * np.sign(velocity) * np.exp(-np.abs(velocity) / 3.0))[0]
    known = Quantity(0.1, low=0.095, high=0.105, unit="N m")
    mechanics = msgspec.structs.replace(bench.mechanics, coulomb=known)
    narrow = msgspec.structs.replace(bench, mechanics=mechanics)
    result = identify_records([record], [], narrow, "least-squares", IdentificationSettings())
    reason = result.refused["coulomb"]
    assert "no narrower than the bench's range [0.095, 0.105]" in reason
    assert re.search(
        r"; perhaps friction that falls with speed makes the interval \d+(\.\d)? times", reason
    )
    (note,) = (one for one in result.notes if one.startswith("to identify coulomb: "))
    assert note.endswith("declare load.terms: [offset, stribeck]")


def test_friction_that_rises_less_than_in_proportion_to_speed_is_no_fall(bench: Bench) -> None:
    """The same columns fit a root of the speed; a Stribeck curve would not."""
    _, _, velocity = axis()
    result = both(axis(0.03 * np.sign(velocity) * np.abs(velocity) ** 0.5)[0], bench)[1]
    (note,) = result.notes(result.fit.parameters)
    assert "friction that rises less than in proportion to speed (" in note
    assert "stribeck" not in note
    slow = result.fit.details[SLOW_FRICTION]
    assert COULOMB < slow < result.fit.parameters["coulomb"].value


def test_under_a_load_no_stribeck_curve_is_advised(bench: Bench) -> None:
    _, _, velocity = axis()
    fall = 0.03 * np.sign(velocity) * np.exp(-np.abs(velocity) / 3.0)
    loaded = msgspec.structs.replace(bench, load=LoadTerms(("offset", "spring")))
    result = both(axis(fall)[0], loaded)[1]
    (note,) = result.notes(result.fit.parameters)
    assert note.endswith("add stribeck to load.terms")


@pytest.mark.parametrize(("falling", "warned"), [(0.1, False), (0.3, True)])
def test_an_effect_beyond_the_interval_is_a_warning(
    bench: Bench, falling: float, warned: bool
) -> None:
    """The intervals include a fall of friction only up to a fifth of the rms effort."""
    _, _, velocity = axis()
    effect = falling * np.sign(velocity) * np.exp(-((velocity / 12.0) ** 2))
    result = both(axis(effect)[0], bench)[1]
    wide = result.fit.parameters["coulomb"]
    assert (wide.low <= COULOMB <= wide.high) is not warned
    assert len(result.notes(result.fit.parameters)) == 1
    doubts = result.doubts(result.fit.parameters)
    assert ("coulomb" in doubts) is warned
    assert all("friction that still falls" in text for (text,) in doubts.values())


def coarse_record(step: float, stiffness: float, seed: int) -> MotionRecord:
    """Return a record of two sines with a spring, from an encoder with counts of `step` rad."""
    time = np.arange(12_000) * PERIOD
    position = 4.0 * np.sin(4.0 * time) + 2.0 * np.sin(9.1 * time)
    effort = effort_at(time) + stiffness * position
    effort += np.random.default_rng(seed).normal(0.0, 3e-3, time.size)
    counts = np.round(position / step) * step
    return make_record("log", time, counts, effort, resolution=step, lag=1.0)


def test_a_lacking_spring_widens_the_inertia_of_a_coarse_encoder(bench: Bench) -> None:
    """Noise attenuates this inertia by 0.05 %, and the spring changes it by 7 %."""
    record = coarse_record(0.01, 0.004, seed=0)
    fit, result = both(record, bench)
    regression = effect_regression(fit, [record], bench, 0.95)
    assert regression is not None
    assert regression.noisy
    plain, wide = fit.parameters["inertia"], result.fit.parameters["inertia"]
    assert plain.high < INERTIA
    assert wide.low <= INERTIA <= wide.high


def test_a_coarse_encoder_alone_hardly_widens_the_inertia(bench: Bench) -> None:
    for seed in range(3):
        _, result = both(coarse_record(0.01, 0.0, seed), bench)
        inertia = result.fit.parameters["inertia"]
        assert inertia.low <= INERTIA <= inertia.high
        assert inertia.half_width < 0.005 * INERTIA


def test_noise_that_short_strokes_hardly_smooth_raises_the_end_of_the_inertia(bench: Bench) -> None:
    """The window is a sixth of a stroke, so that white noise decreases the inertia by 0.35 %."""
    time = np.arange(2_400) * 5.0 * PERIOD
    position = 4.0 * np.sin(4.0 * time) + 2.0 * np.sin(9.1 * time)
    for seed in range(4):
        draw = np.random.default_rng(seed)
        effort = effort_at(time) + draw.normal(0.0, 1e-3, time.size)
        noisy = position + draw.normal(0.0, 4e-3, time.size)
        record = make_record("log", time, noisy, effort, resolution=1e-6, lag=1.0)
        fit, result = both(record, bench)
        plain, wide = fit.parameters["inertia"], result.fit.parameters["inertia"]
        assert fit.attenuation == pytest.approx(1.0 - plain.value / INERTIA, rel=0.5)
        assert plain.high < INERTIA <= wide.high
        unbiased = total_least_squares([record], bench, IdentificationSettings())
        assert unbiased.attenuation == 0.0


def test_a_fall_wider_than_its_columns_widens_viscous_and_coulomb(bench: Bench) -> None:
    """The columns of the Stribeck fall end at 20 % of the top speed; this fall has 30 %."""
    _, _, velocity = axis()
    fall = 0.03 * np.sign(velocity) * np.exp(-((velocity / (0.3 * 34.0)) ** 2))
    record = axis(fall)[0]
    used = LoadTerms(("offset", "stribeck"))
    declared = msgspec.structs.replace(bench, load=used)
    fit = replace(least_squares([record], declared, IdentificationSettings()), load=used)
    wide = widened(fit, [record], bench, 0.95).fit.parameters
    for name, truth in (("viscous", VISCOUS), ("coulomb", COULOMB)):
        plain = fit.parameters[name]
        assert not plain.low <= truth <= plain.high
        assert wide[name].low <= truth <= wide[name].high


def test_a_ripple_longer_than_the_strokes_widens_the_interval_of_the_inertia(bench: Bench) -> None:
    """A spring and gravity do not have the curvature of this ripple."""
    time = np.arange(6000) * PERIOD
    position = 3.0 * np.sin(6.0 * time) + 0.3 * np.sin(15.0 * time)
    velocity = 18.0 * np.cos(6.0 * time) + 4.5 * np.cos(15.0 * time)
    acceleration = -108.0 * np.sin(6.0 * time) - 67.5 * np.sin(15.0 * time)
    effort = INERTIA * acceleration + VISCOUS * velocity + COULOMB * np.sign(velocity) + OFFSET
    effort += 0.1 * COULOMB * np.sin(2.0 * np.pi / 10.0 * position + 0.3)
    effort += np.random.default_rng(5).normal(0.0, 3e-3, time.size)
    record = make_record("log", time, position, effort, resolution=1e-5, lag=1.0)
    fit, result = both(record, bench)
    plain, wide = fit.parameters["inertia"], result.fit.parameters["inertia"]
    assert not plain.low <= INERTIA <= plain.high
    assert wide.low <= INERTIA <= wide.high
    (note,) = result.notes(result.fit.parameters)
    assert "a load over the position" in note
    declared = msgspec.structs.replace(bench, load=LoadTerms(("offset", "load_over_position")))
    known = least_squares([record], declared, IdentificationSettings()).parameters["inertia"]
    assert known.low <= INERTIA <= known.high


@pytest.mark.parametrize(
    ("logs", "least"), [(5, 4), pytest.param(12, 10, marks=pytest.mark.accept)]
)
def test_the_intervals_include_a_delay_that_is_too_small_to_be_found(
    bench: Bench, logs: int, least: int
) -> None:
    """The current is read 0.6 of a sample late; without this uncertainty 8 of 12 intervals hold."""
    time = np.arange(3000) * PERIOD
    position = 4.0 * np.sin(4.0 * time) + 2.0 * np.sin(9.1 * time)
    held = 0
    for seed in range(logs):
        noise = np.random.default_rng(seed).normal(0.0, 2e-3, time.size)
        effort = effort_at(time - 0.6 * PERIOD) + noise
        record = make_record("log", time, position, effort, resolution=1e-5, lag=1.0)
        fit, result = both(record, bench)
        assert fit.effects == {}
        inertia = result.fit.parameters["inertia"]
        held += inertia.low <= INERTIA <= inertia.high
    assert held >= least


def delayed_record(samples: float, noise: float) -> MotionRecord:
    """Return a record whose effort is read `samples` samples late, with noise of rms `noise`."""
    time = np.arange(3000) * PERIOD
    position = 4.0 * np.sin(4.0 * time) + 2.0 * np.sin(9.1 * time)
    effort = effort_at(time - samples * PERIOD)
    effort += np.random.default_rng(3).normal(0.0, noise, time.size)
    return make_record("log", time, position, effort, resolution=1e-5, lag=1.0)


def test_a_delay_within_the_prior_is_weighted_by_both_variances(bench: Bench) -> None:
    record = delayed_record(0.6, 8e-3)
    fit = least_squares([record], bench, IdentificationSettings())
    regression = effect_regression(fit, [record], bench, 0.95)
    assert regression is not None
    free, known = (regression.timing(one, regression) for one in (1.0, 0.1 * PERIOD))
    assert free is not None
    assert known is not None
    weight = known.shift["inertia"] / free.shift["inertia"]
    assert 0.3 < weight < 0.95
    # posterior: weight times the estimate, and the square root of the weight times its half width
    for name in SLIDING:
        assert known.shift[name] == pytest.approx(weight * free.shift[name], rel=1e-3)
        assert known.scatter[name] == pytest.approx(weight**0.5 * free.scatter[name], rel=1e-3)


def test_a_delay_longer_than_the_prior_counts_as_the_regression_finds_it(bench: Bench) -> None:
    record = delayed_record(2.0, 2e-3)
    fit = least_squares([record], bench, IdentificationSettings())
    regression = effect_regression(fit, [record], bench, 0.95)
    assert regression is not None
    timing = regression.timing(0.5 * PERIOD, regression)
    assert timing is not None
    inertia = fit.parameters["inertia"].value
    assert inertia == pytest.approx(INERTIA, rel=0.05)
    error = inertia + timing.shift["inertia"] - INERTIA
    assert abs(error) < 0.25 * abs(timing.shift["inertia"])
    assert timing.scatter["inertia"] < 0.25 * abs(timing.shift["inertia"])


def test_a_delay_of_half_a_sample_widens_the_inertia_of_the_weak_form() -> None:
    """The coarse encoder hides the inertia from the regression, and the delay changes it."""
    truth, bench = experiment(1)
    log = record(sines(1, truth), truth)
    late = delayed(log, 0.5 * log.period)
    result = identify_records([late], [], bench, DEFAULT, IdentificationSettings())
    inertia = result.identified["inertia"]
    assert abs(inertia.value / truth.inertia - 1.0) > 0.01
    assert inertia.low <= truth.inertia <= inertia.high


def test_means_over_strokes_include_the_lag_of_the_current(bench: Bench) -> None:
    """Means over strokes react to a lag otherwise than the regression."""
    time = np.arange(24_000) * PERIOD
    position = 4.0 * np.sin(4.0 * time) + 2.0 * np.sin(9.1 * time)
    noise = np.random.default_rng(1).normal(0.0, 2e-3, time.size)
    command = effort_at(time + 3.0 * PERIOD) + noise
    record = make_record("log", time, position, command, resolution=1e-3, lag=1.0)
    known = Quantity(INERTIA, 0.9 * INERTIA, 1.1 * INERTIA, "kg m^2")
    mechanics = msgspec.structs.replace(bench.mechanics, inertia=known)
    bench = msgspec.structs.replace(bench, mechanics=mechanics)
    settings = IdentificationSettings()
    fit = replace(METHODS["sines"].estimate([record], bench, settings), method="sines")
    plain = fit.parameters["coulomb"]
    wide = widened(fit, [record], bench, settings.confidence).fit.parameters["coulomb"]
    assert not plain.low <= COULOMB <= plain.high
    assert wide.low <= COULOMB <= wide.high


def test_the_longest_windows_show_that_a_resonance_is_no_small_term(bench: Bench) -> None:
    """The window is shorter than the period of the resonance, which the motion excites."""
    time = np.arange(12_000) * PERIOD
    behind, stiffness = 0.4 * INERTIA, 0.4 * INERTIA * (2.0 * np.pi * 25.0) ** 2
    terms = [(4.0, 4.0, 0.3), (2.0, 9.1, 0.0), (2e-4, 190.0, 1.0)]
    motion = np.zeros((3, time.size))  # position of the motor, its velocity, effort of inertia
    for size, rate, phase in terms:
        gain = 1.0 - behind * rate**2 / stiffness
        wave = size * np.sin(rate * time + phase)
        motion[0] += gain * wave
        motion[1] += gain * size * rate * np.cos(rate * time + phase)
        motion[2] -= rate**2 * wave * (0.6 * INERTIA * gain + behind)
    effort = motion[2] + VISCOUS * motion[1] + COULOMB * np.sign(motion[1]) + OFFSET
    noise = np.random.default_rng(4).normal(0.0, 3e-4, time.size)
    record = make_record("log", time, motion[0], effort + noise, resolution=1e-5, lag=1.0)
    declared = msgspec.structs.replace(bench, load=LoadTerms(("offset", "resonance")))
    settings = IdentificationSettings()
    fit = least_squares([record], declared, settings)
    plain = fit.parameters["inertia"]
    wide = widened(fit, [record], declared, settings.confidence).fit.parameters["inertia"]
    error = plain.value - INERTIA
    assert error > 10.0 * plain.half_width
    assert wide.low - INERTIA < 0.1 * error
    assert wide.half_width < error


def test_an_eccentric_encoder_over_half_a_turn_widens_by_its_local_gain(bench: Bench) -> None:
    time = np.arange(12_000) * PERIOD
    position = 0.3 * np.sin(4.0 * time) + 0.2 * np.sin(9.1 * time)
    velocity = 1.2 * np.cos(4.0 * time) + 1.82 * np.cos(9.1 * time)
    acceleration = -4.8 * np.sin(4.0 * time) - 16.562 * np.sin(9.1 * time)
    effort = 0.01 * acceleration + VISCOUS * velocity + COULOMB * np.sign(velocity) + OFFSET
    effort += np.random.default_rng(1).normal(0.0, 2e-3, time.size)
    seen = position + 4e-3 * np.sin(position + 0.4)
    record = make_record("log", time, seen, effort, resolution=1e-6, lag=1.0)
    fit, result = both(record, bench)
    regression = effect_regression(fit, [record], bench, 0.95)
    assert regression is not None
    for known in (1e-3, 5e-3):
        gain = regression.encoder_gain(known)
        assert gain is not None
        assert set(gain.shift) == {"inertia", "viscous"}
        for name, shift in gain.shift.items():
            assert abs(shift) <= (1.0 + 1e-9) * known * abs(fit.parameters[name].value)
    inertia = result.fit.parameters["inertia"]
    assert inertia.low <= 0.01 <= inertia.high


@pytest.mark.parametrize("seed", [1, 4])
def test_an_eccentricity_that_no_encoder_has_does_not_widen(bench: Bench, seed: int) -> None:
    """Over 0.1 rad, a wrong gain of the encoder looks like any change of viscous friction.

    Here, friction over position looks like a gain that is wrong by a half.
    """
    time = np.arange(12_000) * PERIOD
    position = 0.03 * np.sin(4.0 * time) + 0.02 * np.sin(9.1 * time)
    velocity = 0.12 * np.cos(4.0 * time) + 0.182 * np.cos(9.1 * time)
    acceleration = -0.48 * np.sin(4.0 * time) - 1.6562 * np.sin(9.1 * time)
    phase = np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi)
    coulomb = COULOMB * (1.0 + 0.05 * np.cos(100.0 * position + phase))
    effort = 0.1 * acceleration + 0.5 * velocity + coulomb * np.sign(velocity)
    effort += np.random.default_rng(1).normal(0.0, 2e-3, time.size)
    record = make_record("log", time, position, effort, resolution=1e-6, lag=1.0)
    fit, _ = both(record, bench)
    regression = effect_regression(fit, [record], bench, 0.95)
    assert regression is not None
    eccentric = [one for one in regression.accepted() if one.what == ("an eccentric encoder",)]
    assert len(eccentric) == 1
    for name in ("inertia", "viscous"):
        assert abs(eccentric[0].shift[name]) <= 0.0501 * fit.parameters[name].value


def test_an_effect_that_was_removed_widens_nothing(bench: Bench) -> None:
    """`auto` removes a drift of the offset, which a fit without it would count as uncertainty."""
    _, time, _ = axis()
    record = axis(0.008 * (time - 6.0))[0]
    settings = IdentificationSettings()
    fit = auto([record], bench, settings)
    assert [one.name for one in fit.explanations if one.state == "used"] == ["drift"]
    result = widened(fit, [record], bench, settings.confidence)
    plain, wide = fit.parameters["offset"], result.fit.parameters["offset"]
    assert wide.half_width < 1.5 * plain.half_width
    assert result.notes(result.fit.parameters) == ()
    left = both(record, bench)[1].fit.parameters["offset"]
    assert left.half_width > 3.0 * wide.half_width


def test_no_end_moves_beyond_the_interval_of_the_bench(bench: Bench) -> None:
    _, _, velocity = axis()
    record = axis(0.03 * np.sign(velocity) * np.exp(-np.abs(velocity) / 3.0))[0]
    free = both(record, bench)[1].fit.parameters["coulomb"]
    lowest = 0.5 * (free.low + free.value)
    known = Quantity(COULOMB, lowest, 2.0 * COULOMB, "N m")
    mechanics = msgspec.structs.replace(bench.mechanics, coulomb=known)
    cut = both(record, msgspec.structs.replace(bench, mechanics=mechanics))[1]
    assert cut.fit.parameters["coulomb"].low == pytest.approx(lowest)
    assert cut.doubts(cut.fit.parameters) == {}


def test_an_absolute_interval_holds_every_constant() -> None:
    constant = Quantity(2.0, 1.8, 2.4, "N m/A")
    assert absolute(1.0, 3.0, constant) == pytest.approx((0.9, 3.6))
    assert absolute(-1.0, 3.0, constant) == pytest.approx((-1.2, 3.6))
    assert absolute(1.0, 3.0, Quantity(2.0, unit="N m/A")) == (1.0, 3.0)
