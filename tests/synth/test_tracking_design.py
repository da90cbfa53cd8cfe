"""Profile and feedforward of a design: limits from the drive and the worst plant, and refusals."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import msgspec
import pytest

from frictool.adapters.model_polytope import polytope
from frictool.control.jerk_limited_profile import ProfileLimits
from frictool.documents.bench import Winding
from frictool.documents.controller import Feedforward, Profile
from frictool.documents.design import Design
from frictool.documents.design_blocks import (
    FeedforwardDesign,
    FrictionCompensationDesign,
    PrefilterDesign,
    ProfileDesign,
    VelocityDesign,
)
from frictool.documents.model import Model
from frictool.documents.quantity import Quantity
from frictool.documents.resonances import Oscillation, Resonances
from frictool.errors import FrictoolError, NoSolutionError
from frictool.plant.polytope import PlantPoint
from frictool.synth.load_disturbance import disturbance
from frictool.synth.surrounding_blocks import SurroundingBlocks, blocks
from studies.rigs.clutch_model import clutch_model
from tests.synth.mass_documents import design as mass_design

replace = msgspec.structs.replace
VELOCITY = {"speed": Quantity(value=100.0, unit="rad/s")}


def asked(**changes: Any) -> Design:
    return replace(mass_design("pid"), axis="rotary", **changes)


def made(model: Model | None = None, peak: float = math.inf, **changes: Any) -> SurroundingBlocks:
    return blocks(model or clutch_model(), asked(**changes), peak)


def limits_of(*args: Any, profile: ProfileDesign, **options: Any) -> Profile:
    found = made(*args, profile=profile, **options).profile
    assert found is not None
    return found


def spare_drives(
    model: Model, limits: Profile, drives: Callable[[PlantPoint], float]
) -> list[float]:
    """Part of the drive that each vertex leaves at the profile's speed and acceleration."""
    load = disturbance(model).total
    return [
        1.0
        - (one.inertia * limits.acceleration + one.coulomb + load + one.viscous * limits.speed)
        / (one.constant * drives(one))
        for one in polytope(model).vertices
    ]


@pytest.mark.parametrize("share", [0.7, 0.9, 1.0])
@pytest.mark.parametrize("peak", [math.inf, 45.0])
def test_the_worst_plant_needs_its_share_of_the_drive(share: float, peak: float) -> None:
    model = clutch_model()
    found = limits_of(model, peak, profile=ProfileDesign(**VELOCITY, drive_share=share))
    limit = min(model.bench.actuator.limit.value, peak)
    spare = spare_drives(model, found, lambda _: limit)
    assert min(spare) == pytest.approx(1.0 - share, abs=1e-9)


def test_the_winding_leaves_less_at_speed() -> None:
    model = clutch_model()
    actuator = replace(model.bench.actuator, winding=Winding(0.2, 6.0))
    wound = replace(model, bench=replace(model.bench, actuator=actuator))
    found = limits_of(
        wound,
        profile=ProfileDesign(**VELOCITY, drive_share=1.0),
        velocity=VelocityDesign(filter_rad_s=300.0),
    )
    spare = spare_drives(wound, found, lambda one: (6.0 - 100.0 * one.constant) / 0.2)
    assert min(spare) == pytest.approx(0.0, abs=1e-9)


def test_the_smoothing_is_a_tenth_of_the_rise_or_a_period_of_the_resonance() -> None:
    model = clutch_model()
    slow = Quantity(value=1000.0, unit="rad/s^2")
    requested = ProfileDesign(**VELOCITY, acceleration=slow)
    assert limits_of(model, profile=requested).smoothing_samples == round(0.1 * 0.1 / 1e-3)
    poles = (Oscillation(400.0, 0.05), Oscillation(900.0, 0.05))
    flexible = replace(model, resonances=Resonances(poles, ("belt",)))
    samples = limits_of(flexible, profile=requested).smoothing_samples
    assert samples == math.ceil(2.0 * math.pi / 400.0 / 1e-3)


def test_a_jerk_is_kept_or_refused() -> None:
    limits = {**VELOCITY, "acceleration": Quantity(value=1000.0, unit="rad/s^2")}
    jerk = Quantity(value=70_000.0, unit="rad/s^3")
    found = limits_of(profile=ProfileDesign(**limits, jerk=jerk))
    as_limits = ProfileLimits(found.speed, found.acceleration, found.smoothing_samples)
    assert as_limits.jerk(1e-3) <= jerk.value
    fewer = ProfileLimits(found.speed, found.acceleration, found.smoothing_samples - 1)
    assert fewer.jerk(1e-3) > jerk.value
    low = Quantity(value=9000.0, unit="rad/s^3")
    with pytest.raises(FrictoolError, match=r"profile.jerk: found 9000 rad/s\^3; allowed"):
        made(profile=ProfileDesign(**limits, jerk=low))


def test_a_speed_that_uses_up_the_drive_is_refused() -> None:
    fast = Quantity(value=1e5, unit="rad/s")
    with pytest.raises(NoSolutionError, match=r"profile.speed: no effort is left"):
        made(profile=ProfileDesign(speed=fast))


def test_a_bench_without_a_top_speed_asks_for_one() -> None:
    model = clutch_model()
    mechanics = replace(model.bench.mechanics, top_speed=None)
    with pytest.raises(FrictoolError, match=r"profile.speed: missing"):
        made(
            replace(model, bench=replace(model.bench, mechanics=mechanics)), profile=ProfileDesign()
        )


def test_the_feedforward_has_the_models_values_and_the_provided_ones() -> None:
    found = made(profile=ProfileDesign(**VELOCITY), feedforward=FeedforwardDesign())
    step = 2.0 * math.pi / 56.0
    on = step / (10.0 * 1e-3)
    assert found.feedforward == Feedforward(1.32e-5, 3.81e-4, 0.099, on, 0.5 * on)
    assert {one.name for one in found.derived} >= {"feedforward.inertia", "profile.acceleration"}
    assert any("no margin depends on" in note for note in found.notes)
    provided = FeedforwardDesign(coulomb=Quantity(value=0.0, unit="N m"), filter_rad_s=300.0)
    raw = made(feedforward=provided).feedforward
    assert raw is not None
    assert (raw.coulomb, raw.filter_rad_s) == (0.0, 300.0)


def test_a_filter_that_alternates_is_refused() -> None:
    with pytest.raises(FrictoolError, match=r"feedforward.filter_rad_s: found 2000; allowed"):
        made(feedforward=FeedforwardDesign(filter_rad_s=2000.0))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (
            {"profile": ProfileDesign(), "prefilter": PrefilterDesign(30.0, 0.8)},
            "`profile` replaces `prefilter`",
        ),
        ({"feedforward": FeedforwardDesign()}, "filter_rad_s: needed without prefilter"),
        (
            {"feedforward": FeedforwardDesign(filter_rad_s=10.0), "profile": ProfileDesign()},
            "filter_rad_s: needed without prefilter",
        ),
        (
            {
                "feedforward": FeedforwardDesign(filter_rad_s=10.0),
                "friction_compensation": FrictionCompensationDesign("model"),
            },
            "both compensate the friction",
        ),
    ],
)
def test_blocks_that_do_not_fit_together(changes: dict[str, Any], words: str) -> None:
    fields = {name: getattr(asked(), name) for name in Design.__struct_fields__}
    with pytest.raises(ValueError, match=words):
        Design(**{**fields, "prefilter": None, **changes})
