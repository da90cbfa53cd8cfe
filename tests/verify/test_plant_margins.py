"""Margins of a controller around any plant: those of the rebuilt loop, and of what a scheduled
controller runs with."""

from __future__ import annotations

import dataclasses

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.documents.controller import Controller, Velocity
from frictool.plant.polytope import PARAMETERS, PlantPoint
from frictool.verify.certified_intervals import parameters_outside
from frictool.verify.document_box import box_of
from frictool.verify.document_check import check_feedback
from frictool.verify.feedback_loops import feedbacks_of
from frictool.verify.logged_plant import LoggedPlant
from frictool.verify.plant_margins import PlantMargins
from studies.rigs.step_scenario import controller
from tests.support.observed_loop import by_speed, tracking

CONTROLLERS = {
    "eta": controller(),
    "speed": by_speed(),
    "filtered": msgspec.structs.replace(
        by_speed(), velocity=Velocity(bandwidth_rad_s=400.0, order=2)
    ),
    "observed": msgspec.structs.replace(
        by_speed(), velocity=Velocity(source="observer", observer=tracking())
    ),
    "at once": msgspec.structs.replace(controller(), delay_samples=0),
    "late": msgspec.structs.replace(controller(), delay_samples=3),
}


def rebuilt(document: Controller, point: PlantPoint) -> float:
    lag = document.bench.actuator.loop_time_constant_s
    return min(
        check_feedback(loop, point.rates, lag, document.delay_samples).modulus_margin
        for loop in feedbacks_of(document)
    )


@pytest.mark.parametrize("name", CONTROLLERS)
@settings(max_examples=25, deadline=None)
@given(factors=st.tuples(*[st.floats(0.05, 4.0)] * 3))
def test_the_margin_is_that_of_the_rebuilt_loop(
    name: str, factors: tuple[float, float, float]
) -> None:
    """Also around plants on which the loop is unstable."""
    inertia, viscous, constant = (
        value * factor for value, factor in zip((1.3e-5, 3.8e-4, 0.0134), factors, strict=True)
    )
    point = PlantPoint("", inertia, viscous, 0.1, constant)
    assert PlantMargins(CONTROLLERS[name]).at(point) == pytest.approx(
        rebuilt(CONTROLLERS[name], point), rel=5e-6
    )


def test_of_several_slopes_and_constants_the_worst_counts() -> None:
    margins = PlantMargins(controller())
    plant = LoggedPlant(1.2e-5, 3e-4, 0.1, 0.0134, (0.0, 3e-4, 9e-4), (0.012, 0.016))
    assert margins(plant) == min(
        margins.at(PlantPoint("", 1.2e-5, s, 0.1, k)) for s in plant.slopes for k in plant.constants
    )
    assert LoggedPlant.of_text(plant.to_text()) == plant


@pytest.mark.parametrize("text", ["", "{}", "[1]", '{"inertia": 1}', '{"inertia": null}', "nan"])
def test_a_text_that_is_no_plant_is_none(text: str) -> None:
    assert LoggedPlant.of_text(text) is None


def test_the_box_of_a_controller_without_a_certificate_is_that_of_its_vertices() -> None:
    box = box_of(controller())
    assert box["inertia"] == (1.11e-5, 1.53e-5)
    assert set(box) == set(PARAMETERS)
    assert parameters_outside(controller(), box) == ()
    beyond = {"inertia": (4.9e-6, 1.2e-5), "coulomb": (0.0, 1.0), "constant": (0.0134, 0.0134)}
    assert parameters_outside(controller(), beyond) == (
        "inertia 4.9e-06 to 1.2e-05 kg m^2, verified 1.11e-05 to 1.53e-05",
        "coulomb 0 to 1 N m, verified 0.018 to 0.18",
    )
    assert parameters_outside(controller(), {"constant": (float("nan"), 0.0134)})


def test_rounding_of_the_ends_is_not_outside() -> None:
    low, high = box_of(controller())["inertia"]
    assert (
        parameters_outside(
            controller(),
            {"inertia": (float(np.nextafter(low, 0.0)), float(np.nextafter(high, 1.0)))},
        )
        == ()
    )
    assert parameters_outside(controller(), {"inertia": (low, 1.0001 * high)})


def test_fields_of_a_plant_are_those_of_its_text() -> None:
    plant = LoggedPlant(1.2e-5, 3e-4, 0.1, 0.0134, (3e-4,), (0.0134,))
    assert list(vars(plant)) == [field.name for field in dataclasses.fields(LoggedPlant)]
