"""The reference of a scenario's steps: holds, ramps, sines, long holds, one after another."""

from __future__ import annotations

import msgspec
import numpy as np
import pytest

from frictool.documents.quantity import Quantity
from frictool.documents.scenario import Scenario, Sine, Step
from frictool.simulate.reference import parts_of
from studies.rigs.step_scenario import scenario

T = 1e-3


def rad(value: float) -> Quantity:
    return Quantity(value=value, unit="rad")


def of(*steps: Step) -> list[np.ndarray]:
    return parts_of(msgspec.structs.replace(scenario(), steps=steps), T)


def test_a_hold_is_its_reference_for_its_samples() -> None:
    (part,) = of(Step(rad(40.0), 0.0204))
    np.testing.assert_array_equal(part, np.full(20, 40.0))


def test_a_ramp_goes_from_the_start_at_constant_speed_and_arrives_with_its_last_sample() -> None:
    (part,) = of(Step(ramp_to=rad(15.0), duration_s=0.1))
    assert (part[0], part[-1]) == (pytest.approx(5.1), 15.0)
    np.testing.assert_allclose(np.diff(part), 0.1, rtol=1e-9)


def test_a_sine_is_about_where_the_part_before_it_ended() -> None:
    held, wave, still = of(
        Step(rad(20.0), 0.1), Step(sine=Sine(rad(3.0), 2.0), duration_s=0.625), Step(hold_s=15.0)
    )
    np.testing.assert_allclose(
        wave, 20.0 + 3.0 * np.sin(2.0 * np.pi * 2.0 * T * np.arange(625)), rtol=0, atol=1e-12
    )
    assert held[-1] == wave[0]
    assert still.size == 15_000
    assert np.all(still == wave[-1])


def test_a_sine_may_have_a_centre_and_a_phase() -> None:
    (wave,) = of(Step(sine=Sine(rad(3.0), 2.0, 90.0, rad(30.0)), duration_s=0.5))
    assert (wave[0], wave[250]) == pytest.approx((33.0, 27.0))


def test_a_long_hold_may_come_first() -> None:
    (part,) = of(Step(hold_s=20.0))
    np.testing.assert_array_equal(part, np.full(20_000, 5.0))


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({}, "found none of them; allowed: exactly one of reference, ramp_to, sine, hold_s"),
        (
            {"reference": rad(1.0), "ramp_to": rad(2.0), "duration_s": 1.0},
            "found reference and ramp_to",
        ),
        ({"reference": rad(1.0)}, "duration_s: required with"),
        ({"hold_s": 20.0, "duration_s": 1.0}, "duration_s: required with"),
    ],
)
def test_a_step_that_says_too_much_or_too_little_is_refused(
    fields: dict[str, object], words: str
) -> None:
    with pytest.raises(ValueError, match=words):
        Step(**fields)


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"steps": ()}, "`steps` is empty"),
        ({"start": None}, "`start` is missing"),
        ({"plants": 3}, "required with `variants: random`"),
        ({"variants": "random"}, "required with `variants: random`"),
    ],
)
def test_a_scenario_that_says_too_much_or_too_little_is_refused(
    fields: dict[str, object], words: str
) -> None:
    made = {
        "format": "scenario/1",
        "name": "s",
        "axis": "rotary",
        "start": rad(1.0),
        "steps": (Step(rad(1.0), 1.0),),
    }
    with pytest.raises(ValueError, match=words):
        Scenario(**(made | fields))
