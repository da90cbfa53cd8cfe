"""The blocks around the linear controller: what a design leaves open is filled by the rule that is
stated, and told; or it is refused."""

from __future__ import annotations

import math
from typing import Any

import msgspec
import numpy as np
import pytest

from frictool.control.friction_compensation import position_compensation
from frictool.documents.bench import Winding
from frictool.documents.design import Design
from frictool.documents.design_blocks import (
    FrictionCompensationDesign,
    LimiterDesign,
    PositionLawDesign,
    PrefilterDesign,
    VelocityDesign,
)
from frictool.documents.laws import Backward, FrictionOverPosition, Laws, Polynomial
from frictool.documents.model import Model
from frictool.documents.provenance import Provenance
from frictool.documents.quantity import Estimate, PositionSpan, Quantity
from frictool.errors import FrictoolError, NoSolutionError
from frictool.synth.design import design_controller
from frictool.synth.surrounding_blocks import SurroundingBlocks, blocks
from frictool.verify.recheck import recheck
from studies.rigs.clutch_model import clutch_model
from tests.support.single_block import Block, given
from tests.synth.mass_documents import design as mass_design
from tests.synth.mass_documents import model as mass_model
from tests.synth.mass_documents import spec as mass_spec

STEP = 2.0 * math.pi / 56.0
PREFILTER = PrefilterDesign(30.0, 0.8)
FRICTION = 0.099  # of the clutch's model


def asked(**changes: Any) -> Design:
    """A position design of the clutch, whose linear part nobody reads here."""
    return msgspec.structs.replace(mass_design("pid"), axis="rotary", **changes)


def made(*, model: Model | None = None, **changes: Any) -> SurroundingBlocks:
    return blocks(model or clutch_model(), asked(**changes))


def told(found: SurroundingBlocks) -> dict[str, float]:
    return {one.name: one.value for one in found.derived}


def estimate(value: float, unit: str) -> Estimate:
    return Estimate(value=value, low=value, high=value, unit=unit, source="bench")


def rad(value: float) -> Quantity:
    return Quantity(value=value, unit="rad")


def test_the_filter_is_ten_times_the_prefilters_frequency() -> None:
    found = made(prefilter=PREFILTER, limiter=LimiterDesign("energy", band=rad(2.0)))
    assert (found.velocity.bandwidth_rad_s, found.velocity.order) == (300.0, 2)  # (5.70)
    assert told(found) == {"velocity.filter_rad_s": 300.0}


def test_without_a_prefilter_the_filter_has_to_be_given() -> None:
    with pytest.raises(
        FrictoolError,
        match=r"velocity.filter_rad_s: missing.*0: no filter",
    ):
        made(limiter=LimiterDesign("energy"))
    assert (
        made(
            limiter=LimiterDesign("energy"), velocity=VelocityDesign(filter_rad_s=0.0)
        ).velocity.bandwidth_rad_s
        == 0.0
    )
    given = made(
        limiter=LimiterDesign("energy"), velocity=VelocityDesign(order=1, filter_rad_s=200.0)
    ).velocity
    assert (given.bandwidth_rad_s, given.order) == (200.0, 1)


def test_a_velocity_that_nothing_reads_is_refused() -> None:
    with pytest.raises(FrictoolError, match="velocity: no block of this design reads a speed"):
        made(
            limiter=LimiterDesign("error", band=rad(2.0)),
            velocity=VelocityDesign(filter_rad_s=100.0),
        )
    base, replace = clutch_model(), msgspec.structs.replace
    wound = replace(base.bench.actuator, winding=Winding(resistance_ohm=0.2, voltage_v=12.0))
    model = replace(base, bench=replace(base.bench, actuator=wound))
    assert (
        made(model=model, velocity=VelocityDesign(filter_rad_s=100.0)).velocity.bandwidth_rad_s
        == 100.0
    )  # the winding reads it
    assert made(model=model, prefilter=PREFILTER).velocity.bandwidth_rad_s == 300.0


@pytest.mark.parametrize("bandwidth", [2000.0, 1e5])
def test_a_filter_that_sampling_does_not_carry_is_refused(bandwidth: float) -> None:
    with pytest.raises(FrictoolError, match="allowed: below 2000 rad/s"):
        made(limiter=LimiterDesign("energy"), velocity=VelocityDesign(filter_rad_s=bandwidth))


def test_the_limiter_has_the_models_friction_and_the_encoders_step() -> None:
    found = made(prefilter=PREFILTER, limiter=LimiterDesign("energy"))
    assert found.limiter is not None
    assert (found.limiter.inertia, found.limiter.coulomb) == (1.32e-5, FRICTION)
    assert told(found)["limiter.band"] == found.limiter.band == pytest.approx(STEP)
    assert any("nonlinear" in note for note in found.notes)


def test_a_band_below_the_encoders_step_is_refused() -> None:
    with pytest.raises(
        FrictoolError,
        match=r"limiter.band: found 0.1 rad; allowed: at least the encoder's step, 0.112",
    ):
        made(limiter=LimiterDesign("error", band=rad(0.1)))


def test_the_cut_off_on_the_error_alone_reads_neither_friction_nor_speed() -> None:
    found = made(limiter=LimiterDesign("error", band=rad(2.0)))
    assert found.limiter is not None
    assert (found.limiter.inertia, found.limiter.coulomb, found.velocity.bandwidth_rad_s) == (
        0.0,
        0.0,
        0.0,
    )


def test_the_virtual_frictions_slope_leaves_it_ten_samples() -> None:
    virtual = Quantity(value=0.05, unit="N m")
    found = made(
        prefilter=PREFILTER, limiter=LimiterDesign("energy", band=rad(2.0), virtual_coulomb=virtual)
    ).limiter
    assert found is not None
    # J v' = -(F_cv/v_r) v: the time constant of the linear brake is 10 samples of 1 ms
    assert 1.32e-5 / (found.virtual_coulomb / found.virtual_speed) == pytest.approx(10e-3)


def test_a_brake_that_would_not_come_to_rest_is_refused() -> None:
    limiter = mass_design("smooth_limiter_virtual").limiter
    assert limiter is not None
    steep = msgspec.structs.replace(limiter, virtual_speed=Quantity(value=4e-4, unit="m/s"))
    with pytest.raises(
        NoSolutionError,
        match=r"virtual friction is unstable at rest, at vertex v1 with 0 samples .*; raise "
        r"limiter.virtual_speed",
    ):
        design_controller(
            mass_model("smooth"),
            mass_spec(),
            mass_design("smooth_limiter_virtual", limiter=steep),
            Provenance("a test", "0"),
        )
    controller = design_controller(
        mass_model("smooth"),
        mass_spec(),
        mass_design("smooth_limiter_virtual"),
        Provenance("a test", "0"),
    )
    recheck(controller)
    assert controller.limiter is not None
    spoilt = msgspec.structs.replace(controller.limiter, virtual_speed=4e-4)
    with pytest.raises(NoSolutionError, match="virtual friction is unstable at rest"):
        recheck(msgspec.structs.replace(controller, limiter=spoilt))


def test_friction_is_compensated_with_the_models_levels() -> None:
    found = made(
        prefilter=PREFILTER, friction_compensation=FrictionCompensationDesign("model", gain=0.8)
    )
    compensation = found.friction_compensation
    assert compensation is not None
    assert (
        compensation.coulomb,
        compensation.viscous,
        compensation.gain,
        compensation.velocity,
    ) == (FRICTION, 3.81e-4, 0.8, "measured")
    # one count through (5.70) at 300 rad/s: the peak of w^2 t exp(-w t) is w/e
    assert compensation.smoothing_speed == pytest.approx(STEP * 300.0 / math.e, rel=0.02)
    assert told(found)["friction_compensation.smoothing_speed"] == compensation.smoothing_speed


def test_friction_by_direction_with_a_fall_is_compensated_by_its_curve() -> None:
    """F_c + (F_s - F_c) exp(-(v/v_s)^2) + sigma_v v (2.33)-(2.34) with each direction's levels."""
    base, replace = clutch_model(), msgspec.structs.replace
    parameters = replace(
        base.parameters,
        breakaway=estimate(0.15, "N m"),
        stribeck_velocity=estimate(30.0, "rad/s"),
    )
    laws = Laws(backward=Backward(coulomb=estimate(0.07, "N m"), breakaway=estimate(0.1, "N m")))
    found = made(
        model=replace(base, law="stribeck", parameters=parameters, laws=laws),
        prefilter=PREFILTER,
        friction_compensation=FrictionCompensationDesign(
            "model", smoothing_speed=Quantity(value=5.0, unit="rad/s"), gain=0.8
        ),
    ).friction_compensation
    assert found is not None
    assert (found.coulomb, found.viscous, found.gain) == (0.0, 0.0, 0.8)
    assert {-5.0, 5.0, 30.0, -30.0} < set(found.speeds)
    for speed, effort in zip(found.speeds, found.efforts, strict=True):
        coulomb, breakaway = (FRICTION, 0.15) if speed > 0.0 else (0.07, 0.1)
        fall = (breakaway - coulomb) * math.exp(-((speed / 30.0) ** 2))
        assert effort == pytest.approx(
            math.copysign(coulomb + fall + 3.81e-4 * abs(speed), speed), rel=1e-12
        )


@pytest.mark.parametrize("backward", [None, (1.0, 0.02)])
def test_friction_over_the_position_is_compensated_where_the_axis_is(
    backward: tuple[float, ...] | None,
) -> None:
    """The drive of the program balances the friction of the engine's law at every place of a slip,
    within 1 % of the Coulomb friction; beyond the travel the friction is constant."""
    base = clutch_model()
    curve = Polynomial(forward=(1.0, -0.01, 4e-4), backward=backward)
    law = FrictionOverPosition(over=PositionSpan(0.0, 50.0, "rad"), coulomb=curve)
    model = msgspec.structs.replace(base, laws=Laws(position=law))
    found = made(
        model=model,
        prefilter=PREFILTER,
        friction_compensation=FrictionCompensationDesign(
            "model", smoothing_speed=Quantity(value=5.0, unit="rad/s")
        ),
    ).friction_compensation
    assert found is not None
    assert (len(found.backward) > 0) == (backward is not None)
    block = Block(
        lambda p: position_compensation(
            p,
            given(p, "x"),
            given(p, "s"),
            found.positions,
            found.forward,
            found.backward or found.forward,
        )
    )
    fine = np.linspace(0.0, 50.0, 20_001)
    for direction, powers in ((1.0, curve.forward), (-1.0, backward or curve.forward)):
        mean = float(np.mean(np.polynomial.polynomial.polyval(fine, powers)))
        for x in (-30.0, 0.0, 7.3, 21.0, 33.3, 50.0, 80.0):
            local = float(np.polynomial.polynomial.polyval(min(max(x, 0.0), 50.0), powers)) / mean
            wanted = direction * FRICTION * (local - 1.0)
            assert block.step(x=x, s=direction) == pytest.approx(wanted, abs=0.0101 * FRICTION)
    assert max(map(abs, found.forward)) > 0.1 * FRICTION


def test_an_observer_takes_the_models_inertia() -> None:
    found = made(
        prefilter=PREFILTER,
        friction_compensation=FrictionCompensationDesign("observer", observer_rad_s=50.0),
    ).friction_compensation
    assert found is not None
    assert (found.source, found.inertia, found.observer_rad_s) == ("observer", 1.32e-5, 50.0)


def test_a_measured_speed_tells_no_smoothing_speed() -> None:
    compensation = FrictionCompensationDesign("model")
    with pytest.raises(
        FrictoolError,
        match=r"friction_compensation.smoothing_speed: missing, and a measured speed has no "
        r"default",
    ):
        made(velocity=VelocityDesign(source="measured"), friction_compensation=compensation)


def test_without_friction_there_is_nothing_to_compensate_or_to_stop_with() -> None:
    base, replace = mass_model(), msgspec.structs.replace
    parameters = replace(base.parameters, coulomb=replace(base.parameters.coulomb, value=0.0))
    smooth, measured = replace(base, parameters=parameters), VelocityDesign(source="measured")
    speed = Quantity(value=1e-3, unit="m/s")
    with pytest.raises(FrictoolError, match="no friction to compensate"):
        made(
            model=smooth,
            velocity=measured,
            friction_compensation=FrictionCompensationDesign("model", smoothing_speed=speed),
        )
    with pytest.raises(FrictoolError, match="`condition: energy` needs friction"):
        made(model=smooth, velocity=measured, limiter=LimiterDesign("energy"))


def test_a_position_law_without_a_band_has_the_encoders_step() -> None:
    cascade = msgspec.structs.replace(
        mass_design("pi_root"),
        axis="rotary",
        position_law=PositionLawDesign("none", formula="sqrt(F/J)"),
    )
    found = blocks(clutch_model(), cascade)
    assert found.position_law is not None
    assert told(found)["position_law.band"] == found.position_law.band == pytest.approx(STEP)
    proportional = msgspec.structs.replace(
        cascade, position_law=PositionLawDesign("none", kind="proportional", gain_per_s=7.0)
    )
    law = blocks(clutch_model(), proportional).position_law
    assert law is not None
    assert (law.gain, law.band, law.formula) == (7.0, 0.0, None)
