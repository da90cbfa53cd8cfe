"""The method of sines (4.34)-(4.39) on the mass of table 4.1 and on the thesis's non-linear
clutch."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest

from frictool.documents.laws import Laws
from frictool.documents.quantity import Quantity
from frictool.identify.assess.identifiability import STROKE_MEANS
from frictool.identify.estimators import auto as auto_module
from frictool.identify.estimators.least_squares import least_squares
from frictool.identify.estimators.piecewise_friction import StrokeMeans
from frictool.identify.estimators.sines import StrokeRows, _of_fixed, sines
from frictool.identify.fit_result import Interval, SlidingFit, UnusableLogs
from frictool.identify.methods import IdentificationSettings
from frictool.identify.motion_record import make_record
from studies.rigs.curve_logs import mass_sines
from studies.rigs.identification_rigs import MASS, clutch, mass_bench, record
from studies.rigs.sample_logs import TRUTH
from studies.rigs.sample_logs import sines as half_sines
from tests.support.friction_knees import false_knees, true_knees
from tests.support.loaded_axis import rotary_bench


@pytest.mark.parametrize("step", [1e-4, 1e-2])
def test_sines_of_table_4_1_are_not_biased_by_the_sticks(tmp_path: Path, step: float) -> None:
    """-0.4/+0.4 % was reached with the gate, -0.6/+0.9 % at a step at which weighted least squares
    fails by 100 %; +9/-21 % without."""
    fit = sines(mass_sines(1, step), mass_bench(tmp_path), IdentificationSettings())
    assert fit.parameters["viscous"].value == pytest.approx(
        MASS.viscous, rel=4e-3 if step < 1e-3 else 6e-3
    )
    assert fit.parameters["coulomb"].value == pytest.approx(
        MASS.coulomb, rel=4e-3 if step < 1e-3 else 9e-3
    )
    assert "inertia" in fit.refused
    assert fit.laws is None


def test_the_clutch_of_the_sample_logs() -> None:
    fit = sines([record(half_sines(3))], clutch(), IdentificationSettings())
    for name in ("viscous", "coulomb", "offset"):
        assert fit.parameters[name].low <= getattr(TRUTH, name) <= fit.parameters[name].high
    assert fit.details["knees"] == 0


def test_plain_clutches_have_no_knee() -> None:
    """A seeded few of the accept check's: with the bench's inertia six plain clutches in ten used
    to show a knee."""
    assert false_knees(3) == 0


@pytest.mark.accept
def test_a_knee_is_found() -> None:
    """tests/identify/test_friction_map.py finds the knee of another log."""
    assert true_knees(1)[0] == 1


def test_one_speed_tells_one_number(tmp_path: Path) -> None:
    logs = [mass_sines(seed)[2] for seed in (2, 3)]
    with pytest.raises(
        UnusableLogs, match=r"all strokes have nearly the same speed .* record sines of several"
    ):
        sines(logs, mass_bench(tmp_path), IdentificationSettings())


def test_one_direction_is_refused(tmp_path: Path) -> None:
    n = 4000
    still = make_record(
        "one way", np.arange(n) * 1e-3, np.linspace(0.0, 4.0, n), np.ones(n), 1e-4, 0.0
    )
    with pytest.raises(UnusableLogs, match="forward and 0 backward"):
        sines([still], mass_bench(tmp_path), IdentificationSettings())


def test_an_uncertain_fixed_parameter_moves_the_others_as_a_weighted_fit_does() -> None:
    """The shift of Coulomb friction for an offset at the end of its range, by normal equations."""
    random = np.random.default_rng(3)
    sign = np.repeat([1.0, -1.0], [7, 4])
    weight = random.uniform(1.0, 9.0, sign.size)
    means = StrokeMeans(
        sign[:, None],
        random.normal(size=sign.size),
        sign,
        weight,
        np.arange(sign.size),
        np.ones(sign.size),
        np.arange(sign.size),
    )
    rows = StrokeRows(np.zeros(sign.size), np.zeros(sign.size), means)
    found = _of_fixed(rows, means.columns, np.array([0.1]), {"offset": Interval(1.0, 0.7, 1.2)})
    shift = 0.3 * np.sum(weight**2 * sign) / np.sum(weight**2)
    assert found == pytest.approx([np.hypot(0.1, shift)])


def test_auto_uses_least_squares_if_means_over_strokes_have_no_intervals(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    time = np.arange(12_000) * 1e-3
    rate = 4.0 * np.pi
    size = np.repeat([1.0, 4.0], 6000)
    position = size * np.cos(rate * time + 0.1)
    velocity = -size * rate * np.sin(rate * time + 0.1)
    effort = -1e-3 * rate**2 * position + 0.01 * velocity + 0.1 * np.sign(velocity)
    effort += np.random.default_rng(1).normal(0.0, 2e-3, time.size)
    counts = 0.05 * np.floor(position / 0.05)
    record = make_record("log", time, counts, effort, resolution=0.05, lag=1.0)
    mechanics = msgspec.structs.replace(
        rotary_bench(None).mechanics,
        inertia=Quantity(1e-3, 5e-4, 2e-3, "kg m^2"),
        viscous=Quantity(0.01, 0.002, 0.03, "N m s/rad"),
        coulomb=Quantity(0.1, 0.02, 0.3, "N m"),
    )
    bench = msgspec.structs.replace(rotary_bench(None), mechanics=mechanics)
    settings = IdentificationSettings()
    fit = least_squares([record], bench, settings)
    line = {name: one for name, one in fit.parameters.items() if name != "inertia"}
    knee = replace(fit, parameters=line, laws=Laws())
    unknown = {name: Interval.around(one.value, np.inf) for name, one in line.items()}

    def chosen(means: SlidingFit) -> str | None:
        original = auto_module.run

        def stroke_means(method: str, *rest: Any) -> SlidingFit:
            return means if method == STROKE_MEANS else original(method, *rest)

        with monkeypatch.context() as patch:
            patch.setattr(auto_module, "run", stroke_means)
            return auto_module.auto([record], bench, settings).method

    assert chosen(knee) == STROKE_MEANS
    assert chosen(replace(knee, parameters=unknown)) == "least-squares"
