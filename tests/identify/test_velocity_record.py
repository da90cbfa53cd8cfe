"""Logs with a measured velocity and no position: the same parameters as from a position, refusals
in one line, the measured rack."""

from __future__ import annotations

import json
from pathlib import Path

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.documents.bench import Bench
from frictool.documents.quantity import Quantity
from frictool.engine.effort_replay import FREE, replay, replay_parameters
from frictool.errors import LogError
from frictool.identify.fit_result import SLIDING, UnusableLogs
from frictool.identify.identification import NothingIdentified, identify_records
from frictool.identify.methods import METHODS, IdentificationSettings, run
from frictool.identify.motion_record import MotionRecord, make_record, velocity_record
from frictool.identify.regression.newey_west import newey_west
from frictool.identify.regression.regression import SingularRegressors
from frictool.identify.rows.smoothing import (
    acceleration_filter,
    acceleration_response,
    smoothing_kernel,
)
from frictool.plant.axis import AxisParameters, rest
from studies.command_line import run as command
from tests.support.command_line import refused
from tests.support.linear_axis import PERIOD, linear_bench
from tests.support.measured_data import data
from tests.support.rack_record import RACK, published_rack, stroke

SAMPLES, NOISE, COUNT = 12_000, 0.2, 2e-4  # N, standard deviation; m/s


def axis(seed: int) -> AxisParameters:
    draw = np.random.default_rng([seed, 3])
    return AxisParameters(
        5.0 * draw.uniform(0.8, 1.2),
        12.0 * draw.uniform(0.7, 1.3),
        (c := 8.0 * draw.uniform(0.7, 1.3)),
        c,
        draw.uniform(-1, 1),
    )


def motion(
    truth: AxisParameters, seed: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Time, position, velocity and effort (n,) of an axis that a known effort drives; the effort is
    held, its measurement has noise."""
    draw, time = np.random.default_rng([seed, 4]), np.arange(SAMPLES) * PERIOD
    effort = sum(
        a * np.sin(2.0 * np.pi * f * time + draw.uniform(0, 6))
        for a, f in ((14.0, 0.9), (11.0, 0.37), (6.0, 2.3))
    )
    x, v = np.empty(SAMPLES), np.empty(SAMPLES)
    assert (
        replay(replay_parameters(truth), np.empty(0), rest(), effort, effort, FREE, PERIOD, x, v)
        == 0
    )
    return time, x, v, effort + NOISE * draw.standard_normal(SAMPLES)


def by_velocity(seed: int) -> tuple[AxisParameters, MotionRecord]:
    truth = axis(seed)
    time, _, v, effort = motion(truth, seed)
    return truth, velocity_record("log", time, COUNT * np.round(v / COUNT), effort, 0.0)


@pytest.mark.parametrize(
    "method", ["auto", "least-squares", "power-balance", "weighted", "conditioned", "recursive"]
)
def test_the_truth_lies_in_the_intervals(method: str) -> None:
    hits = []
    for seed in range(5):
        truth, record = by_velocity(seed)
        found = run(method, [record], linear_bench(), IdentificationSettings()).parameters
        hits += [found[name].low <= getattr(truth, name) <= found[name].high for name in SLIDING]
    assert sum(hits) >= len(hits) - 3


@settings(max_examples=8, deadline=None)
@given(st.integers(0, 10_000))
def test_a_velocity_tells_what_its_position_does(seed: int) -> None:
    truth = axis(seed)
    time, x, v, effort = motion(truth, seed)
    one = run(
        "least-squares",
        [make_record("x", time, x, effort, 1e-9, 0.0)],
        linear_bench(),
        IdentificationSettings(window=51),
    ).parameters
    other = run(
        "least-squares",
        [velocity_record("v", time, v, effort, 0.0)],
        linear_bench(),
        IdentificationSettings(window=51),
    ).parameters
    for name in SLIDING:
        assert other[name].value == pytest.approx(one[name].value, abs=0.1 * one[name].half_width)


def test_the_response_to_a_velocity_is_that_to_its_integral() -> None:
    _, record = by_velocity(0)
    window = 21
    impulse = np.zeros(61)
    impulse[30] = 1.0
    integral = np.concatenate(([0.0], np.cumsum(0.5 * (impulse[1:] + impulse[:-1])) * PERIOD))
    expected = np.correlate(integral, acceleration_filter(window, PERIOD), mode="valid")
    response = acceleration_response(record, window)
    assert np.linalg.norm(response) == pytest.approx(np.linalg.norm(expected), rel=1e-9)
    assert smoothing_kernel(window, PERIOD).sum() == pytest.approx(1.0)


@pytest.mark.parametrize("method", [name for name, row in METHODS.items() if not row.velocity])
def test_other_methods_refuse_in_one_line(method: str) -> None:
    _, record = by_velocity(1)
    with pytest.raises(
        UnusableLogs,
        match=f"a velocity and no position, but {method} needs a position; these methods "
        "need no position: auto",
    ):
        run(method, [record], linear_bench(), IdentificationSettings())


def test_ramps_need_a_position() -> None:
    _, record = by_velocity(1)
    with pytest.raises(NothingIdentified, match="has no position"):
        identify_records([], [record], linear_bench(), "auto", IdentificationSettings())


def test_a_velocity_that_does_not_change_is_refused() -> None:
    with pytest.raises(LogError, match="does not change"):
        velocity_record("log", np.arange(9.0), np.zeros(9), np.ones(9), 0.0)


def one_way(known: Quantity | None) -> tuple[AxisParameters, MotionRecord, Bench]:
    """Half of the motion: where the axis goes forward; what comes between is a gap of the clock."""
    truth = axis(2)
    time, _, v, effort = motion(truth, 2)
    kept = v > 0.01
    record = velocity_record("log", time[kept], v[kept], effort[kept], 0.0)
    bench = linear_bench()
    return (
        truth,
        record,
        msgspec.structs.replace(
            bench, mechanics=msgspec.structs.replace(bench.mechanics, offset=known)
        ),
    )


def test_one_direction_tells_coulomb_friction_where_the_bench_knows_the_offset() -> None:
    truth, record, bench = one_way(None)
    fit = run("least-squares", [record], bench, IdentificationSettings())
    assert set(fit.refused) == {"coulomb", "offset"}
    known = Quantity(truth.offset, truth.offset - 0.3, truth.offset + 0.1, "N")
    truth, record, bench = one_way(known)
    found = run("least-squares", [record], bench, IdentificationSettings())
    coulomb = found.parameters["coulomb"]
    assert coulomb.low <= truth.coulomb <= coulomb.high
    assert set(found.refused) == {"offset"}
    exact = run(
        "least-squares",
        [record],
        one_way(Quantity(truth.offset, unit="N"))[2],
        IdentificationSettings(),
    ).parameters["coulomb"]
    assert coulomb.high - coulomb.low == pytest.approx(exact.high - exact.low + 0.4)


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(0, 12))
def test_newey_west_is_its_double_sum(seed: int, reach: int) -> None:
    draw = np.random.default_rng(seed)
    columns, residual = draw.standard_normal((40, 3)) * [1.0, 1e3, 1e-3], draw.standard_normal(40)
    middle = np.zeros((3, 3))
    for i in range(40):
        for j in range(40):
            if abs(i - j) <= reach:
                middle += (
                    (1.0 - abs(i - j) / (reach + 1))
                    * residual[i]
                    * residual[j]
                    * np.outer(columns[i], columns[j])
                )
    inverse = np.linalg.inv(columns.T @ columns)
    expected = np.sqrt(np.diag(inverse @ middle @ inverse) * 40 / 37)
    assert newey_west(columns, residual, reach) == pytest.approx(expected, rel=1e-6)


def test_the_rack_s_published_values(tmp_path: Path) -> None:
    found = published_rack(tmp_path)
    assert found["coulomb"]["value"] == pytest.approx(10.1, rel=0.02)
    assert found["viscous"]["value"] == pytest.approx(67.5, rel=0.02)
    assert found["breakaway"]["low"] <= 29.6 <= found["breakaway"]["high"]


def test_the_rack_s_whole_stroke_by_the_default(tmp_path: Path) -> None:
    log = stroke(tmp_path)
    result = command("identify", log, "--bench", RACK, "-o", tmp_path / "model.yaml", "--json")
    assert result.code == 0, result.stderr
    assert {"viscous", "coulomb"} <= set(json.loads(result.stdout)["parameters"])
    refused(command("validate", tmp_path / "model.yaml", log), 3, "no position")


def test_an_effort_of_another_instrument_has_to_be_on_one_grid(tmp_path: Path) -> None:
    raw, log = [data("rack", "a3MR.csv"), data("rack", "a3NI.csv")], tmp_path / "stroke.mcap"
    assert command("ingest", *raw, "--bench", RACK, "-o", log).code == 0
    refused(command("identify", log, "--bench", RACK), 3, "/axis/force", "--resample")


def test_the_curve_of_known_friction_is_found() -> None:
    """friction-force on a made curve: v_p, and both levels, to the filter."""
    time = np.arange(4000) * PERIOD
    v = 0.3 * np.abs(np.sin(0.4 * np.pi * time)) ** 2
    curve = 4.0 + 20.0 * v + 3.0 * (v / 0.02) * np.exp(1.0 - v / 0.02)
    effort = 5.0 * np.gradient(v, PERIOD) + curve
    bench = linear_bench()
    known = msgspec.structs.replace(bench.mechanics, offset=Quantity(0.0, unit="N"))
    fit = run(
        "friction-force",
        [velocity_record("log", time, v, effort, 0.0)],
        replace_mechanics(bench, known),
        IdentificationSettings(),
    )
    assert fit.details["speed_of_breakaway"] == pytest.approx(0.02, rel=0.02)
    values = [fit.parameters[name].value for name in ("coulomb", "viscous", "breakaway")]
    assert values == pytest.approx([4.0, 20.0, 7.0], rel=0.02)


def replace_mechanics(bench: Bench, mechanics: object) -> Bench:
    return msgspec.structs.replace(bench, mechanics=mechanics)


@pytest.mark.parametrize("reach", [0, 3])
def test_the_deviation_of_a_mean_is_the_sum_of_its_weighted_autocovariances(reach: int) -> None:
    """Newey and West: weights 1 - lag/(reach + 1), and n/(n - p) for the lost degree of freedom."""
    n = 50
    residual = np.random.default_rng(1).standard_normal(n)
    residual -= residual.mean()
    weights = 1.0 - np.abs(np.arange(-reach, reach + 1)) / (reach + 1.0)
    products = [
        float(residual[max(lag, 0) : n + min(lag, 0)] @ residual[max(-lag, 0) : n - max(lag, 0)])
        for lag in range(-reach, reach + 1)
    ]
    variance = float(weights @ products) / n**2 * n / (n - 1.0)
    found = newey_west(5.0 * np.ones((n, 1)), residual, reach)
    assert found == pytest.approx([np.sqrt(variance) / 5.0], rel=1e-12)


def test_dependent_regressors_are_refused_with_their_condition() -> None:
    turn = np.linspace(0.0, 6.0, 40)
    columns = np.column_stack((np.cos(turn), np.cos(turn) + 1e-13 * np.sin(turn)))
    unit = columns / np.linalg.norm(columns, axis=0)
    expected = np.linalg.cond(unit)
    with pytest.raises(SingularRegressors, match=r"dependent \(condition number \S+\)") as refused:
        newey_west(columns, np.ones(40), 2)
    told = float(str(refused.value).split()[-1].rstrip(")"))
    assert told == pytest.approx(expected, rel=0.1)
