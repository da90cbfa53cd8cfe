"""Check of a controller document: stability and margins of the loops at all vertices.

The loops are built from the stored coefficients.
"""

from __future__ import annotations

from collections.abc import Sequence

from frictool.documents.controller import Controller, DelayCheck, Limiter, Velocity
from frictool.documents.missing_effects import refuse_sensor_lag
from frictool.errors import NoSolutionError
from frictool.plant.linear_axis import AxisRates
from frictool.plant.polytope import PlantPoint
from frictool.presentation.tie_rule import TOLERANCE
from frictool.verify.feedback_loops import (
    ETA,
    FeedbackLoop,
    feedbacks_of,
    open_loop,
    virtual_friction,
)
from frictool.verify.hinf_norm import norm, spectral_radius
from frictool.verify.loop_wording import delay_words
from frictool.verify.margins import sensitivity
from frictool.verify.observer_loop import check_observer
from frictool.verify.resonant_loop import require_margin, resonant_check
from frictool.verify.speed_loop import LoopCheck, check_loop, is_required
from frictool.verify.spring_loop import require_spring_margin, spring_check
from frictool.verify.stored_forms import check_forms
from frictool.verify.vertices import vertex_points

NOT_EVALUABLE = (
    # errors of a loop whose coefficients are too large or too small for double precision
    ArithmeticError,
    ValueError,
)


def loop_checks(
    loops: Sequence[FeedbackLoop], point: PlantPoint, lag: float, delays: tuple[int, ...]
) -> tuple[DelayCheck, ...]:
    """Return the worst spectral radius and modulus margin of several loops, for each delay.

    - point: parameters of the plant
    - lag: time constant of the drive [s]
    - delays: computational delays [samples]
    """
    checks = []
    for delay_samples in delays:
        each = [check_feedback(loop, point.rates, lag, delay_samples) for loop in loops]
        radius, margin = (
            max(one.spectral_radius for one in each),
            min(one.modulus_margin for one in each),
        )
        checks.append(DelayCheck(delay_samples, radius, margin))
    return tuple(checks)


def check_feedback(
    loop: FeedbackLoop, rates: AxisRates, lag: float, delay_samples: int
) -> LoopCheck:
    """Return the spectral radius and the modulus margin of one loop with one plant.

    lag: time constant of the drive [s].
    """
    if loop.sees == (ETA,):
        return check_loop(loop.system, rates, lag, delay_samples)
    closed = sensitivity(open_loop(loop, rates, lag, delay_samples))
    return LoopCheck(delay_samples, spectral_radius(closed.a), 1.0 / norm(closed)[0])


def limiter_brake(
    limiter: Limiter | None, velocity: Velocity, constant: float, period: float
) -> tuple[FeedbackLoop, ...]:
    """Return the feedback of the speed that a limiter's virtual friction adds near standstill.

    The result is empty if there is no limiter or no virtual friction.

    - constant: effort per unit of drive
    - period: sample period [s]
    """
    if limiter is None or limiter.virtual_coulomb == 0.0:
        return ()
    return virtual_friction(
        limiter.virtual_coulomb / limiter.virtual_speed / constant, velocity, period
    )


def check_document(controller: Controller, *, margins: bool = False) -> None:
    """Check the loops of a document, rebuilt from its coefficients, at every vertex.

    Raises NoSolutionError in these cases:

    - The document contradicts its bench.
    - A loop is unstable or has less than the specified margin.
    - The stored forms of the linear controller differ, or the anti-windup is unstable.
    - `margins` is True, and a stored margin differs from the recomputed margin.
    """
    refuse_sensor_lag(controller.bench, "margins and certificates are valid")
    _of_its_bench(controller)
    if controller.velocity.observer is not None:
        check_observer(controller.velocity.observer)
    try:
        _vertices(controller, margins)
        _resonant(controller)
        _sprung(controller)
        check_forms(controller)
    except NOT_EVALUABLE as error:
        raise NoSolutionError(
            f"{controller.name}: not verified: the loop cannot be evaluated ({error}); run "
            "frictool synth again"
        ) from None


def _of_its_bench(controller: Controller) -> None:
    bench = controller.bench
    pairs = {
        "axis": (controller.axis, bench.axis),
        "drive": (controller.drive, bench.actuator.drive),
        "drive_limit": (controller.drive_limit, bench.actuator.limit.value),
        "sample_period_s": (controller.sample_period_s, bench.sample_period_s),
        "delay_samples": (controller.delay_samples, bench.delay_samples),
    }
    for key, (stated, has) in pairs.items():
        if stated != has:
            raise NoSolutionError(
                f"{controller.name}: not verified: {key}: found {stated}, but the document's "
                f"bench has {has}; run frictool synth again"
            )


def _vertices(controller: Controller, margins: bool) -> None:
    lag = controller.bench.actuator.loop_time_constant_s
    required = controller.verified.modulus_margin_specified
    loops = feedbacks_of(controller)
    constant = controller.bench.actuator.constant.value
    brake = limiter_brake(
        controller.limiter, controller.velocity, constant, controller.sample_period_s
    )
    for vertex, point in zip(controller.verified.vertices, vertex_points(controller), strict=True):
        where = f"{controller.name}: not verified: at vertex {vertex.name}"
        checks = loop_checks(
            loops, point, lag, tuple(check.delay_samples for check in vertex.checks)
        )
        for check in checks:
            if check.spectral_radius >= 1.0 and is_required(
                check.delay_samples, controller.delay_samples
            ):
                raise NoSolutionError(
                    f"{where} the loop with the stored coefficients is unstable with "
                    f"{delay_words(check.delay_samples)} "
                    f"(spectral radius {check.spectral_radius:.6g}); run frictool synth again"
                )
        margin = next(
            (
                check.modulus_margin
                for check in checks
                if check.delay_samples == controller.delay_samples
            ),
            None,
        )
        if margin is None:
            raise NoSolutionError(
                f"{controller.name}: not verified: vertex {vertex.name} has no check at the "
                "bench's delay; run frictool synth again"
            )
        if margins:
            _compare(where, vertex.modulus_margin, margin, controller.delay_samples)
            for stored, check in zip(vertex.checks, checks, strict=True):
                _compare(where, stored.modulus_margin, check.modulus_margin, check.delay_samples)
        if not all(
            check_feedback(one, point.rates, lag, check.delay_samples).stable
            for one in brake
            for check in checks
            if is_required(check.delay_samples, controller.delay_samples)
        ):
            raise NoSolutionError(
                f"{where} the limiter's virtual friction is unstable at rest; raise "
                "limiter.virtual_speed"
            )
        if margin < required * (1.0 - TOLERANCE):
            raise NoSolutionError(
                f"{where} the modulus margin is {margin:.6g}, below the specified {required:g}; "
                "run frictool synth again"
            )


def _compare(where: str, stated: float, recomputed: float, delay_samples: int) -> None:
    if abs(recomputed - stated) > TOLERANCE * stated:
        raise NoSolutionError(
            f"{where} the stored coefficients give a modulus margin of {recomputed:.6g} with "
            f"{delay_words(delay_samples)}, the document says "
            f"{stated:.6g}; run frictool synth again"
        )


def _resonant(controller: Controller) -> None:
    """Check the loops with the document's resonances at the bench's delay and at longer delays.

    The stored checks of the document list the delays. All loops must be stable; at the bench's
    delay, they must also have the specified margin.
    """
    resonances = controller.resonances
    if resonances is None:
        return
    lag = controller.bench.actuator.loop_time_constant_s
    loops = feedbacks_of(controller)
    points = vertex_points(controller)
    for samples, required in _requirements(controller):
        require_margin(
            resonant_check(loops, points, lag, samples, resonances),
            resonances,
            required,
            controller.name,
        )


def _sprung(controller: Controller) -> None:
    """Check the loops with the document's spring, with the delays and margins of `_resonant`."""
    stiffness = controller.stiffness
    if stiffness is None:
        return
    lag = controller.bench.actuator.loop_time_constant_s
    loops = feedbacks_of(controller)
    points = vertex_points(controller)
    for samples, required in _requirements(controller):
        check = spring_check(loops, points, (lag, samples), stiffness, controller.resonances)
        require_spring_margin(check, required * (1.0 - TOLERANCE), controller.name)


def _requirements(controller: Controller) -> tuple[tuple[int, float], ...]:
    """Return (delay [samples], required margin) for each delay at which loops must be stable."""
    delays = {
        check.delay_samples
        for vertex in controller.verified.vertices
        for check in vertex.checks
        if is_required(check.delay_samples, controller.delay_samples)
    }
    specified = controller.verified.modulus_margin_specified
    return tuple(
        (samples, specified if samples == controller.delay_samples else 0.0)
        for samples in sorted(delays)
    )
