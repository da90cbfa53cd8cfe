"""The method that `auto` chooses, its report, and the parameters that are refused after the fit."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest

from frictool.documents.bench import Bench
from frictool.documents.quantity import Quantity
from frictool.documents.registry import load
from frictool.identify.estimators import method_comparison
from frictool.identify.estimators.method_comparison import (
    ComparedData,
    PredictionScore,
    best_by_prediction,
    regression_scores,
)
from frictool.identify.fit_result import Interval, SlidingFit, UnusableLogs
from frictool.identify.fixed_parameter_refit import refit
from frictool.identify.force_error import force_error, motion_rows
from frictool.identify.identification import identify_records
from frictool.identify.log_disagreement import pooling_warnings
from frictool.identify.methods import IdentificationSettings, run
from frictool.identify.motion_record import record_of
from frictool.identify.rows.regression_samples import shifted
from frictool.logs.log_reader import read_log
from studies.command_line import run as command
from studies.rigs.identification_rigs import EMPS
from tests.identify.arm import PERIOD, Arm, play, write_bench, write_log
from tests.identify.two_days import DAYS, day, written
from tests.support.linear_axis import linear_axis, linear_bench
from tests.support.loaded_axis import estimates, loaded_axis
from tests.support.measured_data import data

TIME = np.arange(12_000) * PERIOD


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two days as CSV."""
    folder = tmp_path_factory.mktemp("days")
    for name in DAYS:
        written(folder, name)
    return folder


@cache
def identified(folder: Path, *days: str, method: str = "auto") -> tuple[dict[str, Any], str, Path]:
    """Return the JSON of `identify`, its stderr, and the model."""
    target = folder / f"{method}_{'_'.join(days)}.yaml"
    result = command(
        "identify",
        *(folder / f"{name}.csv" for name in days),
        "--bench",
        EMPS,
        "--method",
        method,
        "--json",
        "-o",
        target,
    )
    assert result.code == 0, result.stderr
    return json.loads(result.stdout), result.stderr, target


def simulated(model: Path, log: Path) -> float:
    """Position error (rms) of a model on a log, m."""
    result = command("validate", model, log, "--json")
    assert result.code == 0, result.stderr
    error: float = json.loads(result.stdout)["position_rmse_m"]
    return error


def test_a_model_with_two_directions_is_taken_where_it_predicts_better(folder: Path) -> None:
    """Its offset is another number than that beside a single viscous friction, and that does not
    disqualify it."""
    found, _, model = identified(folder, "monday")
    plain = identified(folder, "monday", method="least-squares")[2]
    assert simulated(model, folder / "monday.csv") < 0.1 * simulated(plain, folder / "monday.csv")
    forward, backward = DAYS["monday"][:2]
    assert found["parameters"]["viscous"]["value"] == pytest.approx(forward, rel=0.01)
    assert found["laws"]["backward"]["viscous"]["value"] == pytest.approx(backward, rel=0.01)


def test_the_text_says_what_was_tried_each_score_and_why_the_winner_won(folder: Path) -> None:
    why = identified(folder, "monday")[0]["chosen_because"]
    assert "compared on strokes left out of the fit (position error rms, force error)" in why
    for candidate in (
        "least-squares",
        "least-squares with viscous friction by direction",
        "output-error with viscous friction by direction",
    ):
        assert f"{candidate} 0.0" in why
    assert "is the first method within 10 % of the best allowed one" in why


def _no_fit() -> SlidingFit:
    raise UnusableLogs("none")


@pytest.mark.parametrize(("error", "text"), [(0.1, "sines 0.1 rad"), (2.0, "measured range of 1")])
def test_an_error_above_the_measured_range_is_no_number(error: float, text: str) -> None:
    score = PredictionScore("sines", (), np.full(3, error**2), 0.1, _no_fit, 1.0)
    assert text in score.shown("rad")
    assert score.leaves is (error > 1.0)


def test_two_days_together_explain_the_effort_and_say_that_they_disagree(folder: Path) -> None:
    found, told, _ = identified(folder, "monday", "tuesday")
    assert found["force_error"] < 0.05
    alone = identified(folder, "monday")[0]["parameters"]["viscous"]
    both = found["parameters"]["viscous"]
    assert both["high"] - both["low"] > 4.0 * (alone["high"] - alone["low"])
    assert "warning: viscous: the interval from all logs is" in told
    assert "because the logs disagree (monday.csv [16" in told
    assert max(map(len, told.splitlines())) <= 200


def test_output_error_tells_two_directions_as_narrowly_as_the_regression(folder: Path) -> None:
    """Its intervals are made of what the regression of the same structure leaves."""
    record, bench = day("monday"), load(EMPS, Bench)
    found = run("output-error", [record], bench, IdentificationSettings()).parameters
    assert found["viscous"].half_width < 5.0
    assert found["offset"].half_width < 1.0


def narrow(bench: Bench, **known: Quantity) -> Bench:
    return msgspec.structs.replace(
        bench, mechanics=msgspec.structs.replace(bench.mechanics, **known)
    )


METHODS = [
    "least-squares",
    "power-balance",
    "weighted",
    "recursive",
    "total-least-squares",
    "weak",
    "ordinary",
    "output-error",
]


@pytest.mark.parametrize("method", METHODS)
def test_a_refused_parameter_is_fixed_and_the_others_fitted_beside_it(method: str) -> None:
    """Viscous friction is fixed at a wrong value: the dry friction makes up for it as far as the
    log's speeds allow."""
    axis, log = linear_axis(3)
    value = 1.3 * axis.viscous
    unit = linear_bench().mechanics.viscous.unit
    bench = narrow(linear_bench(), viscous=Quantity(value, 0.999 * value, 1.001 * value, unit))
    fit = replace(run(method, [log], bench, IdentificationSettings()), method=method)
    again = refit(
        [log],
        bench,
        IdentificationSettings(),
        fit,
        {"viscous": Interval(value, 0.999 * value, 1.001 * value)},
    )
    assert again.details["fixed_viscous"] == value
    rows = motion_rows([log], bench)
    beside = {"inertia": bench.mechanics.inertia.value}, {"viscous": value}
    before, after = (
        force_error(
            rows,
            beside[0] | {name: one.value for name, one in found.parameters.items()} | beside[1],
            None,
        )
        for found in (fit, again)
    )
    assert before is not None
    assert after is not None
    assert after < 0.8 * before


@pytest.mark.parametrize("method", ["least-squares", "weak"])
def test_the_range_of_a_fixed_parameter_widens_the_others(method: str) -> None:
    _, log = linear_axis(3)
    bench = linear_bench()
    known = bench.mechanics.viscous
    narrowly, widely = (
        run(
            method,
            [log],
            bench,
            IdentificationSettings(
                window=17,
                fixed={
                    "viscous": Interval(known.value, known.value * (1 - r), known.value * (1 + r))
                },
            ),
        )
        for r in (1e-6, 0.5)
    )
    assert narrowly.parameters["coulomb"].value == widely.parameters["coulomb"].value
    assert widely.parameters["coulomb"].half_width > 2.0 * narrowly.parameters["coulomb"].half_width


def test_the_power_balance_is_not_taken_where_its_model_simulates_worse() -> None:
    """EMPS: the power balance's offset sends the simulated carriage tens of millimetres away."""
    bench = load(EMPS, Bench)
    record = record_of(read_log(data("emps", "DATA_EMPS.mat"), bench), bench)
    fits = [
        replace(run(method, [record], bench, IdentificationSettings()), method=method, why="asked")
        for method in ("power-balance", "least-squares")
    ]
    assert (
        best_by_prediction(ComparedData([record], bench, IdentificationSettings(), fits)).method
        != "power-balance"
    )


@pytest.mark.parametrize(
    "method", ["power-balance", pytest.param("conditioned", marks=pytest.mark.accept)]
)
def test_a_requested_method_that_simulates_far_worse_is_told(method: str) -> None:
    """EMPS: the offset of the power balance sends the simulated carriage tens of millimetres away;
    least squares do not."""
    log = data("emps", "DATA_EMPS.mat")
    requested, plain = (
        command("identify", log, "--bench", EMPS, "--method", name, "--json")
        for name in (method, "least-squares")
    )
    assert (requested.code, plain.code) == (0, 0)
    told = re.search(
        rf"warning: {method} predicts strokes left out of the fit worse .* simulated position is "
        r"(\S+) m instead of (\S+) m",
        requested.stderr,
    )
    assert told is not None, requested.stderr
    assert float(told[1]) > 3.0 * float(told[2]) > 0.0
    assert "worse" not in plain.stderr


def test_logs_too_short_for_halves_compare_the_regressions_on_themselves() -> None:
    record, bench = day("monday").part(slice(0, 6_200)), load(EMPS, Bench)
    fits = [
        replace(run(method, [record], bench, IdentificationSettings()), method=method, why="asked")
        for method in ("power-balance", "least-squares")
    ]
    chosen = best_by_prediction(ComparedData([record], bench, IdentificationSettings(), fits))
    assert "too short to be divided" in str(chosen.why)
    score = {
        fit.method: float(re.findall(rf"{fit.method} ([0-9.e-]+) m", str(chosen.why))[0])
        for fit in fits
    }
    assert 0.9 * score[chosen.method] <= min(score.values())


def test_a_half_that_would_predict_with_a_value_of_the_bench_has_no_score() -> None:
    """Five strokes determine Coulomb friction, but two or three strokes do not."""
    whole = day("monday").part(slice(0, 10_000))
    bench, settings = load(EMPS, Bench), IdentificationSettings()
    fit = replace(run("least-squares", [whole], bench, settings), method="least-squares")
    assert "coulomb" in fit.parameters
    halved = [whole.part(slice(0, 5_000))], [whole.part(slice(5_000, 10_000))]
    data = ComparedData([whole], bench, settings, [fit])
    for sides, scores in ((halved, 0), (([whole], [whole]), 1)):
        rows = [motion_rows(side, bench) for side in sides]
        assert len(regression_scores(sides, rows, data)) == scores


def test_output_error_is_checked_if_the_halves_are_too_short_for_a_regression(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A regression of all logs still excludes an inertia that is wrong by a factor of two."""
    record, bench, settings = day("monday"), load(EMPS, Bench), IdentificationSettings()
    fit = replace(run("least-squares", [record], bench, settings), method="least-squares", why="")
    simulated = replace(fit, method="output-error")
    right, wrong = (
        replace(simulated, parameters={**fit.parameters, "inertia": interval})
        for interval in (
            fit.parameters["inertia"],
            shifted(fit.parameters["inertia"], fit.parameters["inertia"].value),
        )
    )
    only = [PredictionScore("output-error", (), np.ones(2), 1.0, lambda: simulated)]
    monkeypatch.setattr(method_comparison, "regression_scores", lambda *_: [])
    monkeypatch.setattr(method_comparison, "_simulations", lambda *_: only)
    for simulated, method in ((right, "output-error"), (wrong, "least-squares")):
        chosen = best_by_prediction(ComparedData([record], bench, settings, [fit]))
        assert chosen.method == method
        assert ("is not used: its inertia" in str(chosen.why)) is (simulated is wrong)


@pytest.mark.parametrize("kind", ["coulomb", "viscous", "spring"])
@pytest.mark.parametrize("name", ["viscous", "coulomb"])
def test_a_parameter_is_fixed_beside_declared_loads(kind: str, name: str) -> None:
    """The load that the bench declares is still found; a Coulomb friction of each direction is not
    fixed, since it is two numbers."""
    axis = loaded_axis(2, kind)
    value = axis.truth[name]
    unit = getattr(axis.bench.mechanics, name).unit
    bench = narrow(axis.bench, **{name: Quantity(value, 0.9999 * value, 1.0001 * value, unit)})
    result = identify_records([axis.record], [], bench, "least-squares", IdentificationSettings())
    assert name in result.refused
    assert result.fit is not None
    assert (f"fixed_{name}" in result.fit.details) == ((kind, name) != ("coulomb", "coulomb"))
    told = estimates(replace(result.fit, laws=result.laws))
    for other in (f"{kind}_backward", "stiffness"):
        if other in axis.truth:
            assert told[other].value == pytest.approx(axis.truth[other], rel=0.05)


CONTRADICTED = (
    "auto",
    "least-squares",
    "power-balance",
    "weighted",
    "weak",
    "instrumental",
    "recursive",
    "ordinary",
    "output-error",
)


@pytest.mark.parametrize(
    "method",
    [
        one if one in ("least-squares", "ordinary") else pytest.param(one, marks=pytest.mark.accept)
        for one in CONTRADICTED
    ],
)
def test_the_value_of_the_log_is_used_where_it_contradicts_the_bench(
    folder: Path, method: str
) -> None:
    """Viscous friction is 165 N s/m forward; the bench claims 49.9 to 50.1, narrower than any log
    tells."""
    bench = folder / "narrow.yaml"
    bench.write_text(
        re.sub(
            r"viscous: .*",
            "viscous: {value: 50, low: 49.9, high: 50.1, unit: N s/m}",
            EMPS.read_text(),
        )
    )
    log = folder / "monday.csv"
    found = command("identify", log, "--bench", bench, "--method", method, "--json")
    assert found.code == 0, found.stderr
    told = (
        r"warning: viscous: the log's interval .* lies wholly outside the bench's \[49.9, "
        r"50.1\]; the log's value is used"
    )
    assert re.search(told, found.stderr)
    contradicted, plain = json.loads(found.stdout), identified(folder, "monday", method=method)[0]
    for key in ("value", "low", "high"):
        shown, log_alone = (one["parameters"]["viscous"][key] for one in (contradicted, plain))
        assert shown == pytest.approx(log_alone)
    assert contradicted["force_error"] == pytest.approx(plain["force_error"])


def nearly_frictionless(folder: Path, seed: int) -> tuple[Path, Path]:
    """Return a log of an arm without viscous friction, whose fitted one is negative, and a bench
    whose range holds 0."""
    position, effort = play(
        Arm(viscous=0.0, counts=65536), 0.5 * np.sin(4.0 * TIME), (60.0, 100.0, 3.0)
    )
    noise = 0.02 * np.random.default_rng(seed).standard_normal(effort.size)
    return write_log(folder / "log.csv", position, effort + noise), write_bench(
        folder, Arm(counts=65536)
    )


def test_values_of_the_bench_that_explain_less_are_told_with_both_force_errors(
    tmp_path: Path,
) -> None:
    log, bench = nearly_frictionless(tmp_path, 1)
    bench.write_text(re.sub(r"(viscous: .*), low: 0, high: [0-9.]*,", r"\1,", bench.read_text()))
    result = command("identify", log, "--bench", bench, "--method", "least-squares", "--json")
    assert result.code == 0, result.stderr
    found = json.loads(result.stdout)
    assert "gives a negative value" in found["not_identified"]["viscous"]
    told = re.search(
        r"values within the bench's ranges replace viscous .* raise the force error from "
        r"(\S+) % to (\S+) %",
        result.stderr,
    )
    assert told is not None, result.stderr
    assert float(told[2]) == pytest.approx(100.0 * found["force_error"], rel=0.01)
    assert float(told[2]) > 2.0 * float(told[1])


def test_a_negative_friction_that_may_be_0_is_0_where_the_bench_excludes_it(tmp_path: Path) -> None:
    log, bench = nearly_frictionless(tmp_path, 1)
    bench.write_text(re.sub(r"(viscous: .*)low: 0,", r"\1low: 0.04,", bench.read_text()))
    result = command("identify", log, "--bench", bench, "--method", "least-squares", "--json")
    assert result.code == 0, result.stderr
    viscous = json.loads(result.stdout)["parameters"]["viscous"]
    assert viscous["value"] == viscous["low"] == 0.0 < viscous["high"] < 0.01
    assert "lies wholly outside the bench's [0.04, 0.25]" in result.stderr


@pytest.mark.accept
def test_logs_that_disagree_are_told_where_the_parameter_is_refused(folder: Path) -> None:
    """The interval from both days is too wide to be of use; each day gives a narrow one."""
    both = identified(folder, "monday", "tuesday")[0]["parameters"]["viscous"]["value"]
    bench = folder / "middle.yaml"
    line = (
        f"viscous: {{value: {both:.6g}, low: {0.99 * both:.6g}, high: {1.01 * both:.6g}, "
        f"unit: N s/m}}"
    )
    bench.write_text(re.sub(r"viscous: .*", line, EMPS.read_text()))
    logs = [folder / "monday.csv", folder / "tuesday.csv"]
    result = command("identify", *logs, "--bench", bench, "--json")
    assert result.code == 0, result.stderr
    assert "no narrower" in json.loads(result.stdout)["not_identified"]["viscous"]
    assert "warning: viscous: the interval from all logs is" in result.stderr


def test_pooled_logs_that_agree_are_not_said_to_disagree(folder: Path) -> None:
    """The day twice, with other noise, and intervals that something else has widened."""
    record = replace(day("monday", seed=2), name="again.csv")
    alone = replace(day("monday"), name="monday.csv")
    bench, fit = (
        load(EMPS, Bench),
        run("least-squares", [alone, record], load(EMPS, Bench), IdentificationSettings()),
    )
    wide = {name: 9.0 * one.half_width for name, one in fit.parameters.items()}
    found = {
        name: Interval(one.value, one.value - wide[name], one.value + wide[name])
        for name, one in fit.parameters.items()
    }
    told = pooling_warnings(
        [alone, record],
        bench,
        IdentificationSettings(),
        replace(fit, parameters=found, method="least-squares"),
        found,
    )
    assert told
    singles = [
        run("least-squares", [one], bench, IdentificationSettings()).parameters
        for one in (alone, record)
    ]
    for line in told:
        name = line.split(":")[0]
        narrowest = min(one[name].half_width for one in singles)
        assert f" is {wide[name] / narrowest:.3g} times as wide as that of " in line
    assert not any("because the logs disagree" in line for line in told)
    assert all("although the logs agree on this parameter" in line for line in told)
    # a common value that no single log supports, as between a cold and a warm log
    common = replace(fit, method="least-squares")
    elsewhere = dict(fit.parameters)
    for shift, count in ((0.0, 0), (1.0, 1)):
        moved = fit.parameters["coulomb"].value * (1.0 + shift)
        elsewhere["coulomb"] = Interval(moved, 0.99 * moved, 1.01 * moved)
        lines = pooling_warnings(
            [alone, record], bench, IdentificationSettings(), common, elsewhere
        )
        assert len(lines) == count
        assert all("coulomb: " in line and " contradicts " in line for line in lines)


@pytest.mark.parametrize("method", ["auto", "least-squares"])
def test_auto_does_not_advise_auto(folder: Path, tmp_path: Path, method: str) -> None:
    table = np.loadtxt(folder / "monday.csv", delimiter=",", skiprows=1)
    table[:, 3] += 1.0 * np.random.default_rng(3).standard_normal(len(table))
    log = tmp_path / "noisy.csv"
    np.savetxt(log, table, delimiter=",", header="t,qm,qg,vir", comments="", fmt="%.12g")
    told = command("identify", log, "--bench", EMPS, "--method", method).stderr
    assert "above 20 %" in told
    assert ("or use --method auto" in told) == (method != "auto")
