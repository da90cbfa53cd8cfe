"""From logs to a model: what is refused and why, what the model carries instead, and intervals that
cover."""

from __future__ import annotations

import math
from dataclasses import replace

import msgspec
import numpy as np
import pytest

from frictool.documents.provenance import Provenance
from frictool.documents.quantity import Quantity
from frictool.errors import LogError
from frictool.identify.fit_result import PARAMETERS, SLIDING, Interval
from frictool.identify.identification import (
    Identification,
    NothingIdentified,
    identify_records,
)
from frictool.identify.interval_checks import why_uninformative
from frictool.identify.methods import DEFAULT, METHODS, IdentificationSettings
from frictool.identify.model_document import model_of
from frictool.identify.motion_record import MotionRecord, make_record, record_of
from frictool.identify.text_view import parameter_lines
from frictool.identify.unmodelled_effects import SLOW_FRICTION
from frictool.logs.log import Log, Stream
from studies.rigs.identification_rigs import clutch, record
from studies.rigs.sample_logs import TRUTH, ramp, sines
from tests.support.identification_statistics import covered, experiment


def test_differentiation_gives_all_but_inertia() -> None:
    coarse = TRUTH._replace(encoder_step=16.0 * TRUTH.encoder_step)
    result = identify_records(
        [record(sines(1, coarse), coarse, name="a"), record(ramp(1), name="b")],
        [],
        clutch(),
        "least-squares",
        IdentificationSettings(),
    )
    assert result.kinds == {"a": "sliding", "b": "ramp"}
    assert list(result.identified) == ["viscous", "coulomb", "offset", "breakaway"]
    assert set(result.refused) == {"inertia"}
    model = model_of(result, clutch(), Provenance("test", "0"))
    assert model.parameters.inertia == msgspec.structs.replace(
        model.parameters.inertia, value=1.32e-5, low=1.11e-5, high=1.53e-5
    )
    assert model.parameters.inertia.source == "bench"
    assert model.parameters.breakaway.source == "identified"
    assert model.not_identified == result.refused
    assert model.bench == clutch()


@pytest.fixture(scope="module")
def of_strokes() -> Identification:
    """Return what a log of strokes alone gives."""
    return identify_records([record(sines(1))], [], clutch(), DEFAULT, IdentificationSettings())


def test_without_a_ramp_the_breakaway_is_what_coulomb_lets_expect(
    of_strokes: Identification,
) -> None:
    assert "no log of breakaway ramps" in of_strokes.refused["breakaway"]
    model = model_of(of_strokes, clutch(), Provenance("test", "0"))
    coulomb, breakaway = model.parameters.coulomb, model.parameters.breakaway
    assert breakaway.source == "assumed"
    assert breakaway.interval == (coulomb.interval[0], 1.5 * coulomb.interval[1])
    assert breakaway.interval[0] <= TRUTH.breakaway <= breakaway.interval[1]
    _, *rows, note = parameter_lines(model)
    low, high = breakaway.interval
    assert f"{low:.5g} to {high:.5g} N m, which is no interval at 95 %" in note
    assert f"[{low:.5g}, {high:.5g}]" not in next(row for row in rows if "assumed" in row)


def test_friction_below_the_fitted_line_lets_the_breakaway_be_lower(
    of_strokes: Identification,
) -> None:
    """The range begins below the friction at low speed, by the uncertainty of the line."""
    assert of_strokes.fit is not None
    coulomb = of_strokes.identified["coulomb"]
    slow = 0.8 * coulomb.low
    fit = replace(of_strokes.fit, details={**of_strokes.fit.details, SLOW_FRICTION: slow})
    model = model_of(replace(of_strokes, fit=fit), clutch(), Provenance("test", "0"))
    low = model.parameters.breakaway.interval[0]
    assert low == pytest.approx(slow - (coulomb.value - coulomb.low))


def test_a_ramp_alone_gives_the_breakaway_alone() -> None:
    result = identify_records([], [record(ramp(1))], clutch(), DEFAULT, IdentificationSettings())
    assert list(result.identified) == ["breakaway"]
    assert (
        result.identified["breakaway"].low < TRUTH.breakaway < result.identified["breakaway"].high
    )
    model = model_of(result, clutch(), Provenance("test", "0"))
    sources = {name: getattr(model.parameters, name).source for name in PARAMETERS}
    assert sources == {
        "inertia": "bench",
        "viscous": "bench",
        "coulomb": "bench",
        "offset": "assumed",
        "breakaway": "identified",
    }
    assert (
        model.parameters.offset.value,
        model.parameters.offset.low,
        model.parameters.offset.high,
    ) == (0.0, None, None)


def test_a_ramp_in_one_direction_needs_an_offset_that_someone_knows() -> None:
    log = record(ramp(1))
    first = int(np.argmax(log.position))
    one_way = replace(
        log,
        **{name: getattr(log, name)[:first] for name in ("time", "position", "effort", "piece")},
    )
    with pytest.raises(NothingIdentified, match="0 backward, and no known offset"):
        identify_records([], [one_way], clutch(), DEFAULT, IdentificationSettings())
    both = identify_records(
        [record(sines(1))], [one_way], clutch(), "least-squares", IdentificationSettings()
    )
    assert both.identified["breakaway"].low <= TRUTH.breakaway <= both.identified["breakaway"].high


def test_an_offset_and_a_breakaway_that_the_bench_gives_are_the_benchs() -> None:
    known = {
        "offset": Quantity(0.01, -0.02, 0.03, "N m"),
        "breakaway": Quantity(0.12, 0.1, 0.2, "N m"),
    }
    bench = clutch()
    bench = msgspec.structs.replace(
        bench, mechanics=msgspec.structs.replace(bench.mechanics, **known)
    )
    nothing = Identification(method=DEFAULT, confidence=0.95, kinds={})
    model = model_of(nothing, bench, Provenance("test", "0"))
    for name, quantity in known.items():
        estimate = getattr(model.parameters, name)
        assert (estimate.value, estimate.interval, estimate.source) == (
            quantity.value,
            quantity.interval,
            "bench",
        )


def test_nothing_usable_is_the_answer_no() -> None:
    still = make_record(
        "still", np.arange(3000) * 1e-3, np.zeros(3000), np.zeros(3000), TRUTH.encoder_step, 0.003
    )
    with pytest.raises(NothingIdentified, match="never moves by more than one") as raised:
        identify_records([still], [], clutch(), DEFAULT, IdentificationSettings())
    assert raised.value.exit_code == 1
    assert raised.value.result.identified == {}
    assert set(raised.value.result.refused) == set(PARAMETERS)


def noisy(seed: int) -> MotionRecord:
    """Sines whose current is noise of 5 A and nothing else."""
    log = record(sines(seed)).part(slice(0, 10_000))
    noise = TRUTH.constant * 5.0 * np.random.default_rng(seed).standard_normal(log.effort.size)
    return replace(log, effort=noise, reference=log.position)


# they ask for another test first, or simulate for long
OWN_TESTS = {"stribeck-curve", "friction-force", "output-error"}
QUICK = ("auto", "least-squares", "weak", "sines", "inverse-dynamic")


@pytest.mark.parametrize(
    "method",
    [
        name if name in QUICK else pytest.param(name, marks=pytest.mark.accept)
        for name in METHODS
        if name not in OWN_TESTS
    ],
)
def test_a_fit_that_explains_nothing_is_refused(method: str) -> None:
    bench = clutch()
    bench = msgspec.structs.replace(
        bench, mechanics=msgspec.structs.replace(bench.mechanics, backlash=None)
    )
    with pytest.raises(NothingIdentified) as raised:
        identify_records([noisy(2)], [], bench, method, IdentificationSettings())
    for name in SLIDING:
        assert (
            "the model does not explain the effort: force error"
            in raised.value.result.refused[name]
        )
        assert "(allowed: at most 50 %)" in raised.value.result.refused[name]


def test_a_noisy_current_that_still_explains_is_identified() -> None:
    log = record(sines(2))
    noise = TRUTH.constant * 5.0 * np.random.default_rng(2).standard_normal(log.effort.size)
    noisy_log = replace(log, effort=log.effort + noise)
    result = identify_records([noisy_log], [], clutch(), "least-squares", IdentificationSettings())
    assert result.identified["coulomb"].low <= TRUTH.coulomb <= result.identified["coulomb"].high


def test_an_interval_outside_the_benchs_is_a_warning(of_strokes: Identification) -> None:
    bench = clutch()
    assert of_strokes.warnings == ()
    known = msgspec.structs.replace(bench.mechanics, coulomb=Quantity(0.2, 0.15, 0.25, "N m"))
    result = identify_records(
        [record(sines(1))],
        [],
        msgspec.structs.replace(bench, mechanics=known),
        DEFAULT,
        IdentificationSettings(),
    )
    assert "coulomb" in result.identified
    (warning,) = result.warnings
    assert warning.startswith("coulomb: the log's interval [0.09")
    assert "lies wholly outside the bench's [0.15, 0.25]; the log's value is used" in warning


def test_a_fit_that_leaves_much_of_the_effort_says_so() -> None:
    """Differences on a coarse encoder (table 4.6): the intervals do not know what the encoder has
    done to the regressors."""
    found = identify_records(
        [record(sines(1))], [], clutch(), "ordinary", IdentificationSettings(time_constant=1.5e-3)
    )
    assert found.fit is not None
    assert 0.2 < found.fit.residual < 0.5
    warning, force, position = found.warnings
    worse = "ordinary predicts strokes left out of the fit worse than least-squares: the "
    assert force.startswith(f"{worse}force error is ")
    assert position.startswith(f"{worse}rms error of the simulated position is ")
    assert warning.startswith(
        f"residual of the method's equations {100 * found.fit.residual:.3g} %, above 20 %: "
    )


def test_a_log_given_twice_is_refused() -> None:
    one, other = record(sines(1), name="a.csv"), record(sines(2), name="b.csv")
    again = replace(one, name="c.mcap", effort=one.effort * (1.0 + 1e-15))
    for logs, ramps in (([one, other, again], []), ([one], [again])):
        with pytest.raises(
            LogError, match=r"c\.mcap: is the same log as a\.csv; give each log once"
        ):
            identify_records(logs, ramps, clutch(), "least-squares", IdentificationSettings())
    accepted = identify_records(
        [one, other], [], clutch(), "least-squares", IdentificationSettings()
    )
    assert accepted.fit is not None


@pytest.mark.parametrize(
    ("name", "interval", "known", "words"),
    [
        ("viscous", Interval(-1.0, -2.0, 0.5), None, "negative"),
        ("inertia", Interval(1.0, -0.5, 2.5), None, "reaches zero"),
        ("coulomb", Interval(1.0, -math.inf, math.inf), None, "repeat"),
        ("offset", Interval(1.0, 0.0, 2.0), Quantity(1.0, 0.5, 1.5), "no narrower"),
        ("offset", Interval(1.0, 0.0, 2.0), Quantity(2.1, 2.0, 2.2), "no narrower"),
        ("offset", Interval(1.0, 0.0, 2.0), Quantity(2.2, 2.1, 2.3), None),
        ("viscous", Interval(1.0, 0.1, 2.0), Quantity(2.2, 2.1, 2.3), "spans a factor of 20"),
        ("offset", Interval(-1.0, -1.5, -0.5), Quantity(0.0, -6.0, 6.0), None),
        ("viscous", Interval(0.1, -0.1, 0.3), Quantity(0.5), None),
    ],
)
def test_what_is_of_no_use(
    name: str, interval: Interval, known: Quantity | None, words: str | None
) -> None:
    reason = why_uninformative(name, interval, known)
    assert (reason is None) == (words is None)
    assert words is None or words in str(reason)


def test_effort_comes_from_the_drive_or_is_measured() -> None:
    time = np.arange(10) * 1e-3
    stream = Stream("/axis", time, {"position": time, "current": np.full(10, 2.0)}, {})
    assert record_of(Log((stream,)), clutch()).effort == pytest.approx(2.0 * 13.4e-3)
    measured = Stream("/axis", time, {"position": time, "effort": np.full(10, 0.3)}, {})
    assert record_of(Log((measured,)), clutch()).effort == pytest.approx(0.3)
    with pytest.raises(LogError, match="no current"):
        record_of(Log((Stream("/axis", time, {"position": time}, {}),)), clutch())


def test_a_clock_that_is_none_is_refused() -> None:
    time = np.sort(np.random.default_rng(1).random(100))
    with pytest.raises(LogError, match="resample"):
        make_record("jitter", time, time, time, 1e-3, 0.0)


def test_intervals_cover_the_truth_of_a_drawn_axis() -> None:
    """Two of three intervals and that of the inertia; `make accept` counts those of 400 seeds."""
    hits = covered(0)
    assert sum(hits[name] for name in ("viscous", "coulomb", "offset")) >= 2
    assert hits["inertia"]
    assert experiment(0)[0].inertia != experiment(1)[0].inertia


def test_every_method_says_when_it_is_right() -> None:
    assert DEFAULT in METHODS
    assert all(method.what and method.when for method in METHODS.values())
