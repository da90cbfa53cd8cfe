"""A certificate proves what is true, of the loop that is given to it, and nothing else."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from functools import cache

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.adapters.state_space import stored_state_space
from frictool.documents.certificate import Bound, Box, Cell, Certificate, CertifiedWeights, Filter
from frictool.documents.controller import StateSpace
from frictool.errors import NoSolutionError
from frictool.plant.generalised_plant import FirstOrderWeight, PlantWeights, generalised_plant
from frictool.plant.linear_axis import AxisRates
from frictool.plant.lti import Lti
from frictool.synth.certificate_construction import certify
from frictool.verify.certificate_loop import CertificateLoop, closed_loop
from frictool.verify.certificate_proof import prove, unpacked
from frictool.verify.enclosed_axis import corners
from frictool.verify.interval_arithmetic import ONE
from frictool.verify.speed_loop import check_loop, performance
from tests.verify.gentle_loop import BOX, GENTLE, LAG, LOOP, PERIOD, WEIGHTS


@cache
def _certificate() -> Certificate:
    return certify(LOOP, BOX)


def _first_order(stored: Filter) -> FirstOrderWeight:
    return FirstOrderWeight(stored.gain, stored.zero or np.inf, stored.pole or np.inf)


def _float_weights(stored: CertifiedWeights) -> PlantWeights:
    noise = _first_order(stored.noise)
    return PlantWeights(
        _first_order(stored.error),
        stored.disturbance,
        stored.drive,
        stored.command,
        noise,
        stored.eta,
    )


def _changed(loop: CertificateLoop, change: object) -> CertificateLoop:
    """The loop with every coefficient c changed to change(c)."""
    k = loop.controller
    parts = (
        tuple(tuple(change(value) for value in row) for row in matrix)
        for matrix in (k.a, k.b, k.c, k.d)
    )
    return replace(loop, controller=StateSpace(*parts))


def _with_first(bound: Bound, **changes: object) -> Certificate:
    cells = (msgspec.structs.replace(bound.cells[0], **changes), *bound.cells[1:])
    return msgspec.structs.replace(
        _certificate(), bounds=(msgspec.structs.replace(bound, cells=cells),)
    )


@pytest.mark.parametrize("controlled", ["speed", "position"])
@pytest.mark.parametrize("lag", [0.0, LAG])
@pytest.mark.parametrize("delay", [0, 1, 2])
@pytest.mark.parametrize(
    "noise", [Filter(0.0), Filter(0.01), Filter(0.01, 40.0, 400.0), Filter(0.01, None, 400.0)]
)
def test_the_enclosed_loop_is_the_generalised_plant_closed(
    controlled: str, lag: float, delay: int, noise: Filter
) -> None:
    weights = CertifiedWeights(Filter(31.5, 40.0, 0.635), 0.03, 0.5, 0.2, noise, 0.1)
    loop = CertificateLoop(stored_state_space(GENTLE), controlled, delay, lag, PERIOD, weights)
    narrow = Fraction(10), Fraction(10) + Fraction(1, 10**6)
    enclosed, n = closed_loop(
        loop,
        corners(
            (Fraction(900), Fraction(1000)), narrow, (Fraction(300), Fraction(400)), lag, PERIOD
        )[0],
    )
    whole = (enclosed.centre / ONE).astype(float)
    found = Lti(whole[:n, :n], whole[:n, n:], whole[n:, :n], whole[n:, n:], PERIOD)
    plant = generalised_plant(
        controlled, AxisRates(900, 10, 300), lag, _float_weights(weights), PERIOD, delay
    )
    looks = np.array([1.0, 30.0, 300.0, 2500.0])
    assert found.response(looks) == pytest.approx(
        plant.closed(GENTLE).response(looks), rel=1e-7, abs=1e-9
    )


def test_what_is_proved_is_close_to_what_is_seen() -> None:
    proved = {one.of: one.below for one in prove(_certificate(), LOOP)}
    worst = {"norm": 0.0, "sensitivity": 0.0}
    random = np.random.default_rng(20)
    ends = [BOX.inertia, BOX.viscous, BOX.coulomb, BOX.constant]
    inside = np.array([random.uniform(*interval, 30) for interval in ends]).T
    for j, sigma, coulomb, k in np.vstack([np.array(np.meshgrid(*ends)).reshape(4, -1).T, inside]):
        rates = AxisRates(k / j, sigma / j, coulomb / j)
        norm = performance(
            GENTLE, generalised_plant("speed", rates, LAG, _float_weights(WEIGHTS), PERIOD, 1)
        )
        peak = 1.0 / check_loop(GENTLE, rates, LAG, 1).modulus_margin
        assert norm < proved["norm"]
        assert peak < proved["sensitivity"]
        worst = {"norm": max(worst["norm"], norm), "sensitivity": max(worst["sensitivity"], peak)}
    for of, below in proved.items():
        assert below <= 1.05 * worst[of]


@given(seed=st.integers(0, 10**6))
@settings(max_examples=2, deadline=None)
def test_coefficients_changed_in_the_twelfth_digit_are_proved_as_well(seed: int) -> None:
    random = np.random.default_rng(seed)
    changed = _changed(LOOP, lambda value: value * (1.0 + 1e-12 * random.uniform(-1.0, 1.0)))
    assert changed != LOOP
    assert [one.of for one in prove(_certificate(), changed)] == ["norm", "sensitivity"]


@pytest.mark.parametrize("matrix", ["b", "c", "d"])
def test_a_coefficient_changed_by_a_fifth_fails_and_names_the_inequality(matrix: str) -> None:
    k = LOOP.controller
    larger = tuple(tuple(1.2 * value for value in row) for row in getattr(k, matrix))
    changed = replace(LOOP, controller=msgspec.structs.replace(k, **{matrix: larger}))
    with pytest.raises(
        NoSolutionError,
        match=r"not proved: \w+ < .*minor \d+ of the bounded-real inequality .* is not positive "
        r"for K/J",
    ):
        prove(_certificate(), changed)


@pytest.mark.parametrize("change", [{"delay": 2}, {"lag": 1.3 * LAG}, {"period": 1.3 * PERIOD}])
def test_another_loop_is_not_proved(change: dict[str, float]) -> None:
    with pytest.raises(NoSolutionError, match="not proved"):
        prove(_certificate(), replace(LOOP, **change))


@pytest.mark.parametrize("index", [0, 1])
def test_a_bound_below_the_truth_is_never_proved(index: int) -> None:
    bound = _certificate().bounds[index]
    lower = msgspec.structs.replace(bound, below=0.9 * bound.below)
    with pytest.raises(NoSolutionError, match="bounded-real inequality"):
        prove(msgspec.structs.replace(_certificate(), bounds=(lower,)), LOOP)


def test_a_cell_less_does_not_cover() -> None:
    bound = _certificate().bounds[0]
    assert len(bound.cells) > 1
    for index in range(len(bound.cells)):
        fewer = msgspec.structs.replace(bound, cells=bound.cells[:index] + bound.cells[index + 1 :])
        with pytest.raises(NoSolutionError, match="the cells do not cover K/J"):
            prove(msgspec.structs.replace(_certificate(), bounds=(fewer,)), LOOP)


def test_a_box_that_is_wider_than_the_cells_is_not_covered() -> None:
    wider = msgspec.structs.replace(BOX, inertia=(1.2e-5, 1.4e-5))
    with pytest.raises(NoSolutionError, match="the cells do not cover"):
        prove(msgspec.structs.replace(_certificate(), box=wider), LOOP)


def test_more_friction_than_was_proved_for_fails() -> None:
    more = msgspec.structs.replace(BOX, coulomb=(0.0, 0.8))
    with pytest.raises(NoSolutionError, match="not proved: norm"):
        prove(msgspec.structs.replace(_certificate(), box=more), LOOP)


def test_matrices_that_were_tampered_with_fail() -> None:
    bound, n = _certificate().bounds[0], len(LOOP.states)
    first = bound.cells[0]
    words = first.at_low.split()
    whole = unpacked(first.at_low, n)
    assert whole is not None
    assert np.all(whole == whole.T)
    with pytest.raises(NoSolutionError, match="minor 1 of the Lyapunov matrix at the low K/J"):
        prove(_with_first(bound, at_low=" ".join(["-" + words[0], *words[1:]])), LOOP)
    with pytest.raises(NoSolutionError, match="minor 2 of the Lyapunov matrix at the high K/J"):
        prove(_with_first(bound, at_high=" ".join([words[0], "9" * 12, *words[2:]])), LOOP)
    with pytest.raises(NoSolutionError, match="minor"):
        prove(_with_first(bound, at_low=" ".join(str(3 * int(word)) for word in words)), LOOP)
    for text in (
        "",
        "1 2",
        first.at_low + " 1",
        first.at_low.replace(words[0], "x", 1),
        first.at_low.replace(words[0], "1" * 50, 1),
    ):
        with pytest.raises(NoSolutionError, match=f"is not {n * (n + 1) // 2} whole numbers"):
            prove(_with_first(bound, at_low=text), LOOP)
    singular = ((0.0, *bound.factor[0][1:]), *bound.factor[1:])
    with pytest.raises(NoSolutionError, match="its diagonal has a zero"):
        prove(
            msgspec.structs.replace(
                _certificate(), bounds=(msgspec.structs.replace(bound, factor=singular),)
            ),
            LOOP,
        )


def test_another_number_of_states_is_told() -> None:
    with pytest.raises(
        NoSolutionError,
        match=r"the certificate's matrices are of size \d+, the loop has \d+ states",
    ):
        prove(_certificate(), replace(LOOP, lag=0.0))


@pytest.mark.parametrize("lag", [0.0, LAG])
@pytest.mark.parametrize("delay", [0, 2])
def test_benches_without_lag_or_delay_and_parameters_known_exactly(lag: float, delay: int) -> None:
    loop = replace(LOOP, lag=lag, delay=delay)
    point = Box((1.32e-5, 1.32e-5), (0.0, 0.0), (0.099, 0.099), (0.0134, 0.0134))
    certificate = certify(loop, point)
    assert not certificate.not_proved
    rates = AxisRates(0.0134 / 1.32e-5, 0.0, 0.099 / 1.32e-5)
    norm = performance(
        GENTLE, generalised_plant("speed", rates, lag, _float_weights(WEIGHTS), PERIOD, delay)
    )
    proved = prove(certificate, loop)
    assert len(proved[0].cells) == 1
    assert norm < proved[0].below <= 1.02 * norm


def test_an_unstable_loop_gets_no_certificate() -> None:
    with pytest.raises(NoSolutionError, match="unstable at inertia"):
        certify(_changed(LOOP, lambda value: 20.0 * value if abs(value) > 1.0 else value), BOX)


def test_the_same_loop_gives_the_same_certificate() -> None:
    point = Box((1.32e-5, 1.32e-5), (0.0, 1e-5), (0.099, 0.099), (0.0134, 0.0134))
    assert certify(LOOP, point) == certify(LOOP, point)


def test_cells_of_no_width_are_refused() -> None:
    with pytest.raises(ValueError, match="drive_rate"):
        Cell((1.0, 1.0), (0.0, 1.0), "1", "1")
