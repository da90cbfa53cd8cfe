"""Order reduction keeps its bound, its end of the frequency axis and its integrator."""

from __future__ import annotations

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.documents.design import Design
from frictool.documents.provenance import Provenance
from frictool.documents.registry import load
from frictool.documents.spec import Spec
from frictool.errors import NoSolutionError
from frictool.plant.lti import Lti, parallel_sum, tustin
from frictool.synth.balancing import balanced_form
from frictool.synth.design import design_controller
from frictool.synth.order_reduction import reduce_order, residualised, truncated
from frictool.synth.realisation import first_order
from frictool.verify.hinf_norm import norm
from studies.rigs.clutch_model import ROOT, clutch_model

PERIOD = 1e-3
seeds, periods = st.integers(0, 100_000), st.sampled_from([0.0, PERIOD])


def _stable(seed: int, n: int, period: float) -> Lti:
    random = np.random.default_rng(seed)
    a = random.normal(size=(n, n))
    a = 300.0 * (a - (np.max(np.linalg.eigvals(a).real) + random.uniform(0.2, 1.0)) * np.eye(n))
    system = Lti(
        a,
        10.0 * random.normal(size=(n, 1)),
        10.0 * random.normal(size=(1, n)),
        random.normal(size=(1, 1)),
        0.0,
    )
    return tustin(system, period) if period else system


def _difference(one: Lti, other: Lti) -> Lti:
    return parallel_sum(one, Lti(other.a, other.b, -other.c, -other.d, other.period))


def _accepted(_: Lti) -> None:
    """A check that everything passes."""


@given(seed=seeds, n=st.integers(2, 6), period=periods)
def test_the_balanced_form_is_the_system_with_equal_gramians(
    seed: int, n: int, period: float
) -> None:
    k = _stable(seed, n, period)
    balanced, hankel = balanced_form(k)
    assert norm(_difference(k, balanced))[0] < 1e-6 * norm(k)[0]
    assert np.all(np.diff(hankel) <= 0.0)
    sigma = np.diag(hankel)
    for a, b in ((balanced.a, balanced.b), (balanced.a.T, balanced.c.T)):
        left = a @ sigma @ a.T - sigma + b @ b.T if period else a @ sigma + sigma @ a.T + b @ b.T
        assert np.max(np.abs(left)) < 1e-6 * np.max(np.abs(b @ b.T)) + 1e-9


@given(seed=seeds, n=st.integers(2, 6), period=periods, kept=st.sampled_from(["high", "low"]))
def test_each_step_is_within_its_bound_and_exact_at_its_end(
    seed: int, n: int, period: float, kept: str
) -> None:
    k = _stable(seed, n, period)
    seen: list[int] = []
    steps = reduce_order(k, 1, lambda smaller: seen.append(smaller.order), kept)
    assert seen == [step.controller.order for step in steps] == list(range(n - 1, 0, -1))
    for step in steps:
        assert step.controller.stable
        assert norm(_difference(k, step.controller))[0] <= step.bound * (1.0 + 1e-6) + 1e-9
        if kept == "low":
            assert step.controller.response(0.0) == pytest.approx(k.response(0.0), rel=1e-6)
        else:
            assert step.controller.d == pytest.approx(k.d)


@given(seed=seeds, n=st.integers(2, 5), period=periods)
@settings(max_examples=30, deadline=None)
def test_an_integrator_is_kept(seed: int, n: int, period: float) -> None:
    exact = 1.0 if period else 0.0
    k = parallel_sum(first_order(exact, 0.3, period), _stable(seed, n, period))
    orthogonal, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(n + 1, n + 1)))
    for step in reduce_order(k.transformed(orthogonal), 1, _accepted):
        assert step.controller.a[0, 0] == exact
        assert step.controller.b[0, 0] * step.controller.c[0, 0] == pytest.approx(0.3, rel=1e-5)


def test_a_check_that_does_not_hold_ends_it_and_says_where() -> None:
    def refuses_below_three(k: Lti) -> None:
        if k.order < 3:
            raise NoSolutionError("the margin is 0.4")

    with pytest.raises(NoSolutionError, match=r"reduced to order 2: the margin is 0\.4"):
        reduce_order(_stable(1, 5, PERIOD), 1, refuses_below_three)


def test_an_unstable_controller_and_too_low_an_order_are_refused() -> None:
    with pytest.raises(NoSolutionError, match="unstable"):
        reduce_order(first_order(1.0, 1.0, 0.0), 0, _accepted)
    with pytest.raises(NoSolutionError, match="because the integrator is kept"):
        reduce_order(parallel_sum(first_order(0.0, 1.0, 0.0), _stable(0, 2, 0.0)), 0, _accepted)


def test_truncation_and_residualisation_of_a_system_known_by_hand() -> None:
    """1/(s + 1) + 1e-3/(s + 100): the second part goes; what is left is exact at rest only when it
    is residualised."""
    k = parallel_sum(first_order(-1.0, 1.0, 0.0), first_order(-100.0, 0.1, 0.0))
    balanced, _ = balanced_form(k)
    assert residualised(balanced, 1).response(0.0)[0, 0, 0] == pytest.approx(1.001, rel=1e-9)
    assert truncated(balanced, 1).response(0.0)[0, 0, 0] != pytest.approx(1.001, rel=1e-5)


def test_a_design_s_order_is_what_its_controller_is_reduced_to() -> None:
    """The LPV speed loop of the clutch has order 5; with 3 states it holds the margin, with 1 it is
    refused by name."""
    rig = ROOT / "configs/clutch"
    design, spec = load(rig / "designs/speed.yaml", Design), load(rig / "spec.yaml", Spec)
    small = design_controller(
        clutch_model(), spec, msgspec.structs.replace(design, order=3), Provenance("a test", "0")
    )
    assert len(small.linear.discrete.a) == 3
    assert all(vertex.modulus_margin >= 0.5 for vertex in small.verified.vertices)
    with pytest.raises(
        NoSolutionError,
        match=r"reduced to order 1: not verified: modulus margin 0\.\d+ at vertex v\d+",
    ):
        design_controller(
            clutch_model(),
            spec,
            msgspec.structs.replace(design, order=1),
            Provenance("a test", "0"),
        )
