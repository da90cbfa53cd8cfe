"""Requirements that no controller can reach are refused before the design; a simulated bang-bang
step confirms the bounds."""

from __future__ import annotations

import math

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from frictool.documents.design import Design
from frictool.documents.quantity import Quantity
from frictool.documents.registry import load
from frictool.documents.spec import Spec
from frictool.errors import FrictoolError, NoSolutionError
from frictool.synth.feasibility import _rising, _settling, check_feasible, fastest, shortest_step
from studies.rigs.clutch_model import ROOT, clutch_model

RIG = ROOT / "configs/clutch"
MODEL, SPEC, SPEED = (
    clutch_model(),
    load(RIG / "spec.yaml", Spec),
    load(RIG / "designs/speed.yaml", Design),
)
LIMITER = load(RIG / "laws/limiter.yaml", Design)


def with_band(band: float, design: Design = SPEED) -> Design:
    name = "position_law" if design.position_law is not None else "limiter"
    block = msgspec.structs.replace(getattr(design, name), band=Quantity(band, unit="rad"))
    return msgspec.structs.replace(design, **{name: block})


@given(st.floats(1.0, 1e5), st.floats(1.0, 4.0), st.floats(0.0, 1.0))
def test_no_switching_of_a_bang_bang_drive_is_faster(up: float, ratio: float, share: float) -> None:
    """Speed up with `up` over a share of the way, brake with `down`: what ends within 5 % and stays
    there has not passed 95 % earlier."""
    down = ratio * up
    turning = share * 1.05
    speed = math.sqrt(2.0 * up * turning)
    end = turning + speed**2 / (2.0 * down)
    if not 0.95 <= end <= 1.05:
        return
    before, after = (
        min(turning, 0.95),
        max(0.95 - turning, 0.0),
    )  # of the way to 95 %, while it speeds up and while it brakes
    passed = (
        math.sqrt(2.0 * before / up) + (speed - math.sqrt(speed**2 - 2.0 * down * after)) / down
    )
    assert passed >= _settling(up, down) * (1.0 - 1e-9)


@pytest.mark.parametrize(("effort", "coulomb"), [(0.7, 0.1), (0.2, 0.19)])
def test_the_bound_is_the_time_of_a_simulated_step(effort: float, coulomb: float) -> None:
    """In steps of a hundred thousandth of the time, from rest to rest at 105 %; where friction is
    most of the effort it hardly brakes."""
    inertia, length = 1.5e-5, 20.0
    up, down = (effort - coulomb) / inertia, (effort + coulomb) / inertia
    turning, bound = 1.05 * length * down / (up + down), _settling(up, down) * math.sqrt(length)
    step = 1e-5 * bound
    time = position = speed = 0.0
    while position < 0.95 * length:
        speed += step * (up if position < turning else -down)
        position, time = position + step * speed, time + step
    assert time == pytest.approx(bound, rel=1e-3)


def test_the_slowest_plant_and_the_shortest_step_are_those_of_the_documents() -> None:
    slowest = fastest(MODEL, _settling)
    assert slowest.inertia == 1.53e-5
    assert slowest.effort == pytest.approx(0.0128 * 50.0)
    assert shortest_step(MODEL, SPEC) == pytest.approx(2.0 / 0.05)
    assert shortest_step(MODEL, msgspec.structs.replace(SPEC, static_error=None)) == pytest.approx(
        20.0 * 2.0 * math.pi / 56.0
    )
    assert (
        shortest_step(MODEL, msgspec.structs.replace(SPEC, static_error=Quantity(10.0, unit="rad")))
        == 63.0
    )


@pytest.mark.parametrize(
    ("key", "part"), [("response_time_95_s", _settling), ("rise_time_s", _rising)]
)
def test_a_time_below_the_bound_has_no_solution_and_one_above_it_may(
    key: str, part: object
) -> None:
    delay = (
        MODEL.bench.delay_samples * MODEL.bench.sample_period_s
        if key == "response_time_95_s"
        else 0.0
    )
    bound = delay + fastest(MODEL, part).per_root * math.sqrt(40.0)
    spec = msgspec.structs.replace(SPEC, **({"response_time_95_s": None} | {key: 0.999 * bound}))
    with pytest.raises(
        NoSolutionError,
        match=rf"{key} of the specification is .* the drive needs at least {bound:.4g} s for a "
        r"step of 40 rad",
    ):
        check_feasible(MODEL, spec, SPEED)
    (note,) = check_feasible(MODEL, msgspec.structs.replace(spec, **{key: 1.001 * bound}), SPEED)
    assert "for steps longer than 40." in note
    assert check_feasible(MODEL, msgspec.structs.replace(spec, **{key: 2.0 * bound}), SPEED) == ()


def test_a_stronger_drive_or_less_inertia_is_never_slower() -> None:
    bounds = []
    for limit in np.linspace(20.0, 80.0, 7):
        actuator = msgspec.structs.replace(
            MODEL.bench.actuator, limit=Quantity(float(limit), unit="A")
        )
        bench = msgspec.structs.replace(MODEL.bench, actuator=actuator)
        bounds.append(fastest(msgspec.structs.replace(MODEL, bench=bench), _settling).per_root)
    assert (np.diff(bounds) < 0.0).all()


@pytest.mark.parametrize("design", [SPEED, LIMITER], ids=["cut", "limiter"])
def test_a_band_is_within_a_count_and_the_static_error(design: Design) -> None:
    count = MODEL.bench.encoder.resolution
    name = "position_law" if design.position_law is not None else "limiter"
    for band in (count, 1.0, 2.0):
        check_feasible(MODEL, SPEC, with_band(band, design))
    with pytest.raises(
        FrictoolError,
        match=rf"{name}.band: found 2.001 rad; allowed: at most static_error of the "
        r"specification, 2 rad",
    ):
        check_feasible(MODEL, SPEC, with_band(2.001, design))
    check_feasible(
        MODEL, msgspec.structs.replace(SPEC, static_error=None), with_band(2.001, design)
    )
    fine = msgspec.structs.replace(SPEC, static_error=Quantity(0.5 * count, unit="rad"))
    bare = msgspec.structs.replace(
        design, **{name: msgspec.structs.replace(getattr(design, name), band=None)}
    )
    with pytest.raises(FrictoolError, match=rf"{name}.band: the encoder's step is 0.1122 rad"):
        check_feasible(MODEL, fine, bare)


def test_a_law_that_never_releases_the_drive_has_a_band_of_any_width_above_a_count() -> None:
    law = msgspec.structs.replace(SPEED.position_law, action="none", settled_speed=None)
    straight = msgspec.structs.replace(SPEED, position_law=law)
    check_feasible(MODEL, SPEC, with_band(5.0, straight))
    with pytest.raises(
        FrictoolError,
        match=r"position_law.band: found 0.1 rad; allowed: at least the encoder's step, 0.1122 rad",
    ):
        check_feasible(MODEL, SPEC, with_band(0.1, straight))
