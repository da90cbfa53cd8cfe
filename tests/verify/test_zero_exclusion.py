"""Zero exclusion proves what is true of every constant plant, of the loop given to it, and nothing
else."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from functools import cache

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import zpk2ss

from frictool.adapters.state_space import stored_state_space
from frictool.documents.certificate import Box, Certificate, CertifiedWeights, Filter
from frictool.documents.controller import StateSpace
from frictool.errors import NoSolutionError
from frictool.plant.generalised_plant import generalised_plant
from frictool.plant.linear_axis import AxisRates
from frictool.plant.lti import Lti, tustin
from frictool.synth.certificate_bounds import certify
from frictool.verify import zero_exclusion
from frictool.verify.certificate_loop import CertificateLoop, quantity_loops
from frictool.verify.exponential_enclosure import hold_polynomials
from frictool.verify.feedback_loops import chain
from frictool.verify.loop_values import weights_of
from frictool.verify.speed_loop import check_loop, performance
from frictool.verify.zero_exclusion import OpenCell, prove, prove_bound, prove_bounds
from frictool.verify.zero_exclusion_kernel import (
    KernelLoop,
    enclose_responses,
    inverse_inertia,
    loop_terms,
    turn,
    workspace,
)
from tests.verify.gentle_loop import BOX, GENTLE, LAG, LOOP, PERIOD, WEIGHTS

ALL = CertifiedWeights(Filter(31.5, 40.0, 0.635), 0.03, 0.5, 0.2, Filter(0.01, 40.0, 400.0), 0.1)
# a section of the second order, one of the first, one that is a delay, one that is a gain
SECTIONS = (
    (0.02, 0.01, 0.003, 1.0, -1.4, 0.5),
    (1.0, -0.9, 0.0, 1.0, -0.95, 0.0),
    (0.0, 1.0, 0.0, 1.0, 0.0, 0.0),
    (1.5, 0.0, 0.0, 1.0, 0.0, 0.0),
)
PINNED = Box((1.32e-5, 1.32e-5), (0.0, 0.0), (0.099, 0.099), (0.0134, 0.0134))


@cache
def _certificate() -> Certificate:
    return certify(LOOP, BOX)[0]


def _changed(loop: CertificateLoop, change: object) -> CertificateLoop:
    """The loop with every coefficient c changed to change(c)."""
    k = loop.controller
    parts = (
        tuple(tuple(change(value) for value in row) for row in matrix)
        for matrix in (k.a, k.b, k.c, k.d)
    )
    return replace(loop, controller=StateSpace(*parts))


def _kernel_loop(loop: CertificateLoop, box: Box) -> KernelLoop:
    ratio = Fraction(loop.period) / Fraction(loop.lag) if loop.lag else Fraction(0)
    rates = zero_exclusion._surroundings(box, loop.period)[1]
    return zero_exclusion._kernel_loop(loop, hold_polynomials(ratio, *rates))


def _enclosed(
    loop: CertificateLoop, box: Box, plant: tuple[float, float, float], chart: int, t: float
) -> tuple[object, complex, float]:
    """T, D and T's remainder at one frequency of one plant (inertia, viscous, constant)."""
    plants = zero_exclusion._kernel_box(box, loop.period)
    j, sigma, k = plant
    rate = sigma * loop.period / j
    one = _kernel_loop(loop, box)
    kappa = k * loop.period**2 / j
    cell = np.array([t, t, kappa, kappa, *[rate - one.middle] * 2])
    space = workspace(one)
    terms = loop_terms(one, plants, chart, cell, space)
    remainder = enclose_responses(one, terms, space)
    return space.parts[0].copy(), terms.whole[0], remainder


@pytest.mark.parametrize("controlled", ["speed", "position"])
@pytest.mark.parametrize("lag", [0.0, LAG])
@pytest.mark.parametrize("delay", [0, 1, 2])
@pytest.mark.parametrize(
    "noise", [Filter(0.0), Filter(0.01), Filter(0.01, 40.0, 400.0), Filter(0.01, None, 400.0)]
)
def test_the_enclosed_responses_are_those_of_the_generalised_plant_closed(
    controlled: str, lag: float, delay: int, noise: Filter
) -> None:
    weights = msgspec.structs.replace(ALL, noise=noise)
    loop = CertificateLoop(stored_state_space(GENTLE), controlled, delay, lag, PERIOD, weights)
    j, sigma, k, coulomb = 1.3e-5, 3e-4, 0.0132, 0.1
    box = Box((j, j), (sigma, sigma), (-coulomb, 0.0), (k, k))
    plant = generalised_plant(
        controlled,
        AxisRates(k / j, sigma / j, coulomb / j),
        lag,
        weights_of(weights),
        PERIOD,
        delay,
    )
    closed = plant.closed(GENTLE)
    for chart, t in ((0, 5e-4), (0, 0.02), (0, 0.9), (1, 0.3), (1, 0.0)):
        z = (1 + 1j * t) / (1 - 1j * t) if chart == 0 else (t + 1j) / (t - 1j)
        plain = closed.d + closed.c @ np.linalg.solve(z * np.eye(closed.order) - closed.a, closed.b)
        found, _, remainder = _enclosed(loop, box, (j, sigma, k), chart, t)
        assert found == pytest.approx(plain, rel=1e-8, abs=1e-9 * np.max(abs(plain)))
        assert remainder < 1e-10 * np.max(abs(plain))


@pytest.mark.parametrize("lag", [0.0, LAG])
@pytest.mark.parametrize("delay", [0, 1])
def test_the_enclosed_responses_are_those_of_the_sections(lag: float, delay: int) -> None:
    loop = CertificateLoop(stored_state_space(GENTLE), "speed", delay, lag, PERIOD, ALL, SECTIONS)
    j, sigma, k, coulomb = 1.3e-5, 3e-4, 0.0132, 0.1
    rates = AxisRates(k / j, sigma / j, coulomb / j)
    plant = generalised_plant("speed", rates, lag, weights_of(ALL), PERIOD, delay)
    closed = plant.closed(chain(SECTIONS, PERIOD))
    box = Box((j, j), (sigma, sigma), (0.0, coulomb), (k, k))
    for t in (5e-4, 0.02, 0.9):
        plain = closed.response(np.array([2.0 * np.arctan(t) / PERIOD]))[0]
        found, _, _ = _enclosed(loop, box, (j, sigma, k), 0, t)
        assert found == pytest.approx(plain, rel=1e-8, abs=1e-9 * np.max(abs(plain)))


def _in_sections() -> CertificateLoop:
    """LOOP, its controller of order 1 as one section."""
    (a,), (b,), (c,), (d,) = GENTLE.a.ravel(), GENTLE.b.ravel(), GENTLE.c.ravel(), GENTLE.d.ravel()
    return replace(LOOP, sections=((float(d), float(b * c - a * d), 0.0, 1.0, float(-a), 0.0),))


def test_a_loop_of_sections_is_proved_and_a_changed_section_is_not() -> None:
    assert prove(_certificate(), _in_sections()) == prove(_certificate(), LOOP)
    (section,) = _in_sections().sections
    for place, factor in ((0, 1.2), (1, 0.8), (4, 1.2)):
        spoilt = (*section[:place], factor * section[place], *section[place + 1 :])
        with pytest.raises(NoSolutionError, match="not proved"):
            prove(_certificate(), replace(_in_sections(), sections=(spoilt,)))
    other = msgspec.structs.replace(LOOP.controller, d=((0.0,),))  # beside the sections it is idle
    assert prove(_certificate(), replace(_in_sections(), controller=other))


@given(seed=st.integers(0, 10**6))
@settings(max_examples=20, deadline=None)
def test_every_plant_of_a_cell_lies_in_its_enclosure(seed: int) -> None:
    random = np.random.default_rng(seed)
    loop = replace(
        LOOP,
        weights=ALL,
        lag=float(random.choice([0.0, LAG])),
        controlled=str(random.choice(["speed", "position"])),
        delay=int(random.integers(0, 3)),
    )
    box = Box((1.1e-5, 1.5e-5), (-1e-4, 8e-4), (0.0, 0.18), (0.0128, 0.014))
    plants = zero_exclusion._kernel_box(box, PERIOD)
    one = _kernel_loop(loop, box)
    chart = int(random.integers(0, 2))
    middle = np.array([random.uniform(0, 1) ** 3, random.uniform(8e-4, 1.3e-3), 0.0])
    middle[2] = random.uniform(-0.008, 0.07) - one.middle
    half = np.array([0.2 * middle[0], 1e-4, 5e-3]) * 10.0 ** random.uniform(-4, 0)
    space = workspace(one)
    cell = np.column_stack([middle - half, middle + half]).ravel()
    terms = loop_terms(one, plants, chart, cell, space)
    remainder = enclose_responses(one, terms, space)
    if not np.isfinite(remainder):
        return
    parts = space.parts.copy()
    for _ in range(20):
        e = random.choice([-1.0, 1.0, *random.uniform(-1, 1, 3)], 3)
        at = np.clip(middle + e * half, cell[0::2], cell[1::2])
        here = loop_terms(one, plants, chart, np.repeat(at, 2), space)
        at_point = enclose_responses(one, here, space)
        # the friction of the point may have another majorant; phi scales the friction's column
        model = parts[0] + np.tensordot((at - middle) / half, parts[1:], 1)
        phi = terms.phi[0] + np.dot((at - middle) / half, terms.phi[1:4])
        exact = space.parts[0].copy()
        exact[:, 1] *= (phi / here.phi[0]).real
        assert np.linalg.norm(exact - model) <= remainder * (1.0 + 1e-9) + 2.0 * at_point


def test_what_is_proved_is_close_to_what_is_seen_and_never_below() -> None:
    proved = {one.of: one.below for one in prove(_certificate(), LOOP)}
    worst = {"norm": 0.0, "sensitivity": 0.0}
    random = np.random.default_rng(20)
    ends = [BOX.inertia, BOX.viscous, BOX.coulomb, BOX.constant]
    inside = np.array([random.uniform(*interval, 60) for interval in ends]).T
    for j, sigma, coulomb, k in np.vstack([np.array(np.meshgrid(*ends)).reshape(4, -1).T, inside]):
        rates = AxisRates(k / j, sigma / j, coulomb / j)
        norm = performance(
            GENTLE, generalised_plant("speed", rates, LAG, weights_of(WEIGHTS), PERIOD, 1)
        )
        peak = 1.0 / check_loop(GENTLE, rates, LAG, 1).modulus_margin
        assert norm < proved["norm"]
        assert peak < proved["sensitivity"]
        worst = {"norm": max(worst["norm"], norm), "sensitivity": max(worst["sensitivity"], peak)}
    for of, below in proved.items():
        assert below <= 1.002 * worst[of]


@pytest.mark.parametrize(
    "seed", [*range(10), *(pytest.param(seed, marks=pytest.mark.accept) for seed in range(10, 20))]
)
def test_no_random_loop_has_a_plant_above_its_bound(seed: int) -> None:
    """Random controllers, weights and boxes; the plants that are sampled include the corners."""
    random = np.random.default_rng(seed)
    controller = Lti(
        *(np.array([[value]]) for value in (random.uniform(-0.5, 0.99), 1.0)),
        np.array([[random.uniform(-15, 5)]]),
        np.array([[random.uniform(5, 40)]]),
        PERIOD,
    )
    loop = CertificateLoop(
        stored_state_space(controller),
        str(random.choice(["speed", "position"])),
        int(random.integers(0, 3)),
        float(random.choice([0.0, LAG])),
        PERIOD,
        ALL if random.integers(2) else WEIGHTS,
    )
    j = np.sort(random.uniform(1e-5, 2e-5, 2))
    sigma = np.sort(random.uniform(-1e-4, 1e-3, 2))
    k = np.sort(random.uniform(0.01, 0.015, 2))
    coulomb = np.sort(random.uniform(-0.05, 0.2, 2))
    box = Box(*(tuple(map(float, ends)) for ends in (j, sigma, coulomb, k)))
    try:
        proved = certify(loop, box)[1]
    except NoSolutionError:  # an unstable plant
        return
    assert {one.of for one in proved} == {"norm", "sensitivity"}
    seen = {"norm": 0.0, "sensitivity": 0.0}
    corners = np.array(np.meshgrid(j, sigma, k)).reshape(3, -1).T
    inside = random.uniform([j[0], sigma[0], k[0]], [j[1], sigma[1], k[1]], (15, 3))
    for inertia, viscous, constant in np.vstack([corners, inside]):
        rates = AxisRates(constant / inertia, viscous / inertia, max(abs(coulomb)) / inertia)
        for of in seen:
            (one,) = quantity_loops(loop, of)
            plant = generalised_plant(
                one.controlled, rates, one.lag, weights_of(one.weights), PERIOD, one.delay
            )
            seen[of] = max(seen[of], performance(controller, plant))
    for bound in proved:
        assert seen[bound.of] < bound.below <= 1.06 * seen[bound.of]


@given(seed=st.integers(0, 10**6))
@settings(max_examples=5, deadline=None)
def test_coefficients_changed_in_the_twelfth_digit_are_proved_as_well(seed: int) -> None:
    random = np.random.default_rng(seed)
    changed = _changed(LOOP, lambda value: value * (1.0 + 1e-12 * random.uniform(-1.0, 1.0)))
    assert changed != LOOP
    assert [one.of for one in prove(_certificate(), changed)] == ["norm", "sensitivity"]


@pytest.mark.parametrize(
    ("matrix", "factor", "told"),
    [
        ("b", 0.98, r"< .* at inertia .* and [0-9.e+]+ rad/s"),
        ("c", 0.98, r"< .* at inertia .* and [0-9.e+]+ rad/s"),
        ("d", 1.2, "the loop of the plant in the middle of the intervals is unstable"),
    ],
)
def test_a_changed_coefficient_fails_and_the_reason_is_named(
    matrix: str, factor: float, told: str
) -> None:
    k = LOOP.controller
    other = tuple(tuple(factor * value for value in row) for row in getattr(k, matrix))
    changed = replace(LOOP, controller=msgspec.structs.replace(k, **{matrix: other}))
    with pytest.raises(NoSolutionError, match=rf"not proved: .*{told}"):
        prove(_certificate(), changed)


@pytest.mark.parametrize("change", [{"delay": 2}, {"lag": 1.3 * LAG}, {"period": 0.7 * PERIOD}])
def test_another_loop_is_not_proved(change: dict[str, float]) -> None:
    with pytest.raises(NoSolutionError, match="not proved"):
        prove(_certificate(), replace(LOOP, **change))


@pytest.mark.parametrize("factor", [0.9, 0.998])
@pytest.mark.parametrize("index", [0, 1])
def test_a_bound_below_the_truth_is_never_proved(index: int, factor: float) -> None:
    bound = _certificate().bounds[index]
    lower = msgspec.structs.replace(bound, below=factor * bound.below)
    with pytest.raises(NoSolutionError, match=f"not proved: {bound.of} < .* rad/s"):
        prove(msgspec.structs.replace(_certificate(), bounds=(lower,)), LOOP)


@pytest.mark.parametrize("of", ["norm", "sensitivity"])
def test_the_plant_that_is_named_violates_the_bound(of: str) -> None:
    (loop,) = quantity_loops(LOOP, of)
    bound = next(bound for bound in _certificate().bounds if bound.of == of)
    found = prove_bound(loop, BOX, 0.97 * bound.below)
    assert isinstance(found, OpenCell)
    assert found.violated
    for name in ("inertia", "viscous", "constant"):
        low, high = getattr(BOX, name)
        assert low * (1.0 - 1e-9) <= getattr(found, name) <= high * (1.0 + 1e-9)
    rates = AxisRates(
        found.constant / found.inertia, found.viscous / found.inertia, 0.18 / found.inertia
    )
    plant = generalised_plant(
        loop.controlled, rates, LAG, weights_of(loop.weights), PERIOD, loop.delay
    )
    response = plant.closed(GENTLE).response(np.array([found.frequency]))[0]
    assert np.linalg.norm(response, 2) == pytest.approx(0.985 * bound.below, rel=0.017)


def test_more_friction_than_was_proved_for_fails() -> None:
    more = msgspec.structs.replace(BOX, coulomb=(0.0, 0.8))
    with pytest.raises(NoSolutionError, match="not proved: norm"):
        prove(msgspec.structs.replace(_certificate(), box=more), LOOP)


@pytest.mark.parametrize(
    ("name", "wider"),
    [("inertia", (1.2e-5, 1.4e-5)), ("constant", (0.0130, 0.0140)), ("viscous", (-4e-4, 2e-4))],
)
def test_a_wider_box_is_not_proved(name: str, wider: tuple[float, float]) -> None:
    box = msgspec.structs.replace(BOX, **{name: wider})
    with pytest.raises(NoSolutionError, match="not proved"):
        prove(msgspec.structs.replace(_certificate(), box=box), LOOP)


def test_a_certificate_without_bounds_proves_nothing() -> None:
    with pytest.raises(NoSolutionError, match="states no bound"):
        prove(msgspec.structs.replace(_certificate(), bounds=()), LOOP)


@pytest.mark.parametrize("lag", [0.0, LAG])
@pytest.mark.parametrize("delay", [0, 2])
def test_benches_without_lag_or_delay_and_parameters_known_exactly(lag: float, delay: int) -> None:
    loop = replace(LOOP, lag=lag, delay=delay)
    certificate, proved = certify(loop, PINNED)
    assert not certificate.not_proved
    rates = AxisRates(0.0134 / 1.32e-5, 0.0, 0.099 / 1.32e-5)
    norm = performance(
        GENTLE, generalised_plant("speed", rates, lag, weights_of(WEIGHTS), PERIOD, delay)
    )
    assert prove(certificate, loop) == proved
    assert norm < proved[0].below <= 1.002 * norm


def _conditionally_stable() -> tuple[CertificateLoop, Box]:
    """A loop that is stable for both ends of the constant, and unstable between them."""
    a, b, c, d = zpk2ss([-10.0, -11.0, -12.0], [-3.0, -3.6, -1000.0], 1.0)
    controller = tustin(Lti(a, b, c, d, 0.0), PERIOD)
    weights = CertifiedWeights(Filter(1.0), 0.0, 0.0)
    loop = CertificateLoop(stored_state_space(controller), "position", 1, 0.0, PERIOD, weights)
    for constant, stable in ((20.0, True), (500.0, False), (5e4, True)):
        assert check_loop(controller, AxisRates(constant, 2.0, 0.0), 0.0, 1).stable == stable
    return loop, Box((1.0, 1.0), (2.0, 2.0), (0.0, 0.0), (20.0, 5e4))


@pytest.mark.parametrize("bound", [10.0, 1e6, 1e12])
def test_a_plant_inside_that_is_unstable_between_stable_corners_prevents_the_proof(
    bound: float,
) -> None:
    """The plant in the middle of the box is stable too: only the crossing shows it."""
    loop, box = _conditionally_stable()
    for end in box.constant:
        one = msgspec.structs.replace(box, constant=(end, end))
        assert isinstance(prove_bound(loop, one, 10.0), int)
    found = prove_bound(loop, box, bound)
    assert isinstance(found, OpenCell)
    assert 20.0 < found.constant < 5e4
    with pytest.raises(NoSolutionError, match="unstable"):
        certify(loop, box)


def test_one_unstable_corner_prevents_the_proof() -> None:
    box = msgspec.structs.replace(BOX, inertia=(1.0e-6, 1.4e-5))
    corner = AxisRates(0.0134 / 1.0e-6, 1e-4 / 1.0e-6, 0.0)
    assert not check_loop(GENTLE, corner, LAG, 1).stable
    for of in ("norm", "sensitivity"):
        assert isinstance(prove_bounds(quantity_loops(LOOP, of), box, 1e9), OpenCell)


def test_an_unstable_loop_gets_no_certificate() -> None:
    louder = _changed(LOOP, lambda value: 20.0 * value if abs(value) > 1.0 else value)
    with pytest.raises(NoSolutionError, match="unstable at inertia"):
        certify(louder, BOX)
    with pytest.raises(NoSolutionError, match="middle of the intervals is unstable"):
        prove_bound(louder, PINNED, 1e6)


@pytest.mark.parametrize(("reached", "seen"), [(0.0, 1.0), (1.0, 0.0), (0.0, 0.0)])
def test_an_unstable_state_that_no_response_shows_is_found(reached: float, seen: float) -> None:
    """The frequency responses are those of GENTLE; the state with the pole 1.01 is hidden."""
    hidden = Lti(
        np.diag([GENTLE.a[0, 0], 1.01]),
        np.vstack([GENTLE.b, [[reached]]]),
        np.hstack([GENTLE.c, [[seen]]]),
        GENTLE.d,
        PERIOD,
    )
    loop = replace(LOOP, controller=stored_state_space(hidden))
    with pytest.raises(NoSolutionError, match="unstable"):
        prove_bound(loop, PINNED, 1e3)


@given(seed=st.integers(0, 10**6))
@settings(max_examples=30, deadline=None)
def test_the_turn_of_d_counts_the_unstable_roots(seed: int) -> None:
    random = np.random.default_rng(seed)
    n = int(random.integers(1, 4))
    controller = Lti(
        random.normal(size=(n, n)) * 0.6,
        random.normal(size=(n, 1)),
        random.normal(size=(1, n)) * 10.0,
        random.normal(size=(1, 1)) * 30.0,
        PERIOD,
    )
    lag, delay = float(random.choice([0.0, LAG])), int(random.integers(0, 3))
    loop = CertificateLoop(stored_state_space(controller), "position", delay, lag, PERIOD, WEIGHTS)
    plants = zero_exclusion._kernel_box(PINNED, PERIOD)
    one = _kernel_loop(loop, PINNED)
    kappa = 0.0134 * PERIOD**2 / 1.32e-5
    plant = generalised_plant(
        "position", AxisRates(0.0134 / 1.32e-5, 0.0, 0.0), lag,
        weights_of(CertifiedWeights(Filter(1.0), 0.0, 0.0)), PERIOD, delay,
    )  # fmt: skip
    roots = np.linalg.eigvals(plant.closed(controller).a)
    if np.min(abs(abs(roots) - 1.0)) < 1e-6:
        return
    angle, error = turn(one, plants, (kappa, -one.middle), 100_000)
    outside = int(np.sum(abs(roots) > 1.0))
    assert error < 1e-6
    assert angle == pytest.approx(0.5 * np.pi * (len(roots) - 2 * outside), abs=1e-6)


def test_a_plant_that_is_not_in_the_box_is_no_witness() -> None:
    plants = zero_exclusion._kernel_box(BOX, PERIOD)
    one = _kernel_loop(LOOP, BOX)
    assert turn(one, plants, (9.8e-4, 0.0), 1000)[1] < 1e-6
    assert turn(one, plants, (5e-4, 0.0), 1000)[1] == np.inf


@given(seed=st.integers(0, 10**6))
def test_an_empty_rectangle_holds_no_plant(seed: int) -> None:
    random = np.random.default_rng(seed)
    box = Box((1.1e-5, 1.5e-5), (-2e-4, 8e-4), (0.0, 0.18), (0.0128, 0.014))
    if random.integers(2):
        box = msgspec.structs.replace(box, viscous=(1e-4, 8e-4))
    plants = zero_exclusion._kernel_box(box, PERIOD)
    j = random.uniform(*box.inertia, 2000)
    kappa = random.uniform(*box.constant, 2000) * PERIOD**2 / j
    sigma = random.uniform(*box.viscous, 2000) * PERIOD / j
    drive = np.sort(random.uniform(8e-4, 1.3e-3, 2))
    viscous = np.sort(random.uniform(-0.02, 0.08, 2))
    low, high = inverse_inertia(plants, tuple(drive), tuple(viscous))
    inside = (kappa > drive[0]) & (kappa < drive[1]) & (sigma > viscous[0]) & (sigma < viscous[1])
    alpha = PERIOD**2 / j[inside]
    assert np.all((low <= alpha) & (alpha <= high))


def test_a_short_time_constant_of_speed_is_explored_in_pieces() -> None:
    """sigma_v T/J of 4 to 6, in two pieces; a longer time constant is out of range."""
    box = Box((1e-6, 1e-6), (4e-3, 6e-3), (0.0, 0.1), (0.0130, 0.0134))
    proved = certify(LOOP, box)[1]
    seen = [
        performance(
            GENTLE,
            generalised_plant(
                "speed", AxisRates(k * 1e6, s * 1e6, 0.1e6), LAG, weights_of(WEIGHTS), PERIOD, 1
            ),
        )
        for s in (4e-3, 5e-3, 6e-3)
        for k in (0.0130, 0.0134)
    ]
    assert max(seen) < proved[0].below <= 1.01 * max(seen)
    beyond = msgspec.structs.replace(box, viscous=(0.0, 1.0))
    with pytest.raises(NoSolutionError, match="inertia/viscous is below"):
        prove_bound(LOOP, beyond, 1e3)


@pytest.mark.parametrize("value", [np.inf, np.nan, 1e308])
def test_coefficients_that_are_no_numbers_are_refused(value: float) -> None:
    wrong = _changed(LOOP, lambda _: value)
    with pytest.raises(NoSolutionError, match="not proved"):
        prove_bound(wrong, BOX, 10.0)


def test_the_same_loop_gives_the_same_certificate() -> None:
    point = Box((1.32e-5, 1.32e-5), (0.0, 1e-5), (0.099, 0.099), (0.0134, 0.0134))
    assert certify(LOOP, point) == certify(LOOP, point)


def test_a_certificate_of_version_1_is_proved_anew() -> None:
    """Its matrices are not read; what it claims is proved, or refused."""
    cell = {"drive_rate": [1.0, 2.0], "viscous_rate": [0.0, 1.0], "at_low": "1", "at_high": "1"}
    old = {"bits": 22, "factor": [[1.0]], "cells": [cell]}
    for factor, proved in ((1.01, True), (0.9, False)):
        document = msgspec.to_builtins(_certificate()) | {
            "version": 1,
            "bounds": [
                {"of": bound.of, "below": factor * bound.below, **old}
                for bound in _certificate().bounds
            ],
        }
        certificate = msgspec.convert(document, Certificate)
        if proved:
            assert [one.of for one in prove(certificate, LOOP)] == ["norm", "sensitivity"]
            continue
        with pytest.raises(NoSolutionError, match="not proved"):
            prove(certificate, LOOP)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"inertia": (0.0, 1.0)}, "inertia"),
        ({"viscous": (1.0, 0.0)}, "low <= high"),
        ({"constant": (1.0,)}, "constant"),
    ],
)
def test_a_box_that_is_none_is_refused(change: dict[str, tuple[float, ...]], told: str) -> None:
    whole = {
        "inertia": (1.0, 2.0),
        "viscous": (0.0, 1.0),
        "coulomb": (0.0, 1.0),
        "constant": (1.0, 2.0),
    }
    with pytest.raises(ValueError, match=told):
        Box(**{**whole, **change})


def test_a_bound_that_needs_too_many_cells_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(zero_exclusion, "MOST_CELLS", 20)
    with pytest.raises(NoSolutionError, match="more than 20 cells are needed at inertia"):
        prove(_certificate(), LOOP)
    certificate, proved = certify(LOOP, BOX)
    assert not proved
    assert set(certificate.not_proved) == {"norm", "sensitivity"}
    assert certificate.bounds == ()
