"""The linear controller: state space and sections against other forms of them, held integrators,
anti-windup, bounds, schedule."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import signal

from frictool.control import difference_equation, second_order_sections
from frictool.control.difference_equation import (
    DifferenceEquation,
    coefficients,
    impulse_sums,
    state_bounds,
)
from frictool.control.drive_limit import limit
from frictool.control.gain_schedule import corner_weights, weighted_coefficients
from frictool.control.program import Program, ProgramNode
from frictool.plant.lti import Lti
from frictool.typing import Matrix
from frictool.verify import scheduled_loop as synthesised
from tests.control.random_controllers import seeds, stable
from tests.support.single_block import Block
from tests.support.single_block import given as input_of


def _equation(
    random: np.random.Generator, n: int, *, integrator: bool = False, gain: float = 1.0
) -> DifferenceEquation:
    a = stable(random, n)
    if integrator:
        a[0], a[0, 0] = 0.0, 1.0
    return DifferenceEquation(
        a,
        random.standard_normal(n),
        random.standard_normal(n),
        float(random.standard_normal()),
        gain * random.standard_normal(n),
    )


def _integrating(random: np.random.Generator, n: int) -> DifferenceEquation:
    """An integrator that moves the drive the way of what enters, beside other states; no
    anti-windup."""
    found = _equation(random, n, integrator=True, gain=0.0)
    a, b, c = found.a.copy(), found.b.copy(), found.c.copy()
    a[1:, 0], b[0], c[0] = 0.0, abs(b[0]), abs(c[0])
    return DifferenceEquation(a, b, c, found.d, found.gains)


def _block(equation: DifferenceEquation, *, conditions: bool = False) -> Block:
    """With inputs entering and excess, and held and resting where `conditions`."""
    n = len(equation.b)

    def build(program: Program) -> ProgramNode:
        k, entering = coefficients(program, equation), input_of(program, "entering")
        drive = difference_equation.output(program, k, entering, np.full(n, 1e9))
        held = resting = None
        if conditions:
            held, resting = (
                input_of(program, name) > program.constant(0.0) for name in ("held", "resting")
            )
        difference_equation.advance(
            program, equation.integrators, k, entering, input_of(program, "excess"), held, resting
        )
        return drive

    return Block(build)


def _states(block: Block, n: int) -> Matrix:
    return np.array([block.value(f"x[{i}]") for i in range(n)])


@given(st.integers(0, 5), seeds)
def test_difference_equation_is_the_state_space(n: int, seed: int) -> None:
    random = np.random.default_rng(seed)
    equation = _equation(random, n)
    block, x = _block(equation), np.zeros(n)
    for entering, excess in random.standard_normal((20, 2)):
        drive = block.step(entering=float(entering), excess=float(excess))
        scale = 1.0 + float(np.max(np.abs(x), initial=0.0))
        assert drive == pytest.approx(equation.c @ x + equation.d * entering, abs=1e-12 * scale)
        x = equation.a @ x + equation.b * entering + equation.gains * excess
        np.testing.assert_allclose(_states(block, n), x, atol=1e-11 * scale)


@given(st.integers(1, 4), seeds)
def test_integrators_are_held_and_the_rest_moves_on(n: int, seed: int) -> None:
    """Held, an integrator keeps every bit, at rest too; the other states go on, or are 0 at rest;
    not held, all are the state space's."""
    random = np.random.default_rng(seed)
    equation = _equation(random, n, integrator=True)
    assert equation.integrators[0] == 0
    block, free, x = _block(equation, conditions=True), _block(equation), random.standard_normal(n)
    for held, resting in ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 0.0)):
        places = {f"x[{i}]": float(value) for i, value in enumerate(x)}
        entering, excess = (float(value) for value in random.standard_normal(2))
        block.set(**places).step(entering=entering, excess=excess, held=held, resting=resting)
        free.set(**places).step(entering=entering, excess=excess)
        expected = np.zeros(n) if resting else _states(free, n)
        if held:
            expected[equation.integrators] = x[equation.integrators]
        np.testing.assert_array_equal(_states(block, n), expected)
        x = _states(block, n)


@given(st.integers(1, 4), seeds)
def test_anti_windup_follows_the_drive_that_is_applied(n: int, seed: int) -> None:
    """With l the state is that of x+ = (a - l c) x + (b - l d) e + l limited: nothing of the
    unlimited drive is left in it."""
    random = np.random.default_rng(seed)
    equation = _equation(random, n, gain=0.1)

    def build(program: Program) -> ProgramNode:
        k, entering = coefficients(program, equation), input_of(program, "entering")
        drive = difference_equation.output(program, k, entering, np.full(n, 1e9))
        bound = program.constant(0.5, "bound")
        limited, _ = limit(program, drive, -bound, bound)
        difference_equation.advance(
            program, equation.integrators, k, entering, limited - drive, None, None
        )
        return limited

    block, x = Block(build), np.zeros(n)
    for entering in random.standard_normal(30):
        limited = block.step(entering=float(entering))
        assert abs(limited) <= 0.5
        x = (equation.a - np.outer(equation.gains, equation.c)) @ x
        x += (equation.b - equation.gains * equation.d) * entering + equation.gains * limited
        np.testing.assert_allclose(
            _states(block, n), x, rtol=1e-8, atol=1e-8 * (1.0 + np.max(np.abs(x)))
        )
        x = _states(block, n)


@given(st.integers(1, 4), seeds)
def test_a_stable_state_reaches_its_bound_and_no_more(n: int, seed: int) -> None:
    """The worst input of each state, which pushes as its impulse response does, comes within 1 % of
    the sum."""
    random = np.random.default_rng(seed)
    a, b = stable(random, n), random.standard_normal(n)
    sums, responses, x = impulse_sums(a, b), [], b
    for _ in range(400):
        responses.append(x)
        x = a @ x
    for i in range(n):
        worst, x = np.sign([response[i] for response in responses])[::-1], np.zeros(n)
        for entering in worst:
            x = a @ x + b * entering
            assert np.all(np.abs(x) <= sums * (1 + 1e-9))
        assert x[i] >= 0.99 * sums[i]


@given(st.integers(1, 4), st.booleans(), seeds)
def test_states_stay_within_their_bounds_under_a_limited_drive(
    n: int, conditional: bool, seed: int
) -> None:
    """For any input, with anti-windup or with an integrator that is held while it would push a
    limited drive further."""
    equation = (
        _integrating(np.random.default_rng(seed), n)
        if conditional
        else _equation(np.random.default_rng(seed), n, gain=0.05)
    )
    bounds = state_bounds(equation, 2.0, 0.5, conditional)
    if not np.all(np.isfinite(bounds)):
        assert (
            np.max(np.abs(np.linalg.eigvals(equation.a - np.outer(equation.gains, equation.c))))
            >= 1.0
        )
        return

    def build(program: Program) -> ProgramNode:
        k, entering = coefficients(program, equation), input_of(program, "entering")
        drive = difference_equation.output(program, k, entering, bounds)
        bound, zero = program.constant(0.5, "bound"), program.constant(0.0)
        limited, met = limit(program, drive, -bound, bound)
        held = met * entering > zero if conditional else None
        difference_equation.advance(
            program, equation.integrators, k, entering, limited - drive, held, None
        )
        return limited

    block = Block(build)
    for period in (1, 3, 50, 400):
        for k in range(400):
            block.step(entering=2.0 if (k // period) % 2 == 0 else -2.0)
            assert np.all(np.abs(_states(block, n)) <= bounds * (1 + 1e-9))


def test_what_nothing_bounds_is_infinite() -> None:
    integrator = DifferenceEquation(np.eye(1), np.ones(1), np.ones(1), 0.0, np.zeros(1))
    assert state_bounds(integrator, 1.0, 1.0, conditional=False).tolist() == [math.inf]
    assert np.isfinite(state_bounds(integrator, 1.0, 1.0, conditional=True)).all()
    backwards = DifferenceEquation(np.eye(1), np.ones(1), -np.ones(1), 0.0, np.zeros(1))
    assert state_bounds(backwards, 1.0, 1.0, conditional=True).tolist() == [math.inf]
    coupled = DifferenceEquation(
        np.array([[1.0, 0.0], [0.5, 0.5]]), np.ones(2), np.ones(2), 0.0, np.zeros(2)
    )
    assert np.isinf(state_bounds(coupled, 1.0, 1.0, conditional=True)).all()
    followed = DifferenceEquation(np.eye(1), np.ones(1), np.ones(1), 0.0, np.array([0.5]))
    assert np.isfinite(state_bounds(followed, 1.0, 1.0, conditional=False)).all()


def _chain(random: np.random.Generator, count: int) -> tuple[tuple[float, ...], ...]:
    rows = []
    for _ in range(count):
        radius, angle = random.uniform(0.0, 0.95), random.uniform(0.0, math.pi)
        rows.append(
            (
                *map(float, random.standard_normal(3)),
                1.0,
                -2.0 * radius * math.cos(angle),
                radius * radius,
            )
        )
    return tuple(rows)


def _sections(
    chain: tuple[tuple[float, ...], ...], gains: Matrix, *, resting: bool = False
) -> Block:
    def build(program: Program) -> ProgramNode:
        drive, passed = second_order_sections.output(
            program, chain, input_of(program, "entering"), np.full(2 * len(chain), 1e9)
        )
        rests = input_of(program, "resting") > program.constant(0.0) if resting else None
        second_order_sections.advance(
            program, chain, gains, passed, input_of(program, "excess"), rests
        )
        return drive

    return Block(build)


@given(st.integers(1, 4), seeds)
def test_sections_are_scipys(count: int, seed: int) -> None:
    random = np.random.default_rng(seed)
    chain, entering = _chain(random, count), random.standard_normal(60)
    found = _sections(chain, np.zeros(2 * count)).run(entering=entering, excess=np.zeros(60))
    expected = signal.sosfilt(np.array(chain), entering)
    np.testing.assert_allclose(found, expected, atol=1e-11 * (1.0 + np.max(np.abs(expected))))


@given(st.integers(1, 3), seeds)
def test_the_realised_chain_is_the_chain_with_its_anti_windup(count: int, seed: int) -> None:
    """State by state, so that what is known of a state space holds of the chain; rest is 0."""
    random = np.random.default_rng(seed)
    chain, gains = _chain(random, count), 0.1 * random.standard_normal(2 * count)
    gains[random.random(2 * count) < 0.3] = 0.0
    a, b, c, d = second_order_sections.chain_state_space(chain)
    block, x = _sections(chain, gains, resting=True), np.zeros(2 * count)
    for k, (entering, excess) in enumerate(random.standard_normal((30, 2))):
        drive = block.step(entering=float(entering), excess=float(excess), resting=float(k == 20))
        assert drive == pytest.approx(c @ x + d * entering, rel=1e-9, abs=1e-9)
        x = np.zeros(2 * count) if k == 20 else a @ x + b * entering + gains * excess
        states = [block.value(f"s[{i // 2}][{i % 2}]") for i in range(2 * count)]
        np.testing.assert_allclose(states, x, rtol=1e-9, atol=1e-9 * (1.0 + np.max(np.abs(x))))


WIDTHS = {"inertia": (1.11e-5, 1.53e-5), "coulomb": (0.018, 0.180), "constant": (12.8e-3, 14.0e-3)}


@given(
    st.integers(1, 3),
    st.integers(0, 3),
    seeds,
    st.lists(st.floats(-0.5, 1.5), min_size=3, max_size=3),
)
def test_the_schedule_is_the_synthesised_one(
    count: int, n: int, seed: int, shares: list[float]
) -> None:
    """Weights (5.46) are not negative, sum to 1 and are synthesis's; so are the matrices (5.64);
    outside, a parameter is at its end."""
    random, names = np.random.default_rng(seed), list(WIDTHS)[:count]
    corners = [
        {name: WIDTHS[name][index >> k & 1] for k, name in enumerate(names)}
        for index in range(2**count)
    ]
    equations = [_equation(random, n) for _ in corners]

    seen: dict[str, list[int]] = {}

    def build(program: Program) -> ProgramNode:
        weights = corner_weights(program, names, corners)
        k = weighted_coefficients(program, equations, weights)
        flat = [*[node for row in k.a for node in row], *k.b, *k.c, k.d]
        seen.update(weights=[node.index for node in weights], values=[node.index for node in flat])
        return k.d

    block = Block(build)
    at = {
        name: WIDTHS[name][0] + share * (WIDTHS[name][1] - WIDTHS[name][0])
        for name, share in zip(names, shares, strict=False)
    }
    block.set(**at).step()
    alpha = block.machine.real[seen["weights"]]
    assert np.min(alpha) >= -1e-15
    assert np.sum(alpha) == pytest.approx(1.0, abs=1e-12)
    expected = synthesised.weights(
        [SimpleNamespace(**corner) for corner in corners], names, SimpleNamespace(**at)
    )
    np.testing.assert_allclose(alpha, expected, atol=1e-12)
    mixed = synthesised.interpolate_controller(
        [Lti(e.a, e.b[:, None], e.c[None, :], np.array([[e.d]]), 1e-3) for e in equations], expected
    )
    wanted = np.concatenate([mixed.a.ravel(), mixed.b.ravel(), mixed.c.ravel(), mixed.d.ravel()])
    np.testing.assert_allclose(block.machine.real[seen["values"]], wanted, atol=1e-10)
