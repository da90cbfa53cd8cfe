"""The loop with an observer inside: its linear system is the program's, its margins are found
again, and what is refused."""

from __future__ import annotations

from typing import Literal

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.adapters.observer_composition import observer_block
from frictool.control.compiled_program import compile_program, read, run_values
from frictool.control.drive_model import mean_effort
from frictool.control.program import Program
from frictool.documents.controller import Limiter, Velocity
from frictool.documents.observer import FrictionMap, Observer
from frictool.errors import FrictoolError, NoSolutionError
from frictool.export.rounded_loop import rounded_loop
from frictool.observe.design.mode_matrices import subsystems
from frictool.plant.polytope import PlantPoint
from frictool.verify.document_check import check_feedback
from frictool.verify.feedback_loops import feedbacks_of
from frictool.verify.observed_controller import with_observer
from frictool.verify.observer_loop import shown_speeds
from frictool.verify.recheck import recheck
from studies.rigs.example_controllers import BRAKE_LAW, clutch_controller
from tests.support.example_observers import drawn_observer
from tests.support.observed_loop import PERIOD, by_speed, tracking


def frictionless(observer: Observer) -> Observer:
    """Return the linear part of the observer: no dry friction, cell, backlash or knees; viscous
    friction at every speed."""
    own = observer.tracking
    assert own is not None
    plain = msgspec.structs.replace(own, cell=0.0, knees=(), backlash=None)
    friction = FrictionMap(observer.friction.over, (0.0,), (0.0,), 3e-4)
    travel = msgspec.structs.replace(observer.bench.mechanics, top_speed=None)
    bench = msgspec.structs.replace(observer.bench, mechanics=travel)
    return msgspec.structs.replace(observer, tracking=plain, friction=friction, bench=bench)


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 999), st.floats(30.0, 900.0), st.integers(0, 2), st.sampled_from([0.0, 3e-3]))
def test_the_linear_system_is_the_program_s(
    seed: int, bandwidth: float, delay: int, lag: float
) -> None:
    observer = frictionless(tracking(bandwidth))
    actuator = msgspec.structs.replace(observer.bench.actuator, loop_time_constant_s=lag)
    observer = msgspec.structs.replace(
        observer,
        bench=msgspec.structs.replace(observer.bench, actuator=actuator, delay_samples=delay),
    )
    draw, n = np.random.Generator(np.random.PCG64([seed, 94])), 200
    position, drive = np.cumsum(draw.normal(0.0, 2e-3, n)), draw.normal(0.0, 5.0, n)
    program = Program()
    y, u = program.input("position", -1e3, 1e3), program.input("drive", -50.0, 50.0)
    found, move = observer_block(program, y, observer)
    move(mean_effort(program, u, actuator.constant.value, 50.0, delay, lag, PERIOD))
    program.output = found.velocity
    running = compile_program(program)
    running.real[program.states["tracked_position"].index] = position[0]
    running.real[program.states["tracked_velocity"].index] = (
        1.0  # at rest the disturbance would not be corrected
    )
    shown = []
    for k in range(n):
        running.real[y.index], running.real[u.index] = position[k], drive[k]
        run_values(running.code, running.terms, running.writes, running.real)
        shown.append(read(running, found.velocity.index))
    system = shown_speeds(observer)[0].system
    x, linear = np.zeros(system.order), []
    x[-2] = 1.0
    for k, moved in enumerate(np.diff(position, prepend=position[0])):
        entering = np.array([-moved / PERIOD, drive[k]])
        linear.append(-float((system.c @ x + system.d @ entering)[0]))
        x = system.a @ x + system.b @ entering
    np.testing.assert_allclose(shown, linear, atol=1e-9 * np.max(np.abs(linear)))


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 999), st.sampled_from(["multiplicative", "additive"]))
def test_a_switched_observer_s_system_has_the_poles_of_its_modes_in_slip(
    seed: int, wear: Literal["multiplicative", "additive"]
) -> None:
    observer = drawn_observer(seed, wear)
    modes = [mode for mode in observer.switched.modes if mode.direction]
    wanted = []
    for mode in modes:
        matrices = subsystems(observer)[mode.index]
        wanted.append(np.poly(matrices.a - np.array(mode.gains)[:, :1] @ matrices.c[:1]))
    shown = shown_speeds(observer)
    lag = observer.bench.actuator.loop_time_constant_s
    assert len(shown) == len(modes)
    for found, poly in zip(shown, wanted, strict=True):
        of_drive = np.array([np.exp(-PERIOD / lag), 0.0]) if lag else np.zeros(1)
        np.testing.assert_allclose(
            np.poly(found.system.a), np.convolve(poly, np.poly(of_drive)), atol=1e-8
        )


def test_a_switched_observer_closes_a_loop_in_each_of_its_modes() -> None:
    """With gains that place the poles of a tracking one, forward and backward are each other's
    image."""
    observer, own = drawn_observer(0, "additive"), tracking(400.0)
    switched = observer.switched
    assert switched is not None
    assert own.tracking is not None
    one, two, three = own.tracking.gains
    ahead = (one + PERIOD * two, two + PERIOD / own.inertia.value * three)
    modes = tuple(
        msgspec.structs.replace(mode, gains=((ahead[0],), (ahead[1],), (-mode.direction * three,)))
        if mode.direction
        else mode
        for mode in switched.modes
    )
    placed = msgspec.structs.replace(
        observer, inertia=own.inertia, switched=msgspec.structs.replace(switched, modes=modes)
    )
    found = with_observer(by_speed(), placed)
    loops = feedbacks_of(found.controller)
    assert [loop.name for loop in loops] == [
        f"speed loop, mode {mode.index}" for mode in modes if mode.direction
    ]
    rates = PlantPoint("nominal", 1.32e-5, 0.0, 0.1, 13.4e-3).rates
    margins = [check_feedback(loop, rates, 3e-3, 1).modulus_margin for loop in loops]
    assert margins == pytest.approx([margins[0]] * len(loops), rel=1e-6)
    assert found.after is not None
    assert 0.1 < found.after < with_observer(by_speed(), own).after


def test_the_margins_are_found_again_and_the_document_proves_itself() -> None:
    controller = by_speed()
    recheck(controller)
    found = with_observer(controller, tracking())
    merged = found.controller
    recheck(merged)
    assert found.before == min(vertex.modulus_margin for vertex in controller.verified.vertices)
    assert found.after is not None
    assert 0.3 < found.after < found.before
    assert merged.verified.vertices[0].checks != controller.verified.vertices[0].checks
    assert (merged.certificate, merged.verified.robustness, merged.verified.rounded) == (
        None,
        None,
        (),
    )
    assert merged.verified.count_drive is not None
    assert merged.verified.count_drive > 0.0
    assert "modulus margin" in found.lines()[0]


def test_a_faster_observer_leaves_more_of_the_margin() -> None:
    margins = [
        with_observer(by_speed(), tracking(bandwidth)).after
        for bandwidth in (100.0, 200.0, 400.0, 800.0)
    ]
    assert margins == sorted(margins)


def test_an_edited_observer_is_not_verified() -> None:
    merged = with_observer(by_speed(), tracking()).controller
    other = msgspec.structs.replace(
        merged, velocity=Velocity(source="observer", observer=tracking(500.0))
    )
    with pytest.raises(NoSolutionError, match="the document says"):
        recheck(other)


def test_an_unstable_loop_names_vertex_and_delay() -> None:
    with pytest.raises(
        NoSolutionError, match=r"unstable at vertex light with (1 sample|[02] samples) of delay"
    ):
        with_observer(by_speed(gain=8e-3, integral_time=0.02), tracking(40.0))


def test_virtual_friction_that_does_not_come_to_rest_with_the_observer_is_refused() -> None:
    limiter = Limiter(
        "energy", 1.0, inertia=1.32e-5, coulomb=0.1, virtual_coulomb=0.3, virtual_speed=80.0
    )
    base = by_speed()
    position = msgspec.structs.replace(
        base, structure="position", position_law=None, limiter=limiter
    )
    found = with_observer(position, tracking(900.0))
    assert found.after is None
    assert "feeds back the position" in found.lines()[0]
    steep = msgspec.structs.replace(
        position, limiter=msgspec.structs.replace(limiter, virtual_speed=5.0)
    )
    with pytest.raises(NoSolutionError, match="virtual friction at rest is unstable"):
        with_observer(steep, tracking(100.0))


def test_a_position_is_no_part_of_a_loop_of_the_speed() -> None:
    """A common shift of the axis and of the estimate is no state."""
    (loop,) = feedbacks_of(with_observer(by_speed(), tracking()).controller)
    rates = PlantPoint("nominal", 1.32e-5, 0.0, 0.1, 13.4e-3).rates
    assert check_feedback(loop, rates, 3e-3, 1).spectral_radius < 1.0 - 1e-4


def test_a_proportional_law_makes_two_loops_of_each_mode() -> None:
    base = by_speed()
    assert base.position_law is not None
    law = msgspec.structs.replace(
        base.position_law, kind="proportional", gain=7.0, action="none", settled_speed=None
    )
    merged = msgspec.structs.replace(
        base, position_law=law, velocity=Velocity(source="observer", observer=tracking())
    )
    loops = feedbacks_of(merged)
    assert [loop.name for loop in loops] == ["speed loop", "position loop"]
    rates = PlantPoint("nominal", 1.32e-5, 0.0, 0.1, 13.4e-3).rates
    assert all(check_feedback(loop, rates, 3e-3, 1).stable for loop in loops)


def test_what_uses_no_speed_and_what_is_of_another_rig_are_told() -> None:
    with pytest.raises(FrictoolError, match="uses no speed"):
        with_observer(clutch_controller(), tracking())
    encoder = msgspec.structs.replace(tracking().bench.encoder, counts_per_revolution=1000.0)
    other = msgspec.structs.replace(
        tracking(), bench=msgspec.structs.replace(tracking().bench, encoder=encoder)
    )
    with pytest.raises(FrictoolError, match="encoder's step"):
        with_observer(by_speed(), other)


def test_the_velocity_block_has_an_observer_where_it_says_so() -> None:
    with pytest.raises(ValueError, match="required with `source: observer`"):
        Velocity(source="observer")
    with pytest.raises(ValueError, match="with no other source"):
        Velocity(observer=tracking())


@pytest.mark.parametrize("fed_by_the_speed", [True, False])
def test_an_observer_that_runs_away_is_not_verified_whatever_it_is_for(
    fed_by_the_speed: bool,
) -> None:
    own = tracking().tracking
    assert own is not None
    astray = msgspec.structs.replace(
        tracking(), tracking=msgspec.structs.replace(own, gains=(-0.5, -100.0, 0.09))
    )
    controller = by_speed() if fed_by_the_speed else clutch_controller(BRAKE_LAW)
    with pytest.raises(NoSolutionError, match="error grows in slip"):
        with_observer(controller, astray)
    merged = msgspec.structs.replace(
        controller, velocity=Velocity(source="observer", observer=astray)
    )
    for check in (recheck, lambda one: rounded_loop(one, "double")):
        with pytest.raises(NoSolutionError, match="error grows in slip"):
            check(merged)
