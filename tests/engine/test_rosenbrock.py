"""The Rosenbrock step: its order, that of its dense output, and that it does not mind how fast the
contact relaxes."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm

from frictool.engine.rosenbrock import CONTACT, NODES, STAGES, between, complete_stage, stage_point


def linear(own: np.ndarray, couplings: np.ndarray, ramp: float) -> tuple[np.ndarray, np.ndarray]:
    """The matrix that the arrow stands for, and the part that grows with time: v' has the term ramp
    t."""
    m = couplings.shape[1]
    matrix = np.zeros((CONTACT + m, CONTACT + m))
    matrix[0, 1] = matrix[2, 0] = 1.0
    matrix[1, :CONTACT] = -own
    matrix[1, CONTACT:] = -couplings[2]
    matrix[CONTACT:, 1] = couplings[0]
    matrix[CONTACT:, CONTACT:] = np.diag(couplings[1])
    growing = np.zeros(CONTACT + m)
    growing[1] = ramp
    return matrix, growing


def step(
    own: np.ndarray,
    couplings: np.ndarray,
    ramp: float,
    y: np.ndarray,
    t: float,
    h: float,
    share: float = 1.0,
) -> tuple[np.ndarray, np.ndarray]:
    """One step from y at t: its end, and the dense output at the share of it."""
    matrix, growing = linear(own, couplings, ramp)
    stages, end, at = np.zeros((STAGES, y.size)), y.copy(), y.copy()
    in_time = growing[:CONTACT].copy()
    for i in range(STAGES):
        stage_point(y, stages, i, y.size, end)
        stages[i] = matrix @ end + growing * (t + NODES[i] * h)
        complete_stage(own, couplings, in_time, h, i, stages)
    end += stages[STAGES - 1]
    between(y, end, stages, share, y.size, at)
    return end, at


def exact(
    own: np.ndarray, couplings: np.ndarray, ramp: float, y: np.ndarray, t: float, h: float
) -> np.ndarray:
    """The solution by the exponential of the matrix, time and 1 taken in as states."""
    matrix, growing = linear(own, couplings, ramp)
    whole = np.zeros((y.size + 2, y.size + 2))
    whole[: y.size, : y.size], whole[: y.size, y.size], whole[y.size, y.size + 1] = (
        matrix,
        growing,
        1.0,
    )
    return np.asarray(expm(h * whole) @ np.concatenate([y, [t, 1.0]]))[: y.size]


OWN, COUPLINGS = np.array([3.0, 2.0, 0.5]), np.array([[1.0, 0.4], [-2.0, -5.0], [4.0, -1.0]])
START = np.array([0.3, -1.0, 0.2, 0.5, -0.4])


@pytest.mark.parametrize(("share", "order"), [(1.0, 4), (0.4, 3)])
def test_the_error_of_a_step_falls_with_its_order(share: float, order: int) -> None:
    errors = []
    for h in (0.04, 0.02):
        found = step(OWN, COUPLINGS, 0.7, START, 0.1, h, share)[1]
        errors.append(np.max(np.abs(found - exact(OWN, COUPLINGS, 0.7, START, 0.1, share * h))))
    assert math.log2(errors[0] / errors[1]) > order + 0.7  # of one step: h^(order + 1)


@given(st.floats(2.0, 9.0), st.floats(-4.0, -1.0))
def test_a_contact_relaxes_in_one_step_however_fast_it_is(rate: float, length: float) -> None:
    """z' = -10^rate z beside a resting mass: L-stable: it never grows, and is gone where the step
    is longer than the relaxation."""
    fast, h = -(10.0**rate), 10.0**length
    found = step(
        np.zeros(3), np.array([[0.0], [fast], [0.0]]), 0.0, np.array([0.0, 0.0, 0.0, 1.0]), 0.0, h
    )[0]
    assert abs(found[CONTACT]) <= min(1.0, -10.0 / (fast * h))
    assert np.all(found[:CONTACT] == 0.0)
