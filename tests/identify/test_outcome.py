"""Outcomes are merged: a parameter is identified or refused, and the later outcome counts."""

from __future__ import annotations

from dataclasses import replace

from hypothesis import given
from hypothesis import strategies as st
from msgspec import structs

from frictool.documents.quantity import Quantity
from frictool.identify.axis_logs import sort_logs
from frictool.identify.breakaway_parameters import with_breakaway
from frictool.identify.fit_result import PARAMETERS, Interval
from frictool.identify.methods import DEFAULT, IdentificationSettings
from frictool.identify.outcome import Outcome, accept, sliding_intervals
from frictool.identify.sliding_parameters import settled, sliding_fit, with_force_error
from studies.rigs.identification_rigs import clutch, record
from studies.rigs.sample_logs import TRUTH, ramp, sines

NAMES = st.sets(st.sampled_from(PARAMETERS))
OUTCOMES = st.builds(
    lambda identified, refused, level: Outcome(
        {name: Interval.around(level, 1.0) for name in identified - refused},
        dict.fromkeys(refused, f"reason {level}"),
    ),
    NAMES,
    NAMES,
    st.integers(0, 9),
)


@given(OUTCOMES, OUTCOMES, OUTCOMES)
def test_a_parameter_is_identified_or_refused_and_the_later_outcome_counts(
    first: Outcome, second: Outcome, third: Outcome
) -> None:
    before = (dict(first.identified), dict(first.refused))
    both = first.merge(second)
    assert not both.identified.keys() & both.refused.keys()
    assert second.identified.items() <= both.identified.items()
    assert second.refused.items() <= both.refused.items()
    assert both.merge(third) == first.merge(second.merge(third))
    assert first.merge(Outcome()) == Outcome().merge(first) == first
    assert (dict(first.identified), dict(first.refused)) == before


def test_an_interval_that_says_nothing_is_refused() -> None:
    offered = {"inertia": Interval(1.3e-5, -1.0, 1.0), "coulomb": Interval.around(0.1, 1e-3)}
    outcome = accept(offered, clutch(), {"viscous": "no"})
    assert list(outcome.identified) == ["coulomb"]
    assert "reaches zero" in outcome.refused["inertia"]
    assert outcome.refused["viscous"] == "no"


def test_a_breakaway_of_the_sliding_logs_outlives_ramps_that_say_less() -> None:
    """A Stribeck curve gives a breakaway as well; ramps that are refused do not take it away."""
    sliding = Outcome({"breakaway": Interval.around(0.11, 0.01)})
    log = record(ramp(1))
    logs = sort_logs([], [log], clutch(), DEFAULT, IdentificationSettings())
    negated = replace(logs, ramps=[replace(log, effort=-log.effort)])
    assert with_breakaway(negated, sliding).identified == sliding.identified
    level = with_breakaway(logs, sliding).identified["breakaway"]
    assert level.low <= TRUTH.breakaway <= level.high
    assert level != sliding.identified["breakaway"]


def test_a_refused_parameter_keeps_its_fitted_value_if_the_bench_contradicts_the_log() -> None:
    """A wrong value of the bench in a wide range would make the model useless."""
    bench = clutch()
    wrong = Quantity(2e-2, low=0.0, high=2e-2, unit="N m s/rad")
    bench = structs.replace(bench, mechanics=structs.replace(bench.mechanics, viscous=wrong))
    logs = sort_logs([record(sines(1))], [], bench, "least-squares", IdentificationSettings())
    fit = sliding_fit(logs)
    value = fit.parameters["viscous"].value
    vague = {**fit.parameters, "viscous": Interval.around(value, 1.0)}
    outcome, _ = settled(logs, replace(fit, parameters=vague))
    assert "viscous" in outcome.refused
    kept = outcome.narrowed["viscous"]
    assert kept.value == value
    assert kept.low <= wrong.interval[0]
    assert kept.high >= wrong.interval[1]


def test_a_value_outside_the_bench_needs_a_more_accurate_model() -> None:
    """An effect that was removed from the effort may be wrong, and move the inertia."""
    bench = clutch()
    least, most = bench.mechanics.inertia.interval
    true = TRUTH.inertia
    moved = Interval(5.0 * true, 4.0 * true, 6.0 * true)
    other = Quantity(2.0 * most, 1.5 * most, 2.5 * most, "kg m^2")
    elsewhere = structs.replace(bench, mechanics=structs.replace(bench.mechanics, inertia=other))
    for rig, wrong in ((bench, True), (elsewhere, False)):
        logs = sort_logs([record(sines(1))], [], rig, "least-squares", IdentificationSettings())
        fit = replace(sliding_fit(logs), effects={"warming": Interval.around(0.0, 1e-3)})
        if wrong:
            parameters = {**fit.parameters, "inertia": moved}
            fit = with_force_error(replace(fit, parameters=parameters), logs, parameters)
        outcome, _ = settled(logs, fit)
        assert ("inertia" in outcome.identified) != wrong
        assert (
            outcome.identified["coulomb"].low <= TRUTH.coulomb <= outcome.identified["coulomb"].high
        )
        if wrong:
            assert "outside the bench's" in outcome.refused["inertia"]
            assert sliding_intervals(outcome.from_logs, rig)["inertia"].low <= true
            assert least < true < most
        else:
            assert outcome.identified["inertia"].high < other.interval[0]


def test_sliding_motion_given_as_ramps_is_warned_of() -> None:
    given = [record(sines(1)), record(ramp(1))]
    logs = sort_logs([], given, clutch(), DEFAULT, IdentificationSettings())
    odd = [text for text in logs.warnings if "looks like sliding motion" in text]
    assert len(odd) == 1
