"""The effort until the next sample from what was commanded: the exact integral of the drive's lag,
delayed."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from frictool.control.compiled_program import compile_program, read, run_values
from frictool.control.drive_model import mean_effort
from frictool.control.program import Program

CONSTANT, BOUND = 13.4e-3, 50.0


def efforts(commands: list[float], delay: int, lag: float, period: float) -> list[float]:
    """Return the efforts of the block, sample by sample."""
    program = Program()
    drive = program.input("drive", -BOUND, BOUND)
    program.output = mean_effort(program, drive, CONSTANT, BOUND, delay, lag, period)
    running, found = compile_program(program), []
    for command in commands:
        running.real[drive.index] = command
        run_values(running.code, running.terms, running.writes, running.real)
        found.append(read(running, program.output.index))
    return found


@given(
    st.lists(st.floats(-BOUND, BOUND), min_size=1, max_size=12),
    st.integers(0, 2),
    st.one_of(st.just(0.0), st.floats(1e-4, 1.0)),
    st.floats(1e-4, 1e-2),
)
def test_it_is_the_mean_over_the_sample_of_what_a_lag_makes_of_held_commands(
    commands: list[float], delay: int, lag: float, period: float
) -> None:
    drive = 0.0
    for k, effort in enumerate(efforts(commands, delay, lag, period)):
        acting = commands[k - delay] if k >= delay else 0.0
        x = period / lag if lag > 0.0 else math.inf
        mean = acting + (drive - acting) * (-math.expm1(-x) / x if math.isfinite(x) else 0.0)
        drive = acting + (drive - acting) * math.exp(-x)
        assert effort == pytest.approx(CONSTANT * mean, rel=1e-9, abs=1e-12)


def test_the_integral_agrees_with_a_fine_simulation() -> None:
    period, lag, steps = 1e-3, 3e-3, 20_000
    (effort, _) = efforts([10.0, 10.0], 0, lag, period)
    fine = 10.0 * (1.0 - np.exp(-(np.arange(steps) + 0.5) * period / steps / lag))
    assert effort == pytest.approx(CONSTANT * float(fine.mean()), rel=1e-6)
