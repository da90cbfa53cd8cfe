"""Systems in memory: sampling is exact where it says so, and a diagram is the algebra of its
blocks."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import signal

from frictool.plant.block_diagram import DiagramBlock, connect
from frictool.plant.lti import Lti, delay, gain, inverse_tustin, tustin, zero_order_hold


def random_system(
    seed: int, n: int = 3, inputs: int = 2, outputs: int = 2, period: float = 0.0
) -> Lti:
    random = np.random.default_rng(seed)
    a = random.normal(size=(n, n)) - 2.0 * np.eye(n)
    return Lti(
        a,
        random.normal(size=(n, inputs)),
        random.normal(size=(outputs, n)),
        random.normal(size=(outputs, inputs)),
        period,
    )


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10_000))
def test_sampling_agrees_with_scipy(seed: int) -> None:
    system = random_system(seed)
    for ours, method in ((zero_order_hold(system, 0.1), "zoh"), (tustin(system, 0.1), "bilinear")):
        a, b, c, d, _ = signal.cont2discrete((system.a, system.b, system.c, system.d), 0.1, method)
        theirs = Lti(a, b, c, d, 0.1)
        assert ours.response([0.1, 3.0, 30.0]) == pytest.approx(
            theirs.response([0.1, 3.0, 30.0]), rel=1e-7, abs=1e-9
        )


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10_000), st.floats(0.01, 25.0))
def test_prewarping_is_exact_at_its_frequency_and_tustin_has_an_inverse(
    seed: int, frequency: float
) -> None:
    system = random_system(seed)
    assert tustin(system, 0.1, frequency).response(frequency) == pytest.approx(
        system.response(frequency), rel=1e-7, abs=1e-9
    )
    back = inverse_tustin(tustin(system, 0.1))
    assert back.response([0.3, 7.0]) == pytest.approx(
        system.response([0.3, 7.0]), rel=1e-7, abs=1e-9
    )


def test_a_prewarping_frequency_above_half_the_sampling_is_refused() -> None:
    with pytest.raises(ValueError, match="prewarping"):
        tustin(random_system(1), 0.1, 40.0)


@pytest.mark.parametrize("samples", [0, 1, 2, 5])
def test_a_delay_delays(samples: int) -> None:
    response = delay(samples, 1e-3).response([10.0, 700.0])[:, 0, 0]
    assert response == pytest.approx(np.exp(-1j * np.array([10.0, 700.0]) * 1e-3 * samples))


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10_000))
def test_a_feedback_diagram_is_the_algebra_of_its_blocks(seed: int) -> None:
    p, k = random_system(seed, 3, 1, 1), random_system(seed + 1, 2, 1, 1)
    blocks = {"p": DiagramBlock(p, ("u",), ("y",)), "k": DiagramBlock(k, ("e",), ("u",))}
    loop = connect(blocks, {"e": {"r": 1.0, "y": -2.0}}, ("r",), ("y", "e"))
    w = np.array([0.3, 2.0, 40.0])
    open_loop = p.response(w)[:, 0, 0] * k.response(w)[:, 0, 0]
    assert loop.response(w)[:, 0, 0] == pytest.approx(open_loop / (1 + 2 * open_loop), rel=1e-6)
    assert loop.response(w)[:, 1, 0] == pytest.approx(1 / (1 + 2 * open_loop), rel=1e-6)


def test_a_diagram_with_a_mistake_is_refused() -> None:
    one = DiagramBlock(gain(1.0, 0.0), ("u",), ("y",))
    with pytest.raises(ValueError, match="no block provides the signal u"):
        connect({"p": one}, {}, (), ("y",))
    with pytest.raises(ValueError, match="two sources"):
        connect({"p": one}, {}, ("u", "y"), ("y",))
    with pytest.raises(ValueError, match="algebraic loop"):
        connect({"p": one}, {"u": {"y": 1.0}}, (), ("y",))
    with pytest.raises(ValueError, match="different periods"):
        connect({"p": one, "q": DiagramBlock(gain(1.0, 1e-3), ("y",), ("z",))}, {}, ("u",), ("z",))
