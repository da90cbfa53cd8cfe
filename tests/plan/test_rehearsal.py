"""Rehearsals: the bound of a half width, tests that keep it on other axes, and refusals."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
import pytest
from msgspec import structs
from scipy.special import ndtr

from frictool.documents.bench import Bench
from frictool.documents.load_terms import LoadTerms
from frictool.documents.quantity import Quantity, si_unit
from frictool.errors import NoSolutionError
from frictool.identify.excite.breakaway_ramps import effort_rate
from frictool.identify.excite.excitation_kinds import ExcitationSettings, excite
from frictool.identify.excite.precise_ramps import precise_ramps
from frictool.identify.excite.precise_strokes import (
    PreciseTest,
    PrecisionRequest,
    bench_value,
    precise_strokes,
)
from frictool.plan import rehearsed_test
from frictool.plan.rehearsal import (
    CONFIRMED_SPREAD,
    REHEARSALS,
    HalfWidthSample,
    least_bound,
    rehearse,
)
from frictool.plan.rehearsed_test import (
    COMMON,
    CONFIRMATIONS,
    DEFAULT_KIND,
    HOPELESS,
    LONGER,
    NOTICEABLE,
    SHORTER,
    STALLS,
    DesignRounds,
    RehearsedTests,
    rehearsed_ramps,
    rehearsed_strokes,
)
from studies.promises.rigs import benches
from studies.promises.trial import trial

WANTED = {"inertia": 0.02, "coulomb": 0.02}


def rig(name: str) -> Bench:
    return next(one for one in benches() if one.name == name)


@pytest.fixture(scope="module")
def belt() -> tuple[Bench, PreciseTest]:
    bench = rig("belt")
    return bench, rehearsed_strokes(bench, PrecisionRequest(WANTED))


def test_upper_bound_holds_97_of_100_in_nine_of_ten_samples() -> None:
    generator = np.random.default_rng(5)
    spread = 0.3
    covered = []
    for _ in range(2000):
        widths = np.exp(spread * generator.standard_normal(REHEARSALS))
        upper = HalfWidthSample(tuple(widths.tolist()), ()).upper
        assert upper >= widths.max()
        covered.append(float(ndtr(math.log(upper) / spread)))
    assert np.mean(np.array(covered) >= 0.97) == pytest.approx(0.9, abs=0.03)


@pytest.mark.parametrize("total", [REHEARSALS, 3 * REHEARSALS])
def test_no_further_half_widths_give_less_than_the_least_bound(total: int) -> None:
    """m + c s over all half widths is least if the free logarithms are equal."""
    generator = np.random.default_rng(7)
    for known in range(3, total + 1):
        widths = np.exp(0.4 * generator.standard_normal(known))
        least = least_bound(widths.tolist(), total)
        logarithms = np.log(widths)
        bounds = []
        for common in np.linspace(-3.0, 1.0, 4001):
            whole = np.append(logarithms, np.full(total - known, common))
            bounds.append(whole.mean() + CONFIRMED_SPREAD * whole.std(ddof=1))
        assert math.log(least) == pytest.approx(min(bounds), abs=1e-5)
        for _ in range(50):
            whole = np.append(logarithms, 0.4 * generator.standard_normal(total - known) - 0.2)
            bound = whole.mean() + CONFIRMED_SPREAD * whole.std(ddof=1)
            assert bound >= math.log(least) - 1e-12


def test_rehearsals_end_when_no_further_half_width_can_keep_the_limit(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """All half widths keep the limit of 1, but they differ so much that their bound does not."""
    bench = rig("belt")
    widths = [0.95, 0.3, 0.9, 0.25, 0.8, 0.9, 0.7, 0.9]
    played: list[float] = []

    def rehearsed(*_: Any) -> tuple[dict[str, float], dict[str, str]]:
        played.append(widths[len(played)])
        return {"inertia": played[-1]}, {}

    monkeypatch.setattr("frictool.plan.rehearsal._rehearsed", rehearsed)
    sequence = precise_strokes(bench, PrecisionRequest(WANTED)).sequence
    sample = rehearse(sequence, bench, {"inertia": 1.0})["inertia"]
    assert 2 <= len(sample.widths) < REHEARSALS
    assert sample.exceeded
    assert sample.upper > 1.0
    assert HalfWidthSample(tuple(widths), ()).likely > 1.0
    played.clear()
    every = rehearse(sequence, bench, {"inertia": math.inf})["inertia"]
    assert every.widths == tuple(widths)
    assert not every.exceeded


def test_a_refused_parameter_has_no_bound() -> None:
    assert HalfWidthSample((1.0, 1.0), ("no motion",)).upper == math.inf
    assert HalfWidthSample((), ("no motion",)).upper == math.inf


@pytest.mark.accept
def test_a_rehearsed_test_keeps_its_promise_on_other_axes(
    belt: tuple[Bench, PreciseTest],
) -> None:
    """tests/accept/check_promises.py counts the promises that are kept on ten rigs."""
    seeds = 8
    bench, test = belt
    for name, part in WANTED.items():
        assert 0.0 < test.half_widths[name] <= part * getattr(bench.mechanics, name).value
        assert test.sequence.figures[f"promised_{name}"] == test.half_widths[name]
    rows = [row for seed in range(seeds) for row in trial(bench, test, seed)]
    kept = [row for row in rows if row.half_width is not None and row.half_width <= row.promised]
    assert len(rows) == 2 * seeds
    assert len(kept) >= len(rows) - 1


@pytest.mark.accept
def test_the_best_test_of_a_duration_promises_what_its_rehearsals_reach(
    belt: tuple[Bench, PreciseTest], monkeypatch: pytest.MonkeyPatch
) -> None:
    bench, _ = belt
    monkeypatch.setattr("frictool.plan.rehearsal.REHEARSALS", 2)
    test = rehearsed_strokes(bench, PrecisionRequest(WANTED, duration=4.0))
    assert test.sequence.duration == pytest.approx(4.0, rel=0.05)
    first, *others = (
        rehearse(test.sequence, bench, dict.fromkeys(WANTED, math.inf), seeds=(seed,))
        for seed in range(1 + CONFIRMATIONS)
    )
    for other in others:
        first = {name: one.joined(other[name]) for name, one in first.items()}
    upper = {name: one.upper for name, one in first.items()}
    assert upper == test.half_widths


def test_ramps_have_enough_onsets_for_identify() -> None:
    bench = rig("belt")
    test = precise_ramps(bench, PrecisionRequest({"breakaway": 0.1}))
    sample = rehearse(test.sequence, bench, {"breakaway": math.inf})["breakaway"]
    assert not sample.refusals
    assert len(sample.widths) == REHEARSALS


def loaded(bench: Bench, share: float) -> Bench:
    """Return a bench with a load of at most `share` times the Coulomb friction."""
    high = share * bench.mechanics.coulomb.value
    most = Quantity(high, 0.0, high, si_unit("effort", bench.axis))
    return structs.replace(bench, load=LoadTerms(("spring",), most=most))


@pytest.mark.parametrize(
    ("name", "share"),
    [
        ("arm", 0.5),
        ("belt", 3.0),
        ("servo-24", 3.0),
        ("table", 0.5),
        *(
            pytest.param(*one, marks=pytest.mark.accept)
            for one in (("arm", 3.0), ("belt", 0.5), ("servo-24", 0.5), ("table", 3.0))
        ),
    ],
)
def test_a_load_makes_ramps_longer_by_its_own_rise_and_not_slower(
    name: str, share: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Rehearsals that need a tenth of the precision end the design at its first test."""

    def precise(*arguments: Any) -> dict[str, HalfWidthSample]:
        return {key: HalfWidthSample((0.1 * half,) * 8, ()) for key, half in arguments[2].items()}

    monkeypatch.setattr(rehearsed_test, "rehearse", precise)
    request = PrecisionRequest({"breakaway": 0.1})
    free, bench = rig(name), loaded(rig(name), share)
    without, with_load = (rehearsed_ramps(one, request).sequence for one in (free, bench))
    fastest = effort_rate(bench) / bench.actuator.constant.value
    rise = with_load.figures["top"] / without.figures["top"]
    assert with_load.figures["rate"] >= 0.5 * fastest
    assert with_load.duration <= 1.1 * rise * without.duration


@pytest.mark.parametrize("seconds", [150.0, 400.0, 1000.0])
@pytest.mark.parametrize("name", ["arm", "belt"])
def test_ramps_of_a_duration_have_no_more_rows(name: str, seconds: float) -> None:
    """The rows of all segments count; an axis that moves by its rules plays only a part of them."""
    bench = loaded(rig(name), 1.0)
    try:
        test = precise_ramps(bench, PrecisionRequest({"breakaway": 0.1}, duration=seconds))
    except NoSolutionError as error:
        needed = float(str(error).split("ramps need ")[1].split(" s")[0])
        assert needed > seconds
        return
    assert 0.5 * seconds < test.sequence.duration <= seconds


@pytest.mark.accept
def test_the_default_kind_is_the_test_if_no_mix_of_its_duration_has_the_precision(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    bench = rig("belt")
    wanted = {"inertia": 0.02, "coulomb": 0.02}

    def only_default(*arguments: Any) -> dict[str, HalfWidthSample]:
        sequence, _, limits = arguments[:3]
        share = 0.9 if sequence.kind == DEFAULT_KIND else 1.1
        widths = {name: share * limit for name, limit in limits.items()}
        return {name: HalfWidthSample((width,) * 8, ()) for name, width in widths.items()}

    monkeypatch.setattr(rehearsed_test, "rehearse", only_default)
    test = rehearsed_strokes(bench, PrecisionRequest(wanted))
    usual = excite(DEFAULT_KIND, bench, ExcitationSettings())
    assert test.sequence.kind == DEFAULT_KIND
    assert test.sequence.duration == usual.duration
    for name, part in wanted.items():
        half = part * getattr(bench.mechanics, name).value
        assert test.half_widths[name] == pytest.approx(0.9 * half)
        assert test.sequence.figures[f"promised_{name}"] == test.half_widths[name]
        assert 0.0 < test.bounds[name] < half


def rounds_of(bench: Bench) -> DesignRounds:
    """Return the rounds of the search for a test of strokes with the precision WANTED."""
    request = PrecisionRequest(WANTED)
    half_widths = {name: part * bench_value(bench, name) for name, part in WANTED.items()}
    trials = RehearsedTests(bench, request, half_widths, lambda step: None)
    return trials.rounds(precise_strokes, request)


def test_rounds_double_the_duration_and_end_at_a_half_width_that_does_not_decrease(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    bench = rig("belt")
    durations = []

    def floor(*arguments: Any) -> dict[str, HalfWidthSample]:
        durations.append(arguments[0].duration)
        return {name: HalfWidthSample((1.5 * limit,), ()) for name, limit in arguments[2].items()}

    monkeypatch.setattr(rehearsed_test, "rehearse", floor)
    monkeypatch.setattr(rehearsed_test, "remedies", lambda *_: [])
    rounds = rounds_of(bench)
    assert rounds.test is None
    assert "simulations: inertia 3 % (wanted 2 %), coulomb 3 % (wanted 2 %)" in rounds.refusal
    assert len(durations) == 1 + STALLS
    for before, after in itertools.pairwise(durations):
        assert after > 1.5 * before  # whole strokes come near the factor LONGER


@pytest.mark.parametrize("floor", [1.1 * HOPELESS, 0.5])
def test_rounds_end_if_the_same_axes_gain_too_little_from_a_longer_test(
    floor: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Squared half widths a + b/T on every axis: the longest test has nearly the half width a."""
    bench = rig("belt")
    durations: list[float] = []

    def by_duration(*arguments: Any) -> dict[str, HalfWidthSample]:
        durations.append(arguments[0].duration)
        share = math.sqrt(floor**2 + 1.5 * durations[0] / durations[-1])
        widths = {name: (share * limit,) * COMMON for name, limit in arguments[2].items()}
        return {name: HalfWidthSample(one, ()) for name, one in widths.items()}

    monkeypatch.setattr(rehearsed_test, "rehearse", by_duration)
    monkeypatch.setattr(rehearsed_test, "remedies", lambda *_: [])
    rounds = rounds_of(bench)
    if floor > HOPELESS:
        assert rounds.test is None
        assert len(durations) == 2
        assert f"a test of {durations[1]:.3g} s fails in simulations" in rounds.refusal
    else:
        assert rounds.test is not None


def test_the_refusal_describes_the_most_precise_test(monkeypatch: pytest.MonkeyPatch) -> None:
    bench = rig("belt")
    shares = [1.5, 1.2, 1.7, 1.6, 1.4]
    durations: list[float] = []

    def varying(*arguments: Any) -> dict[str, HalfWidthSample]:
        durations.append(arguments[0].duration)
        share = shares[len(durations) - 1]
        return {name: HalfWidthSample((share * limit,), ()) for name, limit in arguments[2].items()}

    monkeypatch.setattr(rehearsed_test, "rehearse", varying)
    monkeypatch.setattr(rehearsed_test, "remedies", lambda *_: [])
    rounds = rounds_of(bench)
    assert f"a test of {durations[1]:.3g} s fails in simulations: inertia 2.4 %" in rounds.refusal
    assert rounds.ratio == pytest.approx(1.2)


def test_a_precise_test_is_shortened_while_rehearsals_keep_the_precision(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    bench = rig("belt")
    durations = []

    def by_duration(*arguments: Any) -> dict[str, HalfWidthSample]:
        durations.append(arguments[0].duration)
        share = math.sqrt(2.0 / arguments[0].duration)
        widths = {name: share * limit for name, limit in arguments[2].items()}
        return {name: HalfWidthSample((width,) * 8, ()) for name, width in widths.items()}

    monkeypatch.setattr(rehearsed_test, "rehearse", by_duration)
    request = PrecisionRequest(WANTED, factors=dict.fromkeys(WANTED, 40.0))
    test = rehearsed_strokes(bench, request)
    assert test.sequence.duration < NOTICEABLE * durations[0]
    assert 2.0 <= test.sequence.duration <= 2.0 / SHORTER**2 * LONGER


def test_a_precision_that_rehearsals_miss_is_refused_with_the_figures(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    bench = rig("belt")

    def refusing(*_: object) -> dict[str, HalfWidthSample]:
        return {"inertia": HalfWidthSample((), ("no motion",))}

    monkeypatch.setattr(rehearsed_test, "rehearse", refusing)
    monkeypatch.setattr(rehearsed_test, "ROUNDS", 1)
    with pytest.raises(
        NoSolutionError,
        match=r"simulations: `identify` refuses inertia in 1 of 1 simulations \(no motion\)",
    ):
        rehearsed_strokes(bench, PrecisionRequest({"inertia": 0.02}))
