"""Table 5.1's loops: the figures that are known of them, as the product plays them, and that the
reference is what studies/table_5_1/reference_loops.py says."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import cont2discrete, dlsim

from frictool.documents.controller import ProgramNumber
from frictool.engine.axis_motion import advance
from frictool.engine.status_codes import OK
from frictool.plant.axis import POSITION, VELOCITY, rest
from studies.table_5_1.product_loops import played
from studies.table_5_1.published_figures import LOOPS, figures, missed
from studies.table_5_1.reference_loops import (
    DERIVATIVE_TIME,
    DRY,
    GAIN,
    INTEGRAL_TIME,
    LAG,
    LIMIT,
    LIMITER,
    PERIOD,
    SMOOTH,
    integrate,
    on_the_way,
    pid_output,
    pid_step,
    printed_step,
)

RESTS = [name for name, loop in LOOPS.items() if loop.printed[4] == "nan"]
SECONDS = (
    240.0  # the PID's cycle is steady after two minutes; 600 s in tests/accept/check_table_5_1.py
)


@cache
def _pid_figures() -> dict[str, float]:
    return figures(LOOPS["pid"].step(SECONDS))


@pytest.mark.parametrize("name", LOOPS)
def test_the_product_has_the_figures(name: str) -> None:
    found = figures(played(name, SECONDS))
    assert missed(found, LOOPS[name].printed) == [], found


@pytest.mark.parametrize("name", LOOPS)
def test_the_product_is_the_slow_reference(name: str) -> None:
    """Written down twice, independently: documents and a program of operations here, the text's
    loop in plain kernels there."""
    seconds = 3.0  # a limit cycle lets what differs grow from one breakaway to the next
    apart = (
        2e-6 if name != "smooth_limiter_virtual" else 3e-5
    )  # the encoder's 1 nm; the function that the target has in place of tanh
    np.testing.assert_allclose(
        played(name, seconds), LOOPS[name].step(seconds), rtol=0.0, atol=apart
    )


@pytest.mark.parametrize("name", RESTS)
@pytest.mark.parametrize("number", ["float", "q31"])
def test_what_rests_has_its_figures_in_other_number_formats(
    name: str, number: ProgramNumber
) -> None:
    found = figures(played(name, 40.0, number))
    assert missed(found, LOOPS[name].printed) == [], found


def test_the_virtual_friction_as_printed_does_not_move() -> None:
    """(5.41): outside the band, where the mass rests, the printed branch is -F_cv tanh(0) = 0."""
    assert np.all(printed_step(10.0) == 0.0)
    assert np.max(played("smooth_limiter_virtual", 10.0)) > 0.97


@pytest.mark.parametrize(
    ("figure", "value"),
    [
        ("overshoot_percent", 47.5),
        ("response_95_s", 200.0),
        ("static_error_m", 0.0829),
        ("amplitude_m", 0.0858),
        ("period_s", math.nan),
    ],
)
def test_a_figure_more_than_two_percent_off_is_missed(figure: str, value: float) -> None:
    found = _pid_figures() | {figure: value}
    assert missed(found, LOOPS["pid"].printed) == [figure]


@given(st.lists(st.floats(-1.0, 1.0), min_size=2, max_size=40))
def test_pid_is_the_zero_order_hold_equivalent(errors: list[float]) -> None:
    numerator = np.polyadd(
        np.polymul([LAG, 1.0], [INTEGRAL_TIME, 1.0]), [DERIVATIVE_TIME * INTEGRAL_TIME, 0.0, 0.0]
    )
    system = (GAIN * numerator, np.polymul([LAG, 1.0], [INTEGRAL_TIME, 0.0]))
    _, expected = dlsim(cont2discrete(system, PERIOD), np.array(errors))
    memory, outputs = np.zeros(2), []
    for error in errors:
        outputs.append(pid_output(memory, error))
        integrate(memory, error, 0.0)
    np.testing.assert_allclose(outputs, expected[:, 0], rtol=1e-9, atol=1e-9)


@given(st.floats(-1.0, 1.0), st.floats(-20.0, 20.0))
def test_a_limited_command_is_not_driven_further(error: float, command: float) -> None:
    memory = np.zeros(1)
    integrate(memory, error, command)
    further = abs(command) > LIMIT and math.copysign(1.0, command) * error > 0.0
    assert memory[0] == (0.0 if further else PERIOD * error)


@given(st.floats(0.05, 3.0), st.sampled_from([-1.0, 1.0]), st.floats(-0.019, 0.019))
def test_inside_the_condition_friction_alone_ends_in_the_band(
    speed: float, direction: float, aside: float
) -> None:
    state, array = rest(), DRY.as_array()
    state[VELOCITY] = direction * speed
    target = direction * (speed**2 / 2.0 + aside)
    assert on_the_way(target, state[VELOCITY], DRY.coulomb) == (
        abs(abs(target) - speed**2 / 2.0) < 0.02
    )
    for _ in range(4):
        assert advance(state, 0.0, array, 1.0) == OK
    assert state[VELOCITY] == 0.0
    assert abs(target - state[POSITION]) == pytest.approx(abs(aside), abs=1e-12)


def test_printed_integral_time_is_unstable() -> None:
    """T_i = 0.1: the loop without friction and filter, s^3 + K T_d s^2 + K s + K/T_i."""
    assert max(np.roots([1.0, 2.1 * 3.4, 2.1, 2.1 / 0.1]).real) == pytest.approx(0.055, abs=5e-4)
    assert max(np.roots([1.0, 2.1 * 3.4, 2.1, 2.1 / 1.0]).real) < -0.1


def test_printed_slope_of_the_virtual_friction_hardly_brakes() -> None:
    """v_r = 10 m/s instead of 0.01: it runs past the target by half of the step."""
    found = figures(pid_step(20.0, SMOOTH, LIMITER, virtual=1.0, slope=10.0))
    assert found["overshoot_percent"] > 40.0
    assert found["response_95_s"] > 10.0
