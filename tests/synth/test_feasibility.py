"""Requirements that no controller can reach are refused before the design."""

from __future__ import annotations

import math

import msgspec
import numpy as np
import pytest

from frictool.adapters.model_polytope import polytope
from frictool.adapters.shortest_step import shortest_step_times
from frictool.documents.design import Design
from frictool.documents.quantity import Quantity
from frictool.documents.registry import load
from frictool.documents.spec import Spec
from frictool.errors import FrictoolError, NoSolutionError
from frictool.plant.time_optimal import DrivenAxis
from frictool.synth.feasibility import (
    ShortestTime,
    _response,
    _rise,
    check_feasible,
    check_played_step,
    loop_allowance,
    shortest_step,
    slowest_step,
)
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


def test_the_slowest_plant_and_the_shortest_step_are_those_of_the_documents() -> None:
    slowest = slowest_step(MODEL, _response(MODEL, SPEC), 50.0).plant
    assert (slowest.inertia, slowest.constant) == (1.53e-5, 0.0128)
    assert shortest_step(MODEL, SPEC) == pytest.approx(2.0 / 0.05)
    assert shortest_step(MODEL, msgspec.structs.replace(SPEC, static_error=None)) == pytest.approx(
        20.0 * 2.0 * math.pi / 56.0
    )
    assert (
        shortest_step(MODEL, msgspec.structs.replace(SPEC, static_error=Quantity(10.0, unit="rad")))
        == 63.0
    )


@pytest.mark.parametrize(
    ("key", "least"), [("response_time_95_s", _response(MODEL, SPEC)), ("rise_time_s", _rise)]
)
def test_a_time_below_the_bound_has_no_solution_and_one_above_it_may(
    key: str, least: ShortestTime
) -> None:
    bound = slowest_step(MODEL, least, 40.0).time
    spec = msgspec.structs.replace(SPEC, **({"response_time_95_s": None} | {key: 0.999 * bound}))
    with pytest.raises(
        NoSolutionError,
        match=rf"{key}: found .* the drive needs at least {bound:.4g} s even for",
    ):
        check_feasible(MODEL, spec, SPEED)
    (note,) = check_feasible(MODEL, msgspec.structs.replace(spec, **{key: 1.001 * bound}), SPEED)
    assert "for steps above 40." in note
    whole = slowest_step(MODEL, least, 63.0).time
    assert f"the whole travel takes at least {whole:.4g} s" in note
    assert check_feasible(MODEL, msgspec.structs.replace(spec, **{key: 2.0 * bound}), SPEED) == ()


def test_the_refusal_takes_the_most_favourable_reading_of_the_specification() -> None:
    """From within the backlash to a stop that is short by the static error and a count: less than
    the 104 ms that the drive needs for 50 rad, and more than a step that is shorter by both."""
    refused = slowest_step(MODEL, _response(MODEL, SPEC), 50.0).time
    bench, plants = MODEL.bench, polytope(MODEL).vertices
    assert shortest_step_times(bench, plants, 50.0, 0.05).worst == pytest.approx(0.104)
    shorter = shortest_step_times(
        bench, plants, 50.0 - 3.0 - 2.0 - 3.0 * bench.encoder.resolution, 0.05
    )
    assert shorter.worst - 0.004 < refused < 0.104


def test_the_rise_is_that_of_a_drive_at_its_limit() -> None:
    """From 10 to 90 % at constant acceleration: sqrt(2 s/a) (sqrt 0.9 - sqrt 0.1)."""
    axis = DrivenAxis(2.0, 0.0, 0.25, 1.0, 0.1)
    expected = math.sqrt(2.0 * 3.0 / 0.375) * (math.sqrt(0.9) - math.sqrt(0.1))
    assert _rise(axis, 3.0) == pytest.approx(expected, rel=1e-9)


def test_a_stronger_drive_or_less_inertia_is_never_slower() -> None:
    bounds = []
    for limit in np.linspace(20.0, 80.0, 7):
        actuator = msgspec.structs.replace(
            MODEL.bench.actuator, limit=Quantity(float(limit), unit="A")
        )
        bench = msgspec.structs.replace(MODEL.bench, actuator=actuator)
        model = msgspec.structs.replace(MODEL, bench=bench)
        bounds.append(slowest_step(model, _response(model, SPEC), 50.0).time)
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


def test_a_played_step_needs_the_time_of_the_drive_and_of_the_speed_loop() -> None:
    """A loop k exp(-s T)/s with modulus margin 0.5 has k T = 0.7: |1 + L| at its smallest."""
    dead_time = 0.005
    product = dead_time / loop_allowance(MODEL, 0.5, dead_time)
    gains = [point.constant / point.inertia for point in polytope(MODEL).vertices]
    product *= max(gains) / min(gains)
    angles = np.linspace(1e-3, 3.0, 30_000)
    loop = product * np.exp(-1j * angles) / (1j * angles)
    assert np.abs(1.0 + loop).min() == pytest.approx(0.5, abs=1e-4)
    bound = slowest_step(MODEL, _response(MODEL, SPEC), 50.0).time
    least = bound + loop_allowance(MODEL, 0.5, dead_time)
    spec = msgspec.structs.replace(SPEC, response_time_95_s=0.999 * least)
    words = rf"up to {least:.4g} s \(drive alone {bound:.4g} s\)"
    with pytest.raises(NoSolutionError, match=words):
        check_played_step(MODEL, spec, 50.0, dead_time)
    check_played_step(
        MODEL, msgspec.structs.replace(SPEC, response_time_95_s=1.001 * least), 50.0, dead_time
    )
