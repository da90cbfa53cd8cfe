"""The logs narrow the bench's range of a parameter whose interval is too wide to be used alone."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binom

from frictool.adapters.parameter_intervals import absolute
from frictool.documents.bench import Bench
from frictool.documents.model import Model
from frictool.documents.quantity import Quantity
from frictool.documents.registry import load
from frictool.identify.absolute_intervals import parameter_intervals
from frictool.identify.fit_result import Interval
from frictool.identify.identification import Identification, identify_records
from frictool.identify.interval_checks import narrowed
from frictool.identify.methods import IdentificationSettings
from frictool.identify.motion_record import MotionRecord, record_of
from frictool.identify.outcome import Outcome, accept
from frictool.logs.channels.bench_match import match_bench
from frictool.logs.log_reader import read_log
from frictool.plan.narrowed_model import narrowed_bench
from studies.command_line import run
from studies.rigs.identification_rigs import clutch
from tests.identify.arm import PERIOD, Arm, play, write_bench, write_log

EXACT = Quantity(1.0, None, None, "N m/A")
SLOW = 0.5 * np.sin(np.arange(8000) * PERIOD)  # rad; accelerating takes little effort
NOISE = 0.05  # N m
RIGS = 25
NARROWED = 10  # seed of a rig whose inertia the log bounds from above only


def slow_arm(seed: int) -> tuple[Arm, np.random.Generator]:
    """Return an arm with little inertia, and the generator of its noise and its bench."""
    draw = np.random.default_rng([7, seed])
    inertia = float(np.exp(draw.uniform(np.log(0.001), np.log(0.02))))
    viscous, coulomb = draw.uniform([0.0, 0.1], [0.1, 0.4]).tolist()
    return Arm(inertia, viscous, coulomb, breakaway=1.05 * coulomb, counts=65536), draw


def written(folder: Path, seed: int) -> tuple[Arm, Path, Path]:
    """Return a slow arm, its log and a bench with a random range around its inertia."""
    arm, draw = slow_arm(seed)
    position, effort = play(arm, SLOW, (60.0, 100.0, 1.0))
    factors = np.exp(draw.uniform(np.log(1.2), np.log(20.0), 2) * [-1.0, 1.0])
    low, high = (arm.inertia * factors).tolist()
    text = write_bench(folder, arm).read_text()
    line = next(one for one in text.splitlines() if one.startswith("  inertia:"))
    value = np.sqrt(low * high)
    wanted = f"  inertia: {{value: {value}, low: {low}, high: {high}, unit: kg m^2}}"
    bench = folder / "bench.yaml"
    bench.write_text(text.replace(line, wanted))
    noisy = effort + NOISE * draw.standard_normal(effort.size)
    return arm, write_log(folder / "log.csv", position, noisy), bench


def identified(log: Path, bench: Bench) -> Identification:
    """Return the identification of a log by least squares."""
    record: MotionRecord = record_of(match_bench(read_log(log, bench), bench), bench)
    return identify_records([record], [], bench, "least-squares", IdentificationSettings())


@pytest.mark.accept
def test_the_narrowed_range_contains_the_inertia_at_the_stated_rate(tmp_path: Path) -> None:
    held = []
    for seed in range(RIGS):
        arm, log, path = written(tmp_path, seed)
        bench = load(path, Bench)
        inside = identified(log, bench).narrowed.get("inertia")
        if inside is None:
            continue
        low, high = bench.mechanics.inertia.interval
        assert low <= inside.low <= inside.value <= inside.high <= high
        assert inside.high - inside.low < high - low
        held.append(inside.low <= arm.inertia <= inside.high)
    assert len(held) > 0.3 * RIGS
    assert sum(held) >= binom.ppf(0.001, len(held), 0.95)


def test_a_bench_far_from_the_axis_does_not_replace_what_the_log_bounds(tmp_path: Path) -> None:
    """The bench's value is 20 times the inertia. The log's interval reaches 0, but its upper end
    is far below the bench's value."""
    arm, log, bench = written(tmp_path, NARROWED)
    text = bench.read_text()
    line = next(one for one in text.splitlines() if one.startswith("  inertia:"))
    low, value, high = (factor * arm.inertia for factor in (0.2, 20.0, 200.0))
    wide = f"  inertia: {{value: {value}, low: {low}, high: {high}, unit: kg m^2}}"
    bench.write_text(text.replace(line, wide))
    model = tmp_path / "model.yaml"
    options = ("--bench", bench, "--method", "least-squares", "--json", "-o", model)
    result = run("identify", log, *options)
    assert result.code == 0, result.stderr
    view = json.loads(result.stdout)
    assert "reaches zero" in view["not_identified"]["inertia"]
    estimate = load(model, Model).parameters.inertia
    assert estimate.source == "log and bench"
    shown = {name: getattr(estimate, name) for name in ("value", "low", "high", "unit")}
    absolute = view["narrowed"]["inertia"].pop("absolute")
    assert view["narrowed"] == {"inertia": pytest.approx(shown)}
    assert low <= absolute["low"] <= absolute["high"] <= high
    assert estimate.low == pytest.approx(low)
    assert low <= estimate.value < 0.1 * value
    assert estimate.high is not None
    assert arm.inertia <= estimate.high < value
    assert view["force_error"] < 0.1
    text_view = run("identify", log, *options[:4]).stdout
    assert "log and bench" in next(
        one for one in text_view.splitlines() if one.startswith("inertia")
    )


ENDS = st.tuples(st.floats(-5.0, 5.0), st.floats(0.01, 5.0), st.floats(0.0, 1.0))


def interval(ends: tuple[float, float, float]) -> Interval:
    """Return an interval of a lower end, a width and a relative position of its value."""
    low, width, share = ends
    return Interval(min(low + share * width, low + width), low, low + width)


@given(ENDS, ENDS)
def test_the_narrowed_range_is_the_intersection(
    log: tuple[float, float, float], bench: tuple[float, float, float]
) -> None:
    """Every point is in the narrowed range if and only if it is in both intervals."""
    of_log, of_bench = interval(log), interval(bench)
    known = Quantity(of_bench.value, of_bench.low, of_bench.high, "N m")
    inside = narrowed(of_log, known, EXACT)
    points = [of_log.low, of_log.high, of_log.value, of_bench.low, of_bench.high, of_bench.value]
    both = [x for x in points if of_log.low <= x <= of_log.high and known.low <= x <= known.high]
    if inside is None:
        # disjoint, or all of the bench's range is in the log's interval
        assert not both or {of_bench.low, of_bench.high} <= set(both)
        return
    assert both == [x for x in points if inside.low <= x <= inside.high]
    distance = [abs(x - of_log.value) for x in both]
    assert abs(inside.value - of_log.value) == pytest.approx(min(distance))


@given(st.floats(0.6, 2.0), st.floats(0.3, 0.9), st.floats(1.1, 3.0))
def test_the_range_holds_for_every_constant_of_the_actuator(
    true_constant: float, low: float, high: float
) -> None:
    """A log gives the inertia times nominal over true constant; the bench states the inertia."""
    constant = Quantity(1.0, 0.5, 2.0, "N m/A")
    for inertia in (low, high):
        measured = inertia / true_constant
        of_log = Interval(measured, -9.0, measured)
        inside = narrowed(of_log, Quantity(1.0, low, high, "kg m^2"), constant)
        assert inside is not None
        assert inside.low <= measured <= inside.high


def test_the_value_of_a_narrowed_range_is_one_that_the_bench_allows() -> None:
    """With half of the constant, an inertia of 6 would be 3; the value is that with the nominal
    constant, for which the bench allows at most 3."""
    constant = Quantity(1.0, 0.5, 2.0, "N m/A")
    inside = narrowed(Interval(9.0, 1.0, 10.0), Quantity(1.0, 0.3, 3.0, "kg m^2"), constant)
    assert inside == Interval(3.0, 1.0, 6.0)


def test_a_range_without_an_overlap_is_stated_with_both_intervals() -> None:
    """The interval spans a factor of 50, so that the log's value cannot replace the bench's."""
    bench = clutch()
    low, high = bench.mechanics.inertia.interval
    offered = {"inertia": Interval(0.1 * low, 0.01 * low, 0.5 * low)}
    outcome = accept(offered, bench)
    assert not outcome.narrowed
    assert f"[{0.01 * low:.4g}, {0.5 * low:.4g}]" in outcome.refused["inertia"]
    assert (
        f"outside the bench's [{low:.4g}, {high:.4g}], whose value is used"
        in outcome.refused["inertia"]
    )


def test_a_parameter_that_the_method_refuses_has_no_interval_to_narrow_a_range() -> None:
    low, high = clutch().mechanics.inertia.interval
    offered = {"inertia": Interval(0.5 * (low + high), -high, 0.9 * high)}
    assert "inertia" in accept(offered, clutch()).narrowed
    refused = accept(offered, clutch(), {"inertia": "the encoder hides it"})
    assert not refused.narrowed
    assert "inertia" in refused.refused


def test_a_later_outcome_replaces_a_narrowed_range() -> None:
    one = Outcome(refused={"inertia": "wide"}, narrowed={"inertia": Interval.around(1.0, 0.5)})
    assert one.merge(Outcome()).narrowed == one.narrowed
    assert not one.merge(Outcome({"inertia": Interval.around(1.0, 0.1)})).narrowed
    assert not one.merge(Outcome(refused={"inertia": "no motion"})).narrowed
    assert not one.without("inertia").narrowed
    assert one.from_logs == one.narrowed


def test_plan_and_absolute_intervals_use_a_narrowed_range(tmp_path: Path) -> None:
    """The absolute interval is not wider than the bench's range."""
    _, log, bench = written(tmp_path, NARROWED)
    exact, uncertain = "{value: 1, unit: N m/A}", "{value: 1, low: 0.9, high: 1.1, unit: N m/A}"
    bench.write_text(bench.read_text().replace(exact, uncertain))
    path = tmp_path / "model.yaml"
    options = ("--bench", bench, "--method", "least-squares", "--json", "-o", path)
    result = run("identify", log, *options)
    assert result.code == 0, result.stderr
    model = load(path, Model)
    inertia = model.parameters.inertia
    assert inertia.source == "log and bench"
    assert narrowed_bench(model.bench, model).mechanics.inertia.interval == inertia.interval
    row = next(one for one in parameter_intervals(model) if one.name == "inertia")
    low, high = model.bench.mechanics.inertia.interval
    assert low <= row.absolute.low < row.absolute.high <= high
    assert row.from_logs
    assert not row.identified
    view = json.loads(result.stdout)
    shown = view["narrowed"]["inertia"]["absolute"]
    assert shown == pytest.approx({"low": row.absolute.low, "high": row.absolute.high})
    assert view["parameters"]
    for one in view["parameters"].values():
        ends = absolute(one["low"], one["high"], model.bench.actuator.constant)
        assert one["absolute"] == pytest.approx({"low": ends[0], "high": ends[1]})
