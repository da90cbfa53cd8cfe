"""Friction over position and speed in the weak form: columns where it is there, none where it is
not, and the inertia beside them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from frictool.identify.estimators.weak import weak
from frictool.identify.fit_result import SlidingFit
from frictool.identify.methods import IdentificationSettings
from frictool.identify.regression.term_selection import clearly_better
from frictool.identify.rows.friction_columns import (
    HIGHEST,
    FrictionRows,
    bend_column,
    knee_column,
    names_to,
    position_columns,
)
from frictool.plant.axis import AxisParameters
from frictool.plant.weak_form import sampled_test_function
from studies.rigs.curve_logs import nonlinear_clutch
from studies.rigs.identification_rigs import clutch, record
from studies.rigs.sample_logs import TRUTH, sines

KNEE, ABOVE = 260.0, 3.81e-4


def found(truth: AxisParameters, seed: int = 3) -> SlidingFit:
    return weak([record(sines(seed, truth), truth)], clutch(), IdentificationSettings())


def test_a_constant_and_a_slope_get_no_further_columns() -> None:
    fit = found(TRUTH)
    assert (fit.details["position_order"], fit.details["knees"]) == (0, 0)
    assert fit.laws is None
    assert fit.why is None


def test_the_inertia_beside_friction_over_position_and_speed() -> None:
    """With a constant friction it comes out at nearly twice what it is."""
    truth = nonlinear_clutch()
    fit = found(truth)
    assert fit.details["position_order"] >= 4
    inertia, (regime,) = fit.parameters["inertia"], fit.laws.regimes
    assert inertia.low <= truth.inertia <= inertia.high
    assert inertia.half_width < 0.01 * truth.inertia
    assert regime.above.value == pytest.approx(KNEE, rel=0.01)
    assert regime.above.low <= KNEE <= regime.above.high
    assert regime.viscous.value == pytest.approx(ABOVE, rel=0.05)
    assert fit.parameters["viscous"].value < 0.01 * ABOVE  # below the knee there is none
    assert fit.residual < 0.01
    assert set(fit.parameters) == {
        "inertia",
        "viscous",
        "coulomb",
        "offset",
    }  # no column beside the four is a parameter


@pytest.mark.parametrize(
    ("change", "order", "knees"),
    [
        (lambda laws: laws._replace(regimes=()), 4, 0),
        (lambda laws: laws._replace(shape=None), 0, 1),
    ],
    ids=["position", "speed"],
)
def test_what_is_there_gets_its_columns_and_what_is_not_gets_none(
    change: Callable, order: int, knees: int
) -> None:
    truth = nonlinear_clutch()
    truth = truth._replace(laws=change(truth.laws))
    fit = found(truth)
    assert (fit.details["position_order"], fit.details["knees"]) == (order, knees)
    assert fit.parameters["inertia"].value == pytest.approx(
        truth.inertia, rel=5e-3
    )  # how often intervals hold: tests/accept


def test_columns_are_means_under_the_bell() -> None:
    """A slow reference: each row is the test function times its samples."""
    draw = np.random.default_rng(4)
    n, window = 80, 21
    sign, speed, kept = (
        np.sign(draw.standard_normal(n)),
        100.0 * draw.random(n),
        np.array([20, 37, 59]),
    )
    rows = FrictionRows(sign, speed, kept, sampled_test_function(window))
    for k, value, derivative in zip(
        kept, bend_column([rows], 40.0), knee_column([rows], 40.0), strict=True
    ):
        part = slice(k - window // 2 + 1, k + window // 2)
        assert value == pytest.approx(
            np.sum(sampled_test_function(window) * sign[part] * np.maximum(speed[part] - 40.0, 0.0))
        )
        assert derivative == pytest.approx(
            np.sum(sampled_test_function(window) * -sign[part] * (speed[part] > 40.0))
        )


def test_polynomials_of_the_position_have_no_mean() -> None:
    """So that Coulomb friction and offset beside them stay the means over the range."""
    truth = TRUTH
    log = record(sines(0, truth), truth)
    even = np.linspace(2.0, 50.0, log.position.size)
    rows = FrictionRows(
        np.ones(even.size),
        np.ones(even.size),
        np.arange(100, even.size - 100),
        sampled_test_function(11),
    )
    columns = position_columns(
        type(log)(
            "even", log.time, even, log.effort, log.piece, log.period, log.resolution, log.lag
        ),
        rows,
        2.0,
        50.0,
    )
    assert list(columns) == names_to(HIGHEST)
    for name, column in columns.items():
        assert abs(np.mean(column)) < 0.02, name
        assert np.max(np.abs(column)) <= 1.0 + 1e-9


def test_a_structure_has_to_beat_chance_and_be_worth_it() -> None:
    simpler = np.array([1.0, 2.0, 1.5, 1.2, 1.8, 1.1])
    assert clearly_better(0.3 * simpler, simpler, 0.95)
    assert not clearly_better(0.9 * simpler, simpler, 0.95)
    assert not clearly_better(None, simpler, 0.95)
