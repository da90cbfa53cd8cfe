"""The loop verified again with rounded coefficients: the figures of synthesis's own check, refusals
that name vertex and figure."""

from __future__ import annotations

import msgspec
import pytest

from frictool.documents.certificate import CertifiedWeights, Filter
from frictool.documents.controller import Controller, Limiter, Number, Velocity
from frictool.errors import NoSolutionError
from frictool.export.rounded_loop import rounded_loop
from frictool.plant.polytope import PlantPoint
from frictool.verify.coefficient_rounding import coefficient_rounder, rounded_linear
from frictool.verify.document_check import loop_checks
from frictool.verify.feedback_loops import feedbacks
from studies.rigs.example_controllers import BRAKE_LAW, clutch_controller
from studies.rigs.verified_controller import truthful
from tests.support.compiled_c import NUMBERS
from tests.support.export_controllers import scheduled

replace = msgspec.structs.replace


@pytest.fixture(scope="module")
def controller() -> Controller:
    return truthful(clutch_controller(BRAKE_LAW))


@pytest.mark.parametrize("number", NUMBERS)
def test_is_the_margin_of_the_loop_with_rounded_coefficients(
    controller: Controller, number: Number
) -> None:
    found, vertex = rounded_loop(controller, number), controller.verified.vertices[0]
    linear = rounded_linear(controller.linear, number)
    loops = feedbacks(
        "speed_cascade",
        linear,
        controller.position_law,
        controller.velocity,
        1e-3,
        coefficient_rounder(number),
    )
    point = PlantPoint(vertex.name, vertex.inertia, vertex.viscous, vertex.coulomb, vertex.constant)
    lag = controller.bench.actuator.loop_time_constant_s
    assert (
        found.modulus_margin
        == loop_checks(loops, point, lag, (controller.delay_samples,))[0].modulus_margin
    )
    assert found.at == "nominal"
    assert (number == "double") == (found.modulus_margin == vertex.modulus_margin)
    assert found.modulus_margin == pytest.approx(vertex.modulus_margin, rel=0.01)


def test_a_margin_that_rounding_takes_is_refused_with_vertex_and_figure(
    controller: Controller,
) -> None:
    """The specified margin lies between the margin in double and the one in q15."""
    double, q15 = (rounded_loop(controller, number).modulus_margin for number in ("double", "q15"))
    specified = 0.5 * (double + q15)
    asked = replace(
        controller, verified=replace(controller.verified, modulus_margin_specified=specified)
    )
    refused, kept = ("q15", "double") if q15 < double else ("double", "q15")
    assert rounded_loop(asked, kept).modulus_margin > specified
    with pytest.raises(
        NoSolutionError,
        match=rf"rounded to {refused}: at vertex nominal the modulus margin is 0\.\d+, specified",
    ):
        rounded_loop(asked, refused)


def test_an_unstable_loop_is_refused_with_vertex_and_radius(controller: Controller) -> None:
    vertex = replace(controller.verified.vertices[0], name="light", inertia=1e-8)
    unstable = replace(controller, verified=replace(controller.verified, vertices=(vertex,)))
    with pytest.raises(
        NoSolutionError,
        match=r"at vertex light the loop is unstable with (1 sample|[02] samples) of delay "
        r"\(spectral radius \d",
    ):
        rounded_loop(unstable, "float")


def test_an_unstable_anti_windup_is_refused(controller: Controller) -> None:
    linear = replace(controller.linear, anti_windup=(50.0, 0.0))
    with pytest.raises(
        NoSolutionError,
        match=r"rounded to q31: the anti-windup is unstable .* try --number float or double",
    ):
        rounded_loop(replace(controller, linear=linear), "q31")


def test_a_virtual_friction_that_does_not_come_to_rest_is_refused(controller: Controller) -> None:
    limiter = Limiter("error", 0.5, virtual_coulomb=0.09, virtual_speed=0.05)
    hunting = replace(
        controller, structure="position", position_law=None, limiter=limiter, velocity=Velocity()
    )
    easy = replace(controller.verified, modulus_margin_specified=0.0)
    with pytest.raises(
        NoSolutionError,
        match=r"at vertex nominal the loop with the limiter's virtual friction is unstable at rest",
    ):
        rounded_loop(replace(hunting, verified=easy), "float")


def test_every_corner_of_a_schedule_is_looked_at(controller: Controller) -> None:
    base = scheduled(controller)
    assert base.schedule is not None
    corners = [
        replace(corner, discrete=controller.linear.discrete, constant=0.0134)
        for corner in base.schedule.corners
    ]
    sound = replace(base, schedule=replace(base.schedule, corners=tuple(corners)))
    assert rounded_loop(sound, "float").modulus_margin > 0.5
    corners[2] = replace(corners[2], inertia=1e-8)
    with pytest.raises(NoSolutionError, match=r"at vertex corner 2 of the schedule"):
        rounded_loop(
            replace(base, schedule=replace(base.schedule, corners=tuple(corners))), "float"
        )


def test_a_norm_beyond_what_is_claimed_is_refused_with_its_vertex(controller: Controller) -> None:
    """The weights beside `verified` say what the norm is of; 1 % more than is claimed is let pass,
    as in synthesis."""
    assert rounded_loop(controller, "float").norm is None
    weighed = replace(
        controller,
        weights=CertifiedWeights(
            error=Filter(40.0, zero=40.0, pole=0.5), disturbance=0.03, drive=0.01
        ),
    )

    def claiming(gamma: float) -> Controller:
        return replace(weighed, verified=replace(weighed.verified, gamma_verified=gamma))

    norm = rounded_loop(claiming(1e9), "float").norm
    assert norm is not None
    assert rounded_loop(claiming(norm / 1.009), "float").norm == norm
    with pytest.raises(
        NoSolutionError,
        match=r"rounded to float: at vertex nominal the norm is \d\S*, above the stored norm \d\S*"
        r"; try --number double",
    ):
        rounded_loop(claiming(norm / 1.011), "float")
