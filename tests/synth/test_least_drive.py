"""Drives that are too weak for the friction are refused, and no drive that is strong enough."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from msgspec import structs

from frictool.documents.bench import Bench
from frictool.documents.design import Design
from frictool.documents.laws import Gravity, Laws, Load
from frictool.documents.model import Model
from frictool.documents.quantity import Estimate, Quantity, Span
from frictool.documents.registry import load
from frictool.documents.scenario import Scenario, Step
from frictool.documents.spec import Spec
from frictool.errors import NoSolutionError
from frictool.plan.assumed_axis import assumed_axis
from frictool.synth.feasibility import check_feasible
from frictool.synth.least_drive import check_least_drive, least_drive
from studies.rigs.clutch_model import ROOT, clutch_model

SPEED = load(ROOT / "configs/clutch/designs/speed.yaml", Design)
LOW, HIGH, ERROR = -1.2, 1.0, 0.02  # rad: targets, and static error
Strategy = Callable[[float, float, float], float]  # (position, speed, target) -> sign of the drive


def towards(position: float, speed: float, target: float) -> float:
    return math.copysign(1.0, target - position)


def pumping(position: float, speed: float, target: float) -> float:
    return math.copysign(1.0, speed) if speed else math.copysign(1.0, target - position)


def bench(constant: float = 2.0) -> Bench:
    rig = clutch_model().bench
    mechanics = structs.replace(
        rig.mechanics,
        backlash=None,
        backlash_coulomb=None,
        breakaway=None,
        inertia=Quantity(0.5, unit="kg m^2"),
        viscous=Quantity(0.0, unit="N m s/rad"),
        coulomb=Quantity(1.0, unit="N m"),
        travel=Span(-3.0, 3.0, "rad"),
    )
    actuator = structs.replace(
        rig.actuator, constant=Quantity(constant, unit="N m/A"), loop_time_constant_s=0.0
    )
    return structs.replace(rig, mechanics=mechanics, actuator=actuator)


def machine(coulomb: float, breakaway: float, gravity: float) -> Model:
    values = {"inertia": 0.5, "viscous": 0.0, "coulomb": coulomb, "offset": 0.0}
    model = assumed_axis(bench(), {**values, "breakaway": breakaway})
    sine, cosine = (
        Estimate(value, value, value, "N m", source="assumed") for value in (gravity, 0.0)
    )
    laws = Laws(load=Load(gravity=Gravity(sine, cosine))) if gravity else None
    return structs.replace(model, laws=laws)


def there_and_back() -> Scenario:
    targets = (HIGH, LOW, HIGH)
    return Scenario(
        format="scenario/1",
        name="steps",
        axis="rotary",
        start=Quantity(LOW, unit="rad"),
        steps=tuple(Step(reference=Quantity(one, unit="rad"), duration_s=4.0) for one in targets),
    )


def spec(**requirements: object) -> Spec:
    return Spec(format="spec/1", name="s", axis="rotary", drive="current", **requirements)


ARRIVING = spec(response_time_95_s=2.0, static_error=Quantity(ERROR, unit="rad"))


def bound(model: Model) -> float:
    today = model.parameters
    plant = {"coulomb": today.coulomb.value, "constant": 2.0, "breakaway": today.breakaway.value}
    return least_drive(model, ARRIVING, there_and_back(), [{}, plant]).drive


def completes(model: Model, drive: float, strategy: Strategy) -> bool:
    """Simulate the steps with a drive of +-`drive`; return True if every target is passed.

    Small semi-implicit steps without viscous friction; a target counts as reached once passed.
    """
    today, load = model.parameters, None if model.laws is None else model.laws.load
    gravity = 0.0 if load is None or load.gravity is None else load.gravity.sine.value
    x, v, step = LOW, 0.0, 2e-4
    for target in (HIGH, LOW, HIGH):
        side = math.copysign(1.0, target - x)
        for _ in range(60_000):
            effort = 2.0 * drive * strategy(x, v, target) - gravity * math.sin(x)
            if v == 0.0 and abs(effort) <= today.breakaway.value:
                friction = effort
            else:
                friction = today.coulomb.value * math.copysign(1.0, v or effort)
            fast = v + step * (effort - friction) / 0.5
            v = 0.0 if v * fast < 0.0 else fast
            x += step * v
            if side * (x - target) >= -ERROR:
                break
        else:
            return False
    return True


@pytest.mark.parametrize("seed", range(6))
def test_no_controller_completes_the_steps_with_a_drive_below_the_bound(seed: int) -> None:
    draw = np.random.default_rng([seed, 3])
    coulomb = float(draw.uniform(0.5, 2.0))
    breakaway = coulomb * float(draw.uniform(1.0, 1.4))
    model = machine(coulomb, breakaway, float(draw.uniform(0.0, 1.5)))
    least = bound(model)
    assert least > 0.0
    for strategy in (towards, pumping):
        assert not completes(model, 0.99 * least, strategy)


@pytest.mark.parametrize("coulomb", [0.5, 1.5])
def test_without_a_load_the_bound_is_the_drive_that_overcomes_the_breakaway(coulomb: float) -> None:
    model = machine(coulomb, 1.2 * coulomb, 0.0)
    least = bound(model)
    assert least == pytest.approx(1.2 * coulomb / 2.0)
    assert completes(model, 1.001 * least, towards)
    assert not completes(model, 0.999 * least, towards)


def test_a_load_helps_one_way_and_not_there_and_back() -> None:
    """A step of |HIGH - LOW| releases energy of the load; after a step back, only the errors do."""
    model, plants = machine(1.0, 1.0, 0.8), [{"coulomb": 1.0, "constant": 2.0, "breakaway": 1.0}]
    scenario = there_and_back()
    one_way = structs.replace(scenario, steps=scenario.steps[:1])
    moving = spec(response_time_95_s=2.0)
    assert least_drive(model, moving, one_way, plants).drive == pytest.approx(0.5 * (1.0 - 0.8))
    assert least_drive(model, ARRIVING, scenario, plants).drive > 0.5 * (1.0 - 0.05 * 0.8)
    assert least_drive(model, spec(drive_peak=Quantity(1.0, unit="A")), scenario, plants).drive == 0


def test_the_refusal_names_the_smaller_limit_and_the_friction() -> None:
    model, scenario = machine(1.0, 1.5, 0.0), there_and_back()
    plants = [{"coulomb": 1.0, "constant": 2.0, "breakaway": 1.5}]
    weak = structs.replace(ARRIVING, drive_peak=Quantity(0.7, unit="A"))
    with pytest.raises(
        NoSolutionError, match=r"drive_peak: found 0\.7 A; allowed: above 0\.75 A, .* breakaway"
    ):
        check_least_drive(model, weak, scenario, plants)
    strong = structs.replace(ARRIVING, drive_peak=Quantity(0.76, unit="A"))
    check_least_drive(model, strong, scenario, plants)
    actuator = structs.replace(model.bench.actuator, limit=Quantity(0.7, unit="A"))
    limited = structs.replace(model, bench=structs.replace(model.bench, actuator=actuator))
    with pytest.raises(NoSolutionError, match=r"actuator\.limit: found 0\.7 A; allowed: above"):
        check_least_drive(limited, ARRIVING, scenario, plants)


def test_the_drive_peak_bounds_the_response_time() -> None:
    """From rest to rest with the acceleration (K D - F)/J and the braking (K D + F)/J."""
    model = machine(1.0, 1.0, 0.0)
    encoder = structs.replace(model.bench.encoder, counts_per_revolution=1e5)
    model = structs.replace(model, bench=structs.replace(model.bench, encoder=encoder))
    assert SPEED.position_law is not None
    design = structs.replace(SPEED, position_law=structs.replace(SPEED.position_law, band=None))
    peak, length = 1.0, 20.0 * ERROR
    speeding, braking = (2.0 * peak - 1.0) / 0.5, (2.0 * peak + 1.0) / 0.5
    shorter = length - 2.0 * ERROR  # by the static error, and by the zone of 5 %
    fast = math.sqrt(2.0 * shorter / speeding)
    slow = math.sqrt(2.0 * length * (1.0 / speeding + 1.0 / braking))
    weak = structs.replace(ARRIVING, drive_peak=Quantity(peak, unit="A"))
    with pytest.raises(NoSolutionError, match="raise response_time_95_s or drive_peak"):
        check_feasible(model, structs.replace(weak, response_time_95_s=0.95 * fast), design)
    check_feasible(model, structs.replace(weak, response_time_95_s=1.05 * slow), design)
    check_feasible(model, structs.replace(ARRIVING, response_time_95_s=0.95 * fast), design)
