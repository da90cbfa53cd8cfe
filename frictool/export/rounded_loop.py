"""Verification of a controller with coefficients rounded to a number format.

At every vertex, the sampled loop is computed with the rounded coefficients. The loop must be stable
at every delay of the document from `delay_samples` on, and have the specified modulus margin at
`delay_samples`. If the document contains the weights of the H-infinity norm, the norm must not
exceed the norm in the document. At every corner of a schedule, the controller of the corner is
checked with the plant of the corner. The rounding of signals is not verified; the golden vectors
show its effect (golden_vectors.py).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import msgspec
import numpy as np

from frictool.documents.controller import Controller, LinearController, Number
from frictool.errors import NoSolutionError
from frictool.plant.polytope import PlantPoint
from frictool.presentation.tie_rule import largest, smallest
from frictool.verify.coefficient_rounding import coefficient_rounder, rounded_linear
from frictool.verify.document_check import check_feedback, loop_checks
from frictool.verify.feedback_loops import feedbacks, running_form, virtual_friction
from frictool.verify.loop_values import CLAIM, loops_of
from frictool.verify.loop_wording import delay_words
from frictool.verify.observer_loop import check_observer
from frictool.verify.speed_loop import is_required, performance
from frictool.verify.stored_forms import limited_radius
from frictool.verify.vertices import vertex_points

FINER = {
    "q15": "--number q31 or float",
    "q31": "--number float or double",
    "float": "--number double",
    "double": "another design",
}


@dataclass(frozen=True)
class RoundedLoop:
    """Smallest modulus margin and largest norm with rounded coefficients.

    - `at`, `norm_at`: vertices of the smallest margin and of the largest norm
    - `norm`: largest norm; None if the document contains no weights
    """

    modulus_margin: float
    at: str
    norm: float | None
    norm_at: str


def rounded_loop(
    controller: Controller, number: Number, biquads: LinearController | None = None
) -> RoundedLoop:
    """Verify a controller with rounded coefficients.

    `biquads`: linear controller with the coefficients of the biquads and without anti-windup; it
        replaces the linear controller of `controller`.

    Raises NoSolutionError if the loop or the anti-windup is unstable, the modulus margin is too
    small, or the norm is above the stored norm. The message contains vertex and value.
    """
    if controller.velocity.observer is not None:
        check_observer(controller.velocity.observer, coefficient_rounder(number))
    linear = biquads or rounded_linear(controller.linear, number)
    radius = limited_radius(linear, controller.sample_period_s)
    if biquads is None and radius >= 1.0:
        raise _refused(
            controller,
            number,
            f"the anti-windup is unstable (spectral radius {radius:.6g} of a - l c)",
        )
    try:
        margins = [
            (_margin(controller, number, one, point, delays), point.name)
            for one, point, delays in _loops(controller, linear, number)
        ]
        _brake(controller, number)
        norms = _norms(controller, linear)
    # a rounded pole lies exactly on the unit circle
    except (ValueError, np.linalg.LinAlgError, FloatingPointError):
        raise _refused(controller, number, "a pole of the loop lies on the unit circle") from None
    margin, at = smallest(value for value, _ in margins)
    worst, norm_at = largest(value for value, _ in norms) if norms else (None, 0)
    claimed = controller.verified.gamma_verified
    if worst is not None and not worst <= CLAIM * claimed:
        raise _refused(
            controller,
            number,
            f"at vertex {norms[norm_at][1]} the norm is {worst:.4g}, above the stored norm "
            f"{claimed:.4g}",
        )
    return RoundedLoop(margin, margins[at][1], worst, norms[norm_at][1] if norms else "")


def _refused(controller: Controller, number: Number, why: str) -> NoSolutionError:
    return NoSolutionError(
        f"{controller.name}: not verified with coefficients rounded to {number}: {why}; "
        f"try {FINER[number]}"
    )


def _loops(
    controller: Controller, linear: LinearController, number: Number
) -> Iterator[tuple[LinearController, PlantPoint, tuple[int, ...]]]:
    """Yield (linear controller, plant, delays [samples]); the first delay is `delay_samples`."""
    for vertex in controller.verified.vertices:
        point = PlantPoint(
            vertex.name, vertex.inertia, vertex.viscous, vertex.coulomb, vertex.constant
        )
        yield (
            linear,
            point,
            tuple(
                dict.fromkeys(
                    (
                        controller.delay_samples,
                        *(
                            check.delay_samples
                            for check in vertex.checks
                            if is_required(check.delay_samples, controller.delay_samples)
                        ),
                    )
                )
            ),
        )
    for index, corner in enumerate(
        controller.schedule.corners if controller.schedule is not None else ()
    ):
        corner_controller = msgspec.structs.replace(
            controller.linear, discrete=corner.discrete, anti_windup=corner.anti_windup
        )
        there = rounded_linear(corner_controller, number)
        point = PlantPoint(
            f"corner {index} of the schedule",
            corner.inertia,
            corner.viscous,
            corner.coulomb,
            corner.constant,
        )
        radius = limited_radius(there, controller.sample_period_s)
        if radius >= 1.0:
            raise _refused(
                controller,
                number,
                f"the anti-windup is unstable at {point.name} (spectral radius "
                f"{radius:.6g} of a - l c)",
            )
        yield there, point, (controller.delay_samples,)


def _margin(
    controller: Controller,
    number: Number,
    linear: LinearController,
    point: PlantPoint,
    delays: tuple[int, ...],
) -> float:
    hold = coefficient_rounder(number)
    lag = controller.bench.actuator.loop_time_constant_s
    loops = feedbacks(
        controller.structure,
        linear,
        controller.position_law,
        controller.velocity,
        controller.sample_period_s,
        hold,
    )
    required = controller.verified.modulus_margin_specified
    checks = loop_checks(loops, point, lag, delays)
    for check in checks:
        if check.spectral_radius >= 1.0:
            why = (
                f"at vertex {point.name} the loop is unstable with "
                f"{delay_words(check.delay_samples)}"
            )
            raise _refused(
                controller, number, f"{why} (spectral radius {check.spectral_radius:.6g})"
            )
    if checks[0].modulus_margin < required:
        raise _refused(
            controller,
            number,
            f"at vertex {point.name} the modulus margin is "
            f"{checks[0].modulus_margin:.4g}, specified {required:g}",
        )
    return checks[0].modulus_margin


def _brake(controller: Controller, number: Number) -> None:
    limiter = controller.limiter
    if limiter is None or limiter.virtual_coulomb == 0.0:
        return
    hold = coefficient_rounder(number)
    bench = controller.bench.actuator
    slope = hold(limiter.virtual_coulomb / bench.constant.value) * hold(1.0 / limiter.virtual_speed)
    brake = virtual_friction(slope, controller.velocity, controller.sample_period_s)
    for _, point, delays in _loops(controller, controller.linear, number):
        lag = bench.loop_time_constant_s
        if not all(
            check_feedback(one, point.rates, lag, delay).stable for one in brake for delay in delays
        ):
            raise _refused(
                controller,
                number,
                f"at vertex {point.name} the loop with the limiter's virtual friction is unstable "
                "at rest",
            )


def _norms(controller: Controller, linear: LinearController) -> list[tuple[float, str]]:
    if controller.judged_by is None:
        return []
    loops = loops_of(controller, vertex_points(controller))
    runs = running_form(linear, controller.sample_period_s)
    return [(performance(runs, loops.plant(point.rates)), point.name) for point in loops.points]
