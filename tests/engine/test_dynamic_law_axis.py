"""An axis under a dynamic friction law: agreement with scipy, creep, the limit of a stiff contact,
energy, end stops and drifts."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from frictool.control.compiled_program import control_step
from frictool.engine.axis_motion import advance, is_held
from frictool.engine.closed_loop import RECORD_SIZE, TRUE_POSITION, TRUE_VELOCITY, run
from frictool.engine.disturbances_and_faults import (
    FRICTION,
    NO_CONDITIONS,
    VISCOUS_FACTOR,
    neutral,
)
from frictool.engine.drive import held
from frictool.engine.dynamic_law_axis import STEP, with_contact, with_dynamic_law
from frictool.engine.law_simulation import LawRunSettings, run_law
from frictool.engine.status_codes import OK
from frictool.friction.law_registry import LAWS
from frictool.plant.axis import DRIVE, POSITION, VELOCITY, AxisParameters, rest
from frictool.plant.axis_dynamic_law import AxisDynamicLaw, extension_of
from frictool.plant.axis_friction_laws import (
    AxisFrictionLevels,
    AxisLaws,
    FrictionPositionShape,
    ViscousRegime,
)
from frictool.plant.position_load import LoadHarmonic, PositionLoad, load_effort, with_load
from studies.rigs.example_controllers import clutch_controller, started
from tests.support.plain_laws import presliding_force, presliding_rate

PERIOD = 1e-3
STIFFNESS, BREAKAWAY, VELOCITY_SCALE = 400.0, 1.1, 0.05  # N m/rad, N m, rad/s
Z_MAX = BREAKAWAY / STIFFNESS
AXIS = AxisParameters(
    inertia=0.02, viscous=0.05, coulomb=0.8, breakaway=BREAKAWAY, offset=0.1, constant=0.5, lag=4e-3
)
SMOOTH = ("dahl", "lugre", "elasto_plastic")  # laws whose state is one number without memory
AGREES = 1e-6  # largest error of position over z_max


def values_of(name: str, axis: AxisParameters = AXIS, stiffness: float = STIFFNESS) -> dict:
    """Return the parameters of a law of SMOOTH by name."""
    known = {
        "coulomb": axis.coulomb,
        "breakaway": axis.breakaway,
        "stribeck_velocity": VELOCITY_SCALE,
        "stribeck_exponent": 2.0,
        "viscous": axis.viscous,
        "stiffness": stiffness,
        "damping": 2.0 * math.sqrt(axis.inertia * stiffness),
        "exponent": 1.0,
        "elastic_limit": 0.6 * axis.breakaway / stiffness,
    }
    return {one.name: known[one.name] for one in LAWS[name].parameters}


def dynamic_law(
    name: str, axis: AxisParameters = AXIS, stiffness: float = STIFFNESS
) -> AxisDynamicLaw:
    law = LAWS[name]
    p = law.pack(values_of(name, axis, stiffness), "rotary")
    extension = extension_of(law, axis.laws, axis.viscous)
    return AxisDynamicLaw(law, p, VELOCITY_SCALE, axis.breakaway / stiffness, extension)


def started_axis(
    dynamic: AxisDynamicLaw, axis: AxisParameters = AXIS, load: PositionLoad | None = None
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the parameters and the state at rest."""
    array = with_dynamic_law(axis.as_array(), dynamic)
    return with_load(array, (load or PositionLoad()).as_array()), with_contact(rest(), dynamic)


def plain_field(
    name: str, axis: AxisParameters, load: NDArray[np.float64], values: dict
) -> Callable[..., list[float]]:
    """Return the printed equations as a field of (x, v, drive, z)."""

    def field(_: float, y: NDArray[np.float64], command: float) -> list[float]:
        x, v, drive, z = y
        rate = presliding_rate(name, z, v, values)
        friction = presliding_force(name, z, rate, v, values)
        effort = axis.constant * drive - axis.offset - load_effort(load, x)
        return [v, (effort - friction) / axis.inertia, (command - drive) / axis.lag, rate]

    return field


def integrated(field: Callable[..., list[float]], y: NDArray[np.float64], command: float) -> None:
    """Advance y by a period, in place."""
    solved = solve_ivp(
        field, (0.0, PERIOD), y, method="Radau", args=(command,), rtol=1e-9, atol=1e-12
    )
    assert solved.success
    y[:] = solved.y[:, -1]


@pytest.mark.parametrize("name", SMOOTH)
def test_the_motion_agrees_with_scipy(name: str) -> None:
    """Commands below and above the breakaway, against a spring and a ripple."""
    load = PositionLoad(0.3, (LoadHarmonic(7.0, 0.05, 0.02),))
    array, state = started_axis(dynamic_law(name), load=load)
    field = plain_field(name, AXIS, load.as_array(), values_of(name))
    y = np.zeros(4)
    error = reached = 0.0
    for k in range(240 if name == "elasto_plastic" else 80):
        command = 3.0 * math.sin(0.09 * k) * (3.0 if k % 7 == 0 else 1.0)
        assert advance(state, command, array, PERIOD) == OK
        integrated(field, y, command)
        error = max(error, abs(state[POSITION] - y[0]))
        reached = max(reached, abs(y[0]))
        assert state[VELOCITY] == pytest.approx(y[1], abs=1e-4 * VELOCITY_SCALE)
        assert state[DRIVE] == pytest.approx(y[2], abs=1e-9)
        assert state[STEP + 1] == pytest.approx(y[3], abs=AGREES * Z_MAX)
    assert error < AGREES * Z_MAX
    assert reached > 4.0 * Z_MAX


@pytest.mark.parametrize("name", SMOOTH)
def test_the_sampled_loop_agrees_with_scipy(name: str) -> None:
    """The controller of the clutch moves an axis by a step of 20 rad; scipy moves it likewise."""
    axis = AXIS._replace(
        inertia=1.3e-5, viscous=3e-4, coulomb=0.05, breakaway=0.06, constant=0.0134
    )
    axis = axis._replace(offset=0.0, drive_limit=50.0)
    stiffness = 6.0
    dynamic = dynamic_law(name, axis, stiffness)
    array, state = started_axis(dynamic, axis)
    reference = np.full(70, 20.0)
    record = np.zeros((reference.size, RECORD_SIZE))
    program = started(clutch_controller(), 0.0)
    status = run(array, state, program, reference, PERIOD, 1, record, np.zeros(0), NO_CONDITIONS)
    assert status == OK
    program = started(clutch_controller(), 0.0)
    field = plain_field(name, axis, np.zeros(0), values_of(name, axis, stiffness))
    y = np.zeros(4)
    acting = 0.0
    for k, target in enumerate(reference):
        assert record[k, TRUE_POSITION] == pytest.approx(
            y[0], abs=10.0 * AGREES * axis.breakaway / stiffness
        )
        command = control_step(program, target, y[0], y[1])
        integrated(field, y, min(max(acting, -50.0), 50.0))
        acting = command
    assert np.max(record[:, TRUE_POSITION]) > 5.0
    assert np.max(np.abs(record[:, TRUE_VELOCITY])) > 5.0


def cycled(name: str, cycles: int, low: float, high: float) -> NDArray[np.float64]:
    """Return the position after each slow cycle of an effort that stays below the breakaway."""
    axis = AXIS._replace(coulomb=BREAKAWAY, offset=0.0, constant=1.0, lag=0.0, viscous=0.0)
    array, state = started_axis(dynamic_law(name, axis), axis)
    positions = []
    for _ in range(cycles):
        for command in np.concatenate([np.linspace(low, high, 400), np.linspace(high, low, 400)]):
            assert advance(state, command, array, 5.0 * PERIOD) == OK
        positions.append(state[POSITION])
    return np.array(positions)


def test_lugre_creeps_under_a_dithered_effort_by_its_closed_form() -> None:
    """A slow cycle from the shares a to b of the breakaway moves the contact by z_max
    log((1 - a^2)/(1 - b^2)); it takes no account of inertia, hence a tolerance."""
    low, high = 0.3, 0.8
    steps = np.diff(cycled("lugre", 4, low * BREAKAWAY, high * BREAKAWAY))
    expected = Z_MAX * math.log((1.0 - low**2) / (1.0 - high**2))
    np.testing.assert_allclose(steps, expected, rtol=0.01)


def test_an_elasto_plastic_contact_does_not_creep_below_its_elastic_limit() -> None:
    """The same cycle to half of the breakaway, below z_ba = 0.6 z_max: the contact only bends."""
    steps = np.diff(cycled("elasto_plastic", 4, 0.3 * BREAKAWAY, 0.5 * BREAKAWAY))
    np.testing.assert_allclose(steps, 0.0, atol=1e-9 * Z_MAX)
    crept = np.diff(cycled("lugre", 4, 0.3 * BREAKAWAY, 0.5 * BREAKAWAY))
    assert np.all(crept > 0.1 * Z_MAX)


def test_a_maxwell_bank_closes_its_loops() -> None:
    """A rate-independent hysteresis returns to the same point after each cycle (annex A)."""
    axis = AXIS._replace(coulomb=BREAKAWAY, offset=0.0, constant=1.0, lag=0.0, viscous=0.0)
    law = LAWS["maxwell_slip"]
    known = values_of("lugre", axis) | {"presliding_limit": 2.0 * Z_MAX, "attraction": 20.0}
    p = law.pack({one.name: known[one.name] for one in law.parameters}, "rotary")
    dynamic = AxisDynamicLaw(law, p, VELOCITY_SCALE, Z_MAX)
    array, state = started_axis(dynamic, axis)
    ends = []
    for _ in range(4):
        for command in BREAKAWAY * np.concatenate(
            [np.linspace(0.3, 0.8, 400), np.linspace(0.8, 0.3, 400)]
        ):
            assert advance(state, command, array, 5.0 * PERIOD) == OK
        ends.append(state[POSITION])
    assert ends[0] > 0.1 * Z_MAX
    np.testing.assert_allclose(np.diff(ends[1:]), 0.0, atol=2e-3 * Z_MAX)


def test_a_stiff_contact_tends_to_stick_and_slip() -> None:
    """The distance from the event-exact axis falls as the speed of the contact's own motion,
    breakaway/sqrt(stiffness inertia): tenfold for a hundredfold stiffness."""
    axis = AXIS._replace(laws=AxisLaws(stribeck_velocity=VELOCITY_SCALE))
    commands = [3.0 * math.sin(0.02 * k) for k in range(500)]

    def path(array: NDArray[np.float64], state: NDArray[np.float64]) -> NDArray[np.float64]:
        out = []
        for command in commands:
            assert advance(state, command, array, PERIOD) == OK
            out.append(state[POSITION])
        return np.array(out)

    exact = path(axis.as_array(), rest())
    assert np.ptp(exact) > 0.1
    errors = [
        np.max(np.abs(path(*started_axis(dynamic_law("lugre", axis, k), axis)) - exact))
        for k in (4e4, 4e6, 4e8)
    ]
    assert errors[0] > 8.0 * errors[1] > 64.0 * errors[2]
    assert errors[2] < 3e-4 * np.ptp(exact)


def test_the_energy_of_a_free_axis_goes_into_its_contact() -> None:
    """The kinetic energy that is lost equals the work against the deflected contact."""
    axis = AXIS._replace(offset=0.0, viscous=0.0)
    array, state = started_axis(dynamic_law("dahl", axis), axis)
    state[VELOCITY] = 2.0
    power, lost = [], []
    for _ in range(20_000):
        power.append(STIFFNESS * state[STEP + 1] * state[VELOCITY])
        lost.append(0.5 * axis.inertia * (4.0 - state[VELOCITY] ** 2))
        assert advance(state, 0.0, array, 5e-6) == OK
    work = np.concatenate([[0.0], np.cumsum(0.5 * (np.array(power[1:]) + power[:-1]) * 5e-6)])
    assert lost[-1] > 0.99 * 0.5 * axis.inertia * 4.0
    np.testing.assert_allclose(work, lost, atol=2e-6 * lost[-1])


def test_an_end_stop_returns_the_axis_and_holds_it() -> None:
    """The impact reverses the speed times the restitution; a pressed axis rests at the stop until
    the effort turns, and leaves it when the effort passes what the contact holds."""
    laws = AxisLaws(stops=(-0.5, 0.05), restitution=0.4)
    axis = AXIS._replace(offset=0.0, laws=laws)
    array, state = started_axis(dynamic_law("lugre", axis), axis)
    fastest = rebound = 0.0
    for _ in range(600):
        assert advance(state, 8.0, array, 1e-4) == OK
        fastest = max(fastest, state[VELOCITY])
        rebound = min(rebound, state[VELOCITY])
        assert state[POSITION] <= 0.05
    assert rebound == pytest.approx(-0.4 * fastest, rel=0.05)
    for _ in range(500):
        assert advance(state, 8.0, array, PERIOD) == OK
    assert (state[POSITION], state[VELOCITY]) == (0.05, 0.0)
    deflection = state[STEP + 1]
    released = -1.0
    for k in range(400):
        assert advance(state, 8.0 - 0.05 * k, array, PERIOD) == OK
        if state[POSITION] < 0.05:
            released = axis.constant * state[DRIVE]
            break
    assert released == pytest.approx(STIFFNESS * deflection, abs=0.06)


def test_a_drift_moves_the_axis_as_other_parameters_would() -> None:
    """Twice the friction is twice the levels, the stiffness and the damping of the contact, bit by
    bit; the viscous friction has its own factor."""
    axis = AXIS._replace(offset=0.0, drive_limit=50.0)
    conditions = neutral(150)
    conditions[:, FRICTION], conditions[:, VISCOUS_FACTOR] = 2.0, 0.5
    reference = np.full(150, 3.0)

    def loop(dynamic: AxisDynamicLaw, conditions: NDArray[np.float64]) -> NDArray[np.float64]:
        array, state = started_axis(dynamic, axis)
        record = np.zeros((reference.size, RECORD_SIZE))
        program = started(clutch_controller(), 0.0)
        load = np.zeros(0)
        assert run(array, state, program, reference, PERIOD, 0, record, load, conditions) == OK
        return record

    dynamic = dynamic_law("lugre", axis)
    p = dynamic.p.copy()
    p[[0, 1, 5, 6]] *= 2.0
    p[4] *= 0.5
    drifted = loop(dynamic, conditions)
    np.testing.assert_array_equal(drifted, loop(dynamic._replace(p=p), neutral(150)))
    assert np.max(np.abs(drifted - loop(dynamic, neutral(150)))) > 0.01


def test_direction_position_and_knees_are_those_of_the_law_driver() -> None:
    """The driver of `compare` simulates the same mass with the same extension."""
    laws = AxisLaws(
        backward=AxisFrictionLevels(0.08, 0.6, 0.9),
        regimes=(ViscousRegime(0.5, 0.12, 0.15),),
        stribeck_velocity=VELOCITY_SCALE,
        shape=FrictionPositionShape(
            -0.2, 0.3, ((1.0, 0.8), (1.0, -0.4)), ((1.0, 0.8), (1.0, -0.4))
        ),
    )
    axis = AXIS._replace(offset=0.0, constant=1.0, lag=0.0, laws=laws)
    dynamic = dynamic_law("lugre", axis)
    array, state = started_axis(dynamic, axis)
    efforts = (2.5, -1.8, 0.7, -3.0)
    ends = 0.05 * np.arange(1, 5)
    segments = [(float(end), held(effort)) for end, effort in zip(ends, efforts, strict=True)]
    settings = LawRunSettings(
        speed_scale=VELOCITY_SCALE, length_scale=Z_MAX, extension=dynamic.extension
    )
    ran = run_law(dynamic.law, dynamic.p, axis.inertia, segments, ends, settings)
    assert ran.status == OK
    for k, effort in enumerate(efforts):
        for _ in range(50):
            assert advance(state, effort, array, PERIOD) == OK
        assert state[POSITION] == pytest.approx(ran.position[k], abs=AGREES * Z_MAX)
    assert np.ptp(ran.position) > 10.0 * Z_MAX


def test_a_contact_is_never_held() -> None:
    """The machine code of a controller skips samples of an axis at rest; a contact moves on."""
    array, state = started_axis(dynamic_law("lugre"))
    assert not is_held(state, 0.1, array)
    assert is_held(rest(), 0.1, AXIS.as_array())
