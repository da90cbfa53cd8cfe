"""Proof that an axis inside the rest band of its controller comes to rest and stays there.

The rest band is the interval of position errors |e| <= band in which the controller releases the
drive. Then the forces on the axis are friction, the decaying drive i and a disturbance. The
certificate of the controller document stores an interval for each plant parameter (`Box`). F is the
smallest friction of all plants with parameters in these intervals. For |disturbance| <= d < F,

    J v' = K i(t) - friction + disturbance    =>    the axis moves by at most D = J w^2/(2 (F - d))

before it stops, with w = |v| + K |i| lag/J. J is the inertia, v the speed, K the actuator's
constant, and `lag` the time constant of the drive. The motion is longest if the whole impulse of
the decaying drive acts at the start of the motion. Let e be the position error. If the drive is
released and |e| + D <= band - (one encoder count), the axis therefore stops inside the band. After
the stop, the reading of the encoder is constant, the drive remains released, and only a disturbance
above the smallest breakaway moves the axis again. No limit cycle contains such a state.

The hypotheses of propositions 5.2.1 (limiter) and 5.2.2 (square-root law) of the thesis are checked
numerically. Each number is changed to the safe side by the fraction ROUNDED, which exceeds all
rounding errors.
"""

from __future__ import annotations

import math
from typing import Literal

from frictool.control.speed_filter import first_order
from frictool.documents.certificate import Box, Certificate, RestCheck, RestProof
from frictool.documents.controller import Controller, Limiter, PositionLaw

ROUNDED = 1e-12  # relative margin of each figure, which needs fewer than 50 roundings
OF_THE_APPROACH = ("arrival_speed", "stable_loop")  # checks of the motion towards the band
BRAKING_SHARE = 0.5  # disturbance while the axis stops, relative to the least friction


def prove_rest(controller: Controller, certificate: Certificate) -> RestProof | None:
    """Return the proof of rest for every plant of the certificate.

    The result is None if the controller has no rest band. The proof uses the document only, so that
    `verify` can repeat it.
    """
    law, limiter = controller.position_law, controller.limiter
    if law is not None and law.action != "none":
        return _summary(
            controller, certificate, law.band, _law_checks(controller, certificate, law)
        )
    if limiter is not None:
        checks = _limiter_checks(controller, certificate.box, limiter)
        return _summary(controller, certificate, limiter.band, checks)
    return None


def least_friction(controller: Controller, box: Box) -> float:
    """Return the smallest friction [N m | N] of all plants in `box`, also inside the backlash.

    The friction inside the backlash is proportional to the friction of the axis. A breakaway
    is never below the Coulomb friction.
    """
    mechanics = controller.bench.mechanics
    low = box.coulomb[0]
    if mechanics.backlash is not None and mechanics.backlash_coulomb is not None:
        nominal = mechanics.coulomb.value
        inside = mechanics.backlash_coulomb.interval[0]
        low = min(low, inside * low / nominal if nominal > low > 0.0 else inside)
    return max(0.0, low * (1.0 - ROUNDED))


def _summary(
    controller: Controller, certificate: Certificate, band: float, checks: tuple[RestCheck, ...]
) -> RestProof:
    box = certificate.box
    friction = least_friction(controller, box)
    step = controller.bench.encoder.resolution
    checks = (
        RestCheck("breakaway", "holds" if friction > 0.0 else "fails", friction, 0.0),
        RestCheck("band", "holds" if band >= step else "fails", band, step),
        *checks,
        _stable_loop(certificate),
    )
    states = {check.state for check in checks if check.name not in OF_THE_APPROACH}
    verdict: Literal["proved", "undecided"] = "proved" if states <= {"holds"} else "undecided"
    braking = (1.0 - BRAKING_SHARE) * friction
    stopping_distance = max(0.0, band - step) if verdict == "proved" else 0.0
    speed = math.sqrt(2.0 * braking * stopping_distance / box.inertia[1]) * (1.0 - ROUNDED)
    stop = box.inertia[1] * speed / braking * (1.0 + ROUNDED) if braking > 0.0 else 0.0
    coasts = controller.limiter is None or controller.limiter.condition == "error"
    return RestProof(
        verdict=verdict,
        disturbance=friction if verdict == "proved" else 0.0,
        stopping_disturbance=BRAKING_SHARE * friction if verdict == "proved" else 0.0,
        speed=speed if coasts else 0.0,
        stop_time_s=stop if coasts else 0.0,
        checks=checks,
    )


def _law_checks(
    controller: Controller, certificate: Certificate, law: PositionLaw
) -> tuple[RestCheck, ...]:
    """Check the speed with which the axis enters the rest band (thesis, proposition 5.2.2).

    With `action: cut`, this is the speed reference of the law at the end of the band; with
    `action: brake`, it is `rest_speed`. From this speed, every plant of the box must stop within
    the band.
    """
    box, step = certificate.box, controller.bench.encoder.resolution
    braking = (1.0 - BRAKING_SHARE) * least_friction(controller, box)
    stopping_distance = max(0.0, 2.0 * law.band - step)
    admissible = math.sqrt(2.0 * braking * stopping_distance / box.inertia[1]) * (1.0 - ROUNDED)
    if law.action == "brake":
        arrival = law.rest_speed
    else:
        arrival = law.gain * (math.sqrt(law.band) if law.kind == "square_root" else law.band)
    return (
        RestCheck(
            "arrival_speed",
            "holds" if arrival <= admissible else "undecided",
            arrival,
            admissible,
        ),
    )


def _limiter_checks(controller: Controller, box: Box, limiter: Limiter) -> tuple[RestCheck, ...]:
    """Check the hypotheses on the drive that a limiter releases (thesis, proposition 5.2.1).

    Virtual friction brakes against the measured speed even while the drive is released. A brake
    with less effort than the friction cannot move the axis. For a stronger brake, the effort after
    one encoder count must be below the friction, so that the axis cannot pass the next count.
    """
    friction = (1.0 - BRAKING_SHARE) * least_friction(controller, box)
    stretched = box.constant[1] / controller.bench.actuator.constant.value
    effort = limiter.virtual_coulomb * stretched * (1.0 + ROUNDED)
    frozen = controller.linear.form == "state_space"
    pulse = _count_pulse(controller, limiter, effort)
    return (
        RestCheck("frozen_integrator", "holds" if frozen else "fails", 0.0, 0.0),
        RestCheck(
            "released_effort", "holds" if effort < friction else "undecided", effort, friction
        ),
        RestCheck("count_pulse", "holds" if pulse < friction else "fails", pulse, friction),
    )


def _stable_loop(certificate: Certificate) -> RestCheck:
    bounds = [bound.below for bound in certificate.bounds if bound.of == "sensitivity"]
    value = min(bounds, default=0.0)
    return RestCheck("stable_loop", "holds" if certificate.bounds else "undecided", value, 0.0)


def _count_pulse(controller: Controller, limiter: Limiter, effort: float) -> float:
    if limiter.virtual_coulomb == 0.0 or controller.velocity.source == "measured":
        return 0.0
    period, velocity = controller.sample_period_s, controller.velocity
    if velocity.source == "observer":
        return effort
    speed = controller.bench.encoder.resolution / period
    if velocity.bandwidth_rad_s > 0.0:
        _, gain = first_order(velocity.bandwidth_rad_s, period)
        # the first stage multiplies a pulse by at most 2 gain, the second any signal by at most
        # max(1, 2 gain)
        speed *= 2.0 * gain * (max(1.0, 2.0 * gain) if velocity.order == 2 else 1.0)
    return effort * min(1.0, speed / limiter.virtual_speed) * (1.0 + ROUNDED)
