"""The synthesised controller of the clutch: verified at every vertex, equal in all its stored
forms, refused when it must be."""

from __future__ import annotations

from functools import cache

import msgspec
import numpy as np
import pytest
from scipy import signal

from frictool.adapters.state_space import read_state_space
from frictool.documents.controller import Controller, DelayCheck, Vertex
from frictool.documents.design_blocks import PositionLawDesign
from frictool.documents.model import Model
from frictool.errors import FrictoolError, NoSolutionError
from frictool.plant.polytope import PlantPoint
from frictool.synth.acceptance import unstable_earlier
from frictool.synth.design import ProofScope, design_controller, synthesise_verified
from frictool.synth.surrounding_blocks import blocks
from frictool.verify.speed_loop import check_loop, is_required
from studies.rigs.clutch_model import clutch_model
from tests.support.clutch_speed_controller import (
    HERE,
    clutch_speed_controller,
    speed_design,
    speed_spec,
)


def test_margin_and_stability_at_all_sixteen_vertices_with_either_delay() -> None:
    controller = clutch_speed_controller()
    assert len(controller.verified.vertices) == 16
    for vertex in controller.verified.vertices:
        point = PlantPoint(
            vertex.name, vertex.inertia, vertex.viscous, vertex.coulomb, vertex.constant
        )
        for stored in vertex.checks:
            check = check_loop(
                read_state_space(controller.linear.discrete, 1e-3),
                point.rates,
                0.003,
                stored.delay_samples,
            )
            assert check.stable
            assert check.modulus_margin == stored.modulus_margin
        assert {check.delay_samples for check in vertex.checks} >= {0, 1}
        assert vertex.modulus_margin >= 0.5


@cache
def _recipe(ease: float) -> Controller:
    weights = msgspec.structs.replace(
        speed_design().weights,
        bandwidth_rad_s=40.0,
        modulus_margin=0.5,
        disturbance=0.03,
        command=0.5,
    )
    design = msgspec.structs.replace(speed_design(), weights=weights, recentring=1.1, ease=ease)
    return design_controller(clutch_model(), speed_spec(), design, HERE)


def test_gamma_is_near_the_optimum_of_the_recipe() -> None:
    # the trial of this recipe: optimum 2.27, recentred at 1.1 times it
    assert _recipe(1.0).verified.gamma_asked == pytest.approx(1.1 * 2.27, rel=0.01)


def test_a_controller_at_ease_has_more_margin_and_claims_less() -> None:
    tight, easy = _recipe(1.0), _recipe(2.0)
    margins = [
        min(vertex.modulus_margin for vertex in found.verified.vertices) for found in (tight, easy)
    ]
    assert margins[1] > 0.6 > margins[0]
    assert easy.verified.gamma_asked == pytest.approx(2.0 * tight.verified.gamma_asked)


def test_every_stored_form_is_the_same_controller() -> None:
    stored = clutch_speed_controller().linear
    angles = np.geomspace(1e-3, 3.1, 50)
    direct = read_state_space(stored.discrete, 1e-3).response(angles / 1e-3)[:, 0, 0]
    _, sections = signal.sosfreqz(np.array(stored.sos), worN=angles)
    assert sections == pytest.approx(direct, rel=1e-6)
    warped = (
        2.0 / 1e-3 * np.tan(0.5 * angles)
    )  # Tustin maps the unit circle to this part of the imaginary axis
    assert read_state_space(stored.continuous, 0.0).response(warped)[:, 0, 0] == pytest.approx(
        direct, rel=1e-6
    )


def test_the_anti_windup_observer_is_stable() -> None:
    stored = clutch_speed_controller().linear
    k = read_state_space(stored.discrete, 1e-3)
    assert np.max(np.abs(np.linalg.eigvals(k.a - np.outer(stored.anti_windup, k.c[0])))) < 1.0


def test_a_proportional_law_is_verified_with_the_loop_inside_it() -> None:
    """Slow it costs little margin; as fast as the speed loop it is refused, and the vertex
    named."""
    law = PositionLawDesign("none", kind="proportional", gain_per_s=5.0)
    design = msgspec.structs.replace(speed_design(), position_law=law)
    slow = design_controller(clutch_model(), speed_spec(), design, HERE)
    assert (
        slow.verified.vertices[0].modulus_margin
        < clutch_speed_controller().verified.vertices[0].modulus_margin
    )
    certain = synthesise_verified(
        pinned(clutch_model(constant=(13.4e-3,) * 3)), speed_spec(), design, HERE
    )
    assert any("proportional law around it" in note for note in certain.notes)
    fast = msgspec.structs.replace(law, gain_per_s=60.0)
    with pytest.raises(
        NoSolutionError, match=r"(modulus margin 0\.\d+ < 0.5|unstable) at vertex v\d+"
    ):
        design_controller(
            clutch_model(),
            speed_spec(),
            msgspec.structs.replace(speed_design(), position_law=fast),
            HERE,
        )


@pytest.mark.parametrize(("formula", "factor"), [("sqrt(F/J)", 1.0), ("sqrt(2F/J)", np.sqrt(2.0))])
def test_the_gain_is_that_of_the_named_formula(formula: str, factor: float) -> None:
    law = msgspec.structs.replace(speed_design().position_law, formula=formula)
    design = msgspec.structs.replace(speed_design(), position_law=law)
    found = blocks(clutch_model(), design).position_law
    assert found is not None
    assert found.gain == pytest.approx(factor * np.sqrt(0.099 / 1.32e-5))
    assert found.formula == formula


def test_a_margin_that_is_not_reached_is_refused_and_the_vertex_named() -> None:
    spec = msgspec.structs.replace(speed_spec(), modulus_margin=0.9)
    weights = msgspec.structs.replace(speed_design().weights, modulus_margin=0.5)
    with pytest.raises(
        NoSolutionError, match=r"modulus margin 0\.\d+ < 0.9 at vertex v\d+ .*inertia"
    ) as caught:
        design_controller(
            clutch_model(), spec, msgspec.structs.replace(speed_design(), weights=weights), HERE
        )
    assert caught.value.exit_code == 4


@pytest.mark.accept  # tests/cli/test_synth.py writes the same bytes twice
def test_the_same_inputs_give_the_same_controller() -> None:
    assert (
        design_controller(clutch_model(), speed_spec(), speed_design(), HERE)
        == clutch_speed_controller()
    )


def test_a_wide_polytope_has_no_controller() -> None:
    model = clutch_model(constant=(1e-4, 13.4e-3, 1.0))
    with pytest.raises(NoSolutionError):
        design_controller(model, speed_spec(), speed_design(), HERE)


def test_a_bench_without_delay_gets_a_controller_too() -> None:
    model = clutch_model()
    without = msgspec.structs.replace(
        model, bench=msgspec.structs.replace(model.bench, delay_samples=0)
    )
    controller = design_controller(without, speed_spec(), speed_design(), HERE)
    assert controller.delay_samples == 0
    assert controller.linear.discrete.d == ((0.0,),)  # the register is the controller's own
    assert all(
        vertex.stable and vertex.modulus_margin >= 0.5 for vertex in controller.verified.vertices
    )
    # with the register outside, it is the loop of the bench with one sample of delay
    pairs = zip(
        controller.verified.vertices, clutch_speed_controller().verified.vertices, strict=True
    )
    assert all(a.modulus_margin == pytest.approx(b.modulus_margin, rel=1e-6) for a, b in pairs)


def test_weights_at_the_edge_of_the_numbers_give_nothing_that_is_not_verified() -> None:
    """The processor's rounding decides whether the solver comes to an end."""
    weights = msgspec.structs.replace(speed_design().weights, drive=0.5e6)
    design = msgspec.structs.replace(speed_design(), weights=weights)
    try:
        found = design_controller(clutch_model(), speed_spec(), design, HERE).verified
    except NoSolutionError:
        return
    assert all(vertex.stable and vertex.modulus_margin >= 0.5 for vertex in found.vertices)
    # a frozen controller is not promised gamma at every vertex, but with this weight only the
    # plant's own answer counts
    assert all(vertex.norm <= found.gamma_asked for vertex in found.vertices)


@pytest.mark.parametrize("factor", [1e9, 1e12])
def test_absurd_weights_are_refused_and_not_a_traceback(factor: float) -> None:
    weights = msgspec.structs.replace(speed_design().weights, drive=0.5 * factor)
    with pytest.raises(NoSolutionError):
        design_controller(
            clutch_model(),
            speed_spec(),
            msgspec.structs.replace(speed_design(), weights=weights),
            HERE,
        )


def test_a_specification_without_margin_is_a_fault_of_the_documents() -> None:
    spec = msgspec.structs.replace(speed_spec(), modulus_margin=None)
    weights = msgspec.structs.replace(speed_design().weights, modulus_margin=None)
    with pytest.raises(FrictoolError, match="modulus_margin: missing") as caught:
        design_controller(
            clutch_model(), spec, msgspec.structs.replace(speed_design(), weights=weights), HERE
        )
    assert caught.value.exit_code == 3


@pytest.mark.parametrize("frequency", [3141.6, 1e5])
def test_a_prewarping_frequency_that_sampling_does_not_reach_is_refused(frequency: float) -> None:
    design = msgspec.structs.replace(speed_design(), domain="continuous", prewarp_rad_s=frequency)
    with pytest.raises(
        FrictoolError,
        match=r"prewarp_rad_s: found .* allowed: below 3141.59 rad/s, half the sampling "
        r"frequency",
    ):
        design_controller(clutch_model(), speed_spec(), design, HERE)


def test_a_plant_known_exactly_is_bounded_and_proved_as_any_other() -> None:
    certain = pinned(clutch_model(constant=(13.4e-3,) * 3))
    found = synthesise_verified(certain, speed_spec(), speed_design(), HERE).controller
    assert len(found.verified.vertices) == 1
    assert found.verified.robustness is None
    assert found.certificate is not None
    below = {bound.of: bound.below for bound in found.certificate.bounds}
    margin = found.verified.vertices[0].modulus_margin
    assert found.verified.gamma_verified < below["norm"] < 1.002 * found.verified.gamma_verified
    assert 1.0 / margin < below["sensitivity"] < 1.002 / margin
    scope = ProofScope(varying=True)
    varying = synthesise_verified(certain, speed_spec(), speed_design(), HERE, scope=scope)
    robustness = varying.controller.verified.robustness
    assert robustness is not None
    assert robustness.common == pytest.approx(found.verified.gamma_verified, rel=5e-3)
    assert (robustness.structured, robustness.parameter_dependent) == (None, None)


def pinned(model: Model) -> Model:
    """With the intervals of inertia and friction at their values, in the log's result and in the
    bench."""
    replace, mechanics = msgspec.structs.replace, model.bench.mechanics
    at = {name: getattr(model.parameters, name) for name in ("inertia", "viscous", "coulomb")}
    today = replace(
        model.parameters,
        **{name: replace(found, low=found.value, high=found.value) for name, found in at.items()},
    )
    beside = {name: getattr(mechanics, name) for name in at}
    exact = replace(
        mechanics,
        **{
            name: replace(found, low=found.value, high=found.value)
            for name, found in beside.items()
        },
    )
    return replace(model, parameters=today, bench=replace(model.bench, mechanics=exact))


def test_instability_with_less_than_the_benchs_delay_is_a_note() -> None:
    def vertex(*radii: float) -> Vertex:
        checks = tuple(DelayCheck(index, radius, 0.5) for index, radius in enumerate(radii))
        return Vertex("v3", 1.0, 0.0, 0.0, 1.0, 1.0, 1.0, 0.5, True, checks)

    words = unstable_earlier((vertex(1.2, 0.99, 0.9), vertex(0.9, 1.05, 0.9)), 2)
    assert "unstable with 0 samples of delay at vertex v3 (spectral radius 1.2000)" in words
    assert "must wait until the bench's delay (2 samples of delay) has passed" in words
    assert unstable_earlier((vertex(0.9, 1.1),), 0) == ""  # refused, and no note
    assert unstable_earlier((vertex(0.9, 0.9),), 1) == ""
    assert [is_required(checked, 0) for checked in (0, 1)] == [True, True]
    assert [is_required(checked, 2) for checked in (0, 1, 2)] == [False, False, True]
