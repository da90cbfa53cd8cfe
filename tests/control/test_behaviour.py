"""The composed controller in every number format: bounded, mirrored, at rest where the design says
rest, on a simulated axis too."""

from __future__ import annotations

import math

import msgspec
import numpy as np
import pytest
from hypothesis import given
from numpy.typing import NDArray

from frictool.adapters.controller_composition import controller_program
from frictool.control.compiled_program import compile_program, control_step, read, start_at
from frictool.control.number_format import machine_in
from frictool.control.target_band import BRAKE, REST, RUN
from frictool.documents.controller import (
    Controller,
    Limiter,
    LinearController,
    PositionLaw,
    Velocity,
)
from frictool.engine.closed_loop import COMMAND, RECORD_SIZE, TRUE_POSITION, TRUE_VELOCITY, run
from frictool.engine.disturbances_and_faults import NO_CONDITIONS
from frictool.engine.status_codes import OK
from frictool.plant.axis import AxisParameters, rest
from frictool.plant.position_load import PositionLoad
from studies.rigs.example_controllers import BRAKE_LAW, CUT_LAW, clutch_controller
from tests.control.random_controllers import STEP, Sample, assaults, controllers, space, wanderings

LAWS = {"cut": CUT_LAW, "brake": BRAKE_LAW}
NUMBERS = ("double", "float", "q31")


class Running:
    """A controller's machine with its states by name."""

    def __init__(self, controller: Controller, position: float, number: str = "double") -> None:
        self.program = controller_program(controller)
        self.machine = machine_in(self.program, number)
        start_at(self.machine, position)

    def step(self, reference: float, position: float, velocity: float = 0.0) -> float:
        return control_step(self.machine, reference, position, velocity)

    def state(self, name: str) -> float:
        return read(self.machine, self.program.states[name].index)

    def named(self, name: str) -> float:
        return read(
            self.machine,
            next(place for place, called in self.program.names.items() if called == name),
        )


@given(controllers(bounded=True), wanderings() | assaults())
def test_the_drive_is_bounded_and_rest_is_exactly_zero(
    controller: Controller, sequence: tuple[float, list[Sample]]
) -> None:
    start, samples = sequence
    running = Running(controller, start)
    rests = controller.position_law is not None and controller.position_law.action != "none"
    for sample in samples:
        drive = running.step(*sample)
        assert abs(drive) <= controller.drive_limit
        if rests and running.state("mode") == REST:
            assert drive == 0.0
            assert math.copysign(1.0, drive) == 1.0
            assert abs(running.named("error")) <= controller.position_law.band


@pytest.mark.parametrize("number", NUMBERS)
@pytest.mark.parametrize("law", LAWS)
def test_starts_at_rest_and_stays_there(law: str, number: str) -> None:
    running = Running(clutch_controller(LAWS[law]), 7.5, number)
    before = [running.state(name) for name in running.program.states]
    assert [running.step(7.5, 7.5) for _ in range(100)] == [0.0] * 100
    assert [running.state(name) for name in running.program.states] == before


@pytest.mark.parametrize("number", NUMBERS)
@pytest.mark.parametrize("law", LAWS)
def test_the_mirrored_inputs_give_the_mirrored_drive(law: str, number: str) -> None:
    """To the last bit, in fixed point too: it rounds halves away from zero."""
    one, other = (Running(clutch_controller(LAWS[law]), 0.0, number) for _ in range(2))
    position, largest = 0.0, 0.0
    for _ in range(400):
        drive = one.step(20.0, position)
        assert drive == -other.step(-20.0, -position)
        position, largest = (
            STEP * math.floor((0.1 * one.state("filtered_before") + 0.9 * position) / STEP),
            max(largest, abs(drive)),
        )
    assert largest > 1.0


def test_resumes_from_rest_as_from_the_start() -> None:
    """The past before a rest leaves no trace but the encoder's own state."""
    controller = clutch_controller(CUT_LAW, prefilter=False)
    used, new = Running(controller, 0.0), Running(controller, 30.0)
    for position in np.linspace(0.0, 30.0, 300):
        used.step(30.0, float(position))
    assert used.step(30.0, 30.0) == 0.0
    assert used.state("mode") == REST
    for _ in range(50):
        assert used.step(40.0, 30.0) == new.step(40.0, 30.0)


def test_waits_for_the_prefilter_before_it_lets_go() -> None:
    """An axis that follows the filtered reference exactly is inside the band all the way, and must
    not be dropped there."""
    running = Running(clutch_controller(CUT_LAW), 5.0)
    modes, moving = [], []
    for _ in range(600):
        running.step(55.0, running.state("filtered_before"))
        modes.append(running.state("mode"))
        moving.append(abs(running.state("filtered_speed_before")) >= CUT_LAW.settled_speed)
    assert modes == [RUN if moves else REST for moves in moving]
    assert sum(moving) > 150
    assert modes[-1] == REST


def test_brakes_before_it_rests() -> None:
    """In the band at speed: the loop stays closed with a speed reference of zero, then the drive is
    zero for good."""
    position, speed = -20.0, 300.0
    running = Running(clutch_controller(BRAKE_LAW, prefilter=False), position)
    modes, drives = [], []
    for _ in range(400):
        drives.append(running.step(0.0, position))
        modes.append(running.state("mode"))
        speed = speed if position < -0.9 else 0.97 * speed
        position += 1e-3 * speed if position < 0.3 else 0.0
    assert [mode for k, mode in enumerate(modes) if k == 0 or modes[k - 1] != mode] == [
        RUN,
        BRAKE,
        REST,
    ]
    assert min(drive for drive, mode in zip(drives, modes, strict=True) if mode == BRAKE) < 0.0
    assert drives[-1] == 0.0


def _samples_at_limit(running: Running, blocked: int, limit: float) -> int:
    """Held against a far reference for so long, then it returns: samples until the drive turns."""
    for _ in range(blocked):
        drive = running.step(50.0, 0.0)
    assert drive == pytest.approx(limit, rel=1e-9)
    count = 0
    while running.step(-50.0, 0.0) > 0.0:
        count += 1
    return count


@pytest.mark.parametrize("number", NUMBERS)
def test_blocked_axis_does_not_wind_up(number: str) -> None:
    """Held against the far reference for 1 s or for 3 s, the drive leaves its limit equally soon
    after the reference returns."""
    controller = clutch_controller(CUT_LAW, prefilter=False)
    short, long = (
        _samples_at_limit(Running(controller, 0.0, number), blocked, 50.0)
        for blocked in (1000, 3000)
    )
    assert short == long < 20


def _pi(*, conditional: bool) -> Controller:
    """A PI on the speed error, as table 5.1's, under a proportional law."""
    discrete = space(np.eye(1), np.array([1e-3]), np.array([2.0]), 0.4)
    linear = LinearController(
        discrete, discrete, (), (0.0,), input="speed_error", conditional=conditional
    )
    law = PositionLaw(gain=10.0, kind="proportional")
    return msgspec.structs.replace(
        clutch_controller(prefilter=False), linear=linear, position_law=law
    )


def test_conditional_integration_keeps_an_integrator_from_winding_up() -> None:
    short, long = (
        _samples_at_limit(Running(_pi(conditional=True), 0.0), blocked, 50.0)
        for blocked in (1000, 3000)
    )
    assert short == long < 20
    short, long = (
        _samples_at_limit(Running(_pi(conditional=False), 0.0), blocked, 50.0)
        for blocked in (1000, 3000)
    )
    assert long > short + 100


# K_p, T_i, T_d of a PID on the position, A per rad; its derivative through a low-pass of 600 rad/s
GAIN, INTEGRAL, DERIVATIVE, CORNER = 2.0, 0.3, 1.0 / 30.0, 600.0
AXIS = AxisParameters(
    inertia=1.32e-5,
    viscous=0.0,
    coulomb=0.099,
    breakaway=0.109,
    constant=13.4e-3,
    lag=3e-3,
    drive_limit=50.0,
)


def position_controller(limiter: Limiter | None) -> Controller:
    """A position loop on the clutch's inertia, with an integrator and a perfect encoder."""
    t = 1e-3
    a = np.diag([1.0, 1.0 - CORNER * t])
    b, c = np.array([t, CORNER * t]), np.array([GAIN / INTEGRAL, -GAIN * DERIVATIVE * CORNER])
    discrete = space(a, b, c, GAIN * (1.0 + DERIVATIVE * CORNER))
    linear = LinearController(discrete, discrete, (), (0.0, 0.0), conditional=True)
    speed = Velocity(order=2, bandwidth_rad_s=600.0)
    return msgspec.structs.replace(
        clutch_controller(),
        structure="position",
        position_law=None,
        linear=linear,
        limiter=limiter,
        velocity=speed,
    )


ENERGY = Limiter(condition="energy", band=0.1, inertia=1.32e-5, coulomb=0.099)
BRAKED = msgspec.structs.replace(ENERGY, virtual_coulomb=0.1, virtual_speed=10.0)
CUT_OFF = Limiter(condition="error", band=0.1)


def _played(limiter: Limiter | None) -> NDArray[np.float64]:
    samples = 4000
    record, made = (
        np.zeros((samples, RECORD_SIZE)),
        compile_program(controller_program(position_controller(limiter))),
    )
    start_at(made, 5.0)
    references = np.full(samples, 25.0)
    assert (
        run(
            AXIS.as_array(),
            rest(5.0),
            made,
            references,
            1e-3,
            1,
            record,
            PositionLoad().as_array(),
            NO_CONDITIONS,
        )
        == OK
    )
    return record


@pytest.mark.parametrize(
    "limiter", [ENERGY, BRAKED, CUT_OFF], ids=["energy", "virtual friction", "error"]
)
def test_a_released_position_loop_ends_at_rest(limiter: Limiter) -> None:
    """5.2.1's claim that holds: with the drive released the axis rests for good, and near its
    target; an integrator alone goes on."""
    record = _played(limiter)
    late = record[-1500:]
    assert not late[:, TRUE_VELOCITY].any()
    assert not late[:, COMMAND].any()
    assert abs(late[-1, TRUE_POSITION] - 25.0) < 0.2
    assert _played(None)[-1500:, COMMAND].any()


@pytest.mark.parametrize("limiter", [ENERGY, BRAKED], ids=["energy", "virtual friction"])
def test_the_integrator_is_frozen_while_released_and_the_rest_is_not(limiter: Limiter) -> None:
    """5.2.2: not a bit of it moves, while the other states go on watching the error."""
    record = _played(limiter)
    running = Running(position_controller(limiter), 5.0)
    frozen = moved = 0
    for position in record[:, 0]:
        before, other = running.state("x[0]"), running.state("x[1]")
        drive = running.step(25.0, float(position))
        if running.named("released"):
            assert running.state("x[0]") == before
            frozen, moved = frozen + 1, moved + (running.state("x[1]") != other)
            assert drive == 0.0 or limiter.virtual_coulomb > 0.0
            assert drive * running.named("speed") <= 0.0
    assert frozen > 1000
    assert moved > 10


def test_a_release_that_waits_for_the_prefilter_does_not_act_before() -> None:
    limiter = msgspec.structs.replace(CUT_OFF, settled_speed=5.0)
    running = Running(position_controller(limiter), 5.0)
    seen: set[tuple[bool, bool]] = set()
    for _ in range(800):
        running.step(25.0, running.state("filtered_before"))
        seen.add(
            (
                bool(running.named("released_and_settled")),
                abs(running.state("filtered_speed_before")) < 5.0,
            )
        )
    assert seen == {(False, False), (True, True)}


def test_sections_and_state_space_are_the_same_controller() -> None:
    """The stored forms of one controller, without their limits: the drive differs by rounding
    only."""
    controller = clutch_controller(limit=1e6)
    chain = msgspec.structs.replace(
        controller.linear, form="sos", sos_anti_windup=(0.0,) * (2 * len(controller.linear.sos))
    )
    space_form, section_form = (
        Running(msgspec.structs.replace(controller, linear=one), 5.0)
        for one in (controller.linear, chain)
    )
    for k in range(400):
        position = 5.0 + STEP * math.floor(k / 40)
        one, other = space_form.step(15.0, position), section_form.step(15.0, position)
        assert abs(one) < controller.drive_limit
        assert one == pytest.approx(other, rel=1e-9, abs=1e-9)
