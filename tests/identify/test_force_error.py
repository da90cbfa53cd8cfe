"""One force error for every method: it depends on the log and the model's values alone, and grows
as they go wrong."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache
from pathlib import Path

import msgspec
import numpy as np
import pytest

from frictool.documents.laws import Backward, Laws, Load, Regime, Ripple
from frictool.documents.model import Model
from frictool.documents.quantity import Estimate, Quantity
from frictool.documents.registry import load
from frictool.documents.writing import to_yaml
from frictool.engine.effort_replay import FREE, replay, replay_parameters
from frictool.identify.force_error import (
    MOST_SAMPLES,
    force_error,
    friction_in_slip,
    motion_rows,
    nearest_values,
    slip_rows,
)
from frictool.identify.motion_record import make_record
from frictool.identify.rows.slip_fit import SMALLEST_SHARE, stroke_samples
from frictool.identify.rows.smoothing import choose_window
from frictool.plant.axis import rest
from frictool.plant.axis_friction_laws import AxisFrictionLevels
from frictool.plant.axis_friction_laws import AxisLaws as AxisLaws
from frictool.plant.axis_friction_laws import ViscousRegime as AxisRegime
from studies.command_line import run
from studies.rigs.identification_rigs import CLUTCH, ROOT, clutch, record
from studies.rigs.sample_logs import TRUTH, sines
from tests.support.driven_axes import driven, plain_axis
from tests.support.linear_axis import PERIOD, linear_bench

SINES = ROOT / "sample_logs" / "sines.csv"
SLIDING = {"inertia": 5.0, "viscous": 12.0, "coulomb": 8.0, "offset": 0.5}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("models")


@cache
def identified(folder: Path, method: str) -> tuple[float, Path]:
    """The force error that `identify --json` prints, and the model."""
    target = folder / f"{method}.yaml"
    result = run("identify", SINES, "--bench", CLUTCH, "--method", method, "--json", "-o", target)
    assert result.code == 0, result.stderr
    return json.loads(result.stdout)["force_error"], target


def validated(model: Path) -> float:
    result = run("validate", model, SINES, "--skip", "0", "--json")
    assert result.code == 0, result.stderr
    found: float = json.loads(result.stdout)["force_error_rel"]
    return found


@pytest.mark.parametrize(
    "method",
    [
        "least-squares",
        "weak",
        *(pytest.param(one, marks=pytest.mark.accept) for one in ("sines", "ordinary")),
    ],
)
def test_identify_the_model_and_validate_give_one_figure(folder: Path, method: str) -> None:
    printed, model = identified(folder, method)
    fit = load(model, Model).fit
    assert fit is not None
    assert printed == fit.force_error
    assert validated(model) == pytest.approx(printed, rel=1e-9)


def test_stroke_means_and_single_samples_give_one_figure_for_one_model(folder: Path) -> None:
    """Sines and least squares find the same friction here, and sines the inertia of the bench:
    their figures agree."""
    (one, _), (other, _) = identified(folder, "sines"), identified(folder, "least-squares")
    assert one == pytest.approx(other, rel=0.05)


def test_an_inertia_that_is_off_by_a_half_shows(folder: Path, tmp_path: Path) -> None:
    """An observer that follows the position would hide most of it."""
    printed, path = identified(folder, "weak")
    model = load(path, Model)
    inertia = model.parameters.inertia
    wrong = msgspec.structs.replace(inertia, value=1.5 * inertia.value, high=2.0 * inertia.value)
    changed = msgspec.structs.replace(
        model, parameters=msgspec.structs.replace(model.parameters, inertia=wrong)
    )
    target = tmp_path / "wrong.yaml"
    target.write_text(to_yaml(changed))
    rows = motion_rows([record(sines(1))], clutch())
    share = (
        0.5
        * TRUTH.inertia
        * np.sqrt(
            sum(np.sum(one.acceleration**2) for one in rows)
            / sum(np.sum(one.effort**2) for one in rows)
        )
    )
    error = validated(target)
    assert error == pytest.approx(share, rel=0.1)
    assert error > 3.0 * printed


@pytest.mark.parametrize("noise", [0.0, 1.0])
def test_the_truth_leaves_what_noise_leaves_in_the_band_of_the_motion(noise: float) -> None:
    log = driven(plain_axis())
    log = replace(
        log, effort=log.effort + noise * np.random.default_rng(1).standard_normal(log.effort.size)
    )
    (rows,) = motion_rows([log], linear_bench())
    found = force_error([rows], SLIDING, None)
    size = float(np.sqrt(np.mean(rows.effort**2)))
    assert found is not None
    assert found * size < 0.1 + noise  # the drive of `driven` is known to 0.1 N
    assert force_error([rows], {**SLIDING, "offset": 0.5 + 0.2 * size}, None) == pytest.approx(
        0.2, abs=0.02 + 2.0 * found
    )


def known(value: float, unit: str) -> Estimate:
    return Estimate(value, value, value, unit, source="identified")


def test_every_law_of_slip_is_the_engines() -> None:
    """Direction, a knee and a spring, simulated by the engine: the model that has them explains the
    effort, and the plain one does not."""
    axis = plain_axis(
        laws=AxisLaws(
            backward=AxisFrictionLevels(16.0, 9.0, 9.0), regimes=(AxisRegime(0.3, 20.0, 30.0),)
        )
    )
    draw, time = np.random.default_rng(3), np.arange(12_000) * PERIOD
    effort = 18.0 * np.sin(2.0 * np.pi * 0.9 * time) + 9.0 * np.sin(
        2.0 * np.pi * 0.37 * time + draw.uniform(0.0, 6.0)
    )
    x, v = np.empty(time.size), np.empty(time.size)
    assert (
        replay(
            replay_parameters(axis), np.array([20.0]), rest(), effort, effort, FREE, PERIOD, x, v
        )
        == 0
    )
    log = replace(driven(plain_axis()), time=time, position=x, effort=effort)
    laws = Laws(
        backward=Backward(known(16.0, "N s/m"), known(9.0, "N")),
        regimes=(Regime(Quantity(0.3, unit="m/s"), known(20.0, "N s/m"), known(30.0, "N s/m")),),
        load=Load(known(20.0, "N/m")),
    )
    rows = motion_rows([log], linear_bench())
    found, without = force_error(rows, SLIDING, laws), force_error(rows, SLIDING, None)
    assert found is not None
    assert without is not None
    assert found < 1e-3
    assert without > 20.0 * found


def test_the_fall_over_speed_starts_from_the_breakaway() -> None:
    values = {**SLIDING, "breakaway": 12.0, "stribeck_velocity": 0.1}
    speed = np.array([1e-6, 0.1, 1.0])
    expected = 8.0 + 4.0 * np.exp(-((speed / 0.1) ** 2)) + 12.0 * speed
    assert friction_in_slip(values, None, np.zeros(3), speed) == pytest.approx(expected)
    assert friction_in_slip(values, None, np.zeros(3), -speed) == pytest.approx(-expected)


def test_a_long_log_is_judged_by_parts_of_it() -> None:
    log = driven(plain_axis(), samples=MOST_SAMPLES + 100_000)
    rows = motion_rows([log], linear_bench())
    assert sum(one.index.size for one in rows) <= MOST_SAMPLES
    whole = force_error(motion_rows([log.part(slice(0, 100_000))], linear_bench()), SLIDING, None)
    assert force_error(rows, SLIDING, None) == pytest.approx(whole, rel=0.3)


def test_a_ripple_shorter_than_the_window_is_smoothed_with_the_effort() -> None:
    """The true model leaves nothing, although the smoothed effort contains little of the ripple."""
    time = np.arange(8000) * PERIOD
    rate, amplitude, wave = 3.0, 0.1, 2.0 * np.pi / 1e-3  # 1/s, m, 1/m
    position = amplitude * np.sin(rate * time)
    velocity = amplitude * rate * np.cos(rate * time)
    effort = (
        SLIDING["inertia"] * -(rate**2) * position
        + SLIDING["viscous"] * velocity
        + SLIDING["coulomb"] * np.sign(velocity)
        + SLIDING["offset"]
        + 20.0 * np.sin(wave * position)
    )
    log = make_record("cogging", time, position, effort, 1e-6, lag=1e-3)
    size = Estimate(20.0, 19.0, 21.0, "N", source="identified")
    none = Estimate(0.0, -1.0, 1.0, "N", source="identified")
    ripple = Ripple(1.0, Quantity(1e-3, unit="m"), size, none)
    rows = motion_rows([log], linear_bench())
    error = force_error(rows, SLIDING, Laws(load=Load(ripple=ripple)))
    assert error is not None
    assert error < 0.02


@pytest.mark.parametrize(("moving", "halvings"), [(60, 2), (100, 2), (250, 0)])
def test_the_window_is_halved_until_the_axis_slips_over_it(moving: int, halvings: int) -> None:
    """The axis moves for `moving` samples of each stroke and sticks for the rest of it.

    The window of 201 samples has to be shorter than the motion without its last count.
    """
    stroke = 0.5 - 0.5 * np.cos(np.pi * np.clip(np.arange(1200) / moving, 0.0, 1.0))
    position = np.round(50.0 * np.tile(np.append(stroke, 1.0 - stroke), 4)) * 1e-3
    still = np.zeros(position.size)
    log = make_record("log", np.arange(position.size) * PERIOD, position, still, 1e-3, 0.0)
    rows = slip_rows(log, linear_bench())
    assert rows is not None
    longest = choose_window(log, stroke_samples(log), SMALLEST_SHARE)
    assert rows.window == pytest.approx(longest * 0.5**halvings, abs=1.0)


def test_values_within_ranges_minimise_the_force_error() -> None:
    """A range without the true value gives one of its ends; other values are not changed."""
    rows = motion_rows([driven(plain_axis())], linear_bench())
    wrong = {**SLIDING, "coulomb": 1.0, "inertia": 1.0}
    ranges = {"coulomb": (0.0, 100.0), "inertia": (0.0, 100.0)}
    found = nearest_values(rows, wrong, None, ranges)
    assert found == pytest.approx(SLIDING, rel=0.02)
    ended = nearest_values(rows, wrong, None, {**ranges, "coulomb": (10.0, 20.0)})
    assert ended["coulomb"] == 10.0
    errors = [force_error(rows, values, None) for values in (found, ended, wrong)]
    assert errors == sorted(errors, key=float)
    for factor in (0.99, 1.01):
        other = force_error(rows, {**ended, "inertia": factor * ended["inertia"]}, None)
        assert other is not None
        assert errors[1] is not None
        assert other > errors[1]
