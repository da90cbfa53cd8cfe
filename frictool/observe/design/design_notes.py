"""Notes on the limits of a designed observer, with numbers for its bench."""

from __future__ import annotations

import math

from frictool.documents.model import Model
from frictool.documents.observer import Observer, Switched
from frictool.documents.quantity import si_unit
from frictool.observe.design.friction_map import KNEES, left_out

DEAR = 1.5  # ratio of gamma to gamma without a decay, above which a note is given
SLOW_S = 10.0  # s, time constant of alpha above which a note is given
# assumed relative deviation of a friction that is constant over position; it scales only gamma
UNIT_DEVIATION = 0.01
KNOWN_BY_TRACKING = (KNEES,)
# speed of one count per sample, relative to the switch speed, above which the encoder is coarse
COARSE = 0.1


def notes(observer: Observer, model: Model) -> list[str]:
    """Return the notes on a designed observer, one line each."""
    switched = observer.switched
    if switched is None:
        return [line for line in [_left_out(model, KNOWN_BY_TRACKING)] if line]
    remarks = [
        _encoder(observer, switched),
        _constant(switched),
        _intervals(observer, switched),
        _turning(observer, switched),
        *_rest(switched),
        _slow(observer, switched),
        _dear(switched),
        _left_out(model, ()),
    ]
    return [line for line in remarks if line]


def count_speed(observer: Observer) -> float:
    """Return the speed of one encoder count per sample [rad/s | m/s]."""
    return observer.bench.encoder.resolution / observer.sample_period_s


def _encoder(observer: Observer, switched: Switched) -> str:
    seen = count_speed(observer)
    sigma = switched.switch_speed.value
    if seen <= COARSE * sigma:
        return ""
    position, velocity = si_unit("position", observer.axis), si_unit("velocity", observer.axis)
    effort = f" {si_unit('effort', observer.axis)}" if switched.wear == "additive" else ""
    step = observer.bench.encoder.resolution
    speed, wear = (max(abs(mode.gains[row][0]) for mode in switched.modes) * step for row in (1, 2))
    return (
        f"the encoder is coarse: one count of {step:.4g} {position} changes the estimated speed by "
        f"up to {speed:.3g} {velocity} and the wear by up to {wear:.3g}{effort}; use an encoder "
        f"with counts below {COARSE * sigma * observer.sample_period_s:.2g} {position}, or "
        "estimate the speed with --kind tracking and the wear with `observe run`"
    )


def _constant(switched: Switched) -> str:
    chosen = [
        mode
        for mode in switched.modes
        if mode.friction and mode.deviation == UNIT_DEVIATION * mode.friction
    ]
    return (
        "the friction does not depend on position: gamma is computed for an assumed error of "
        f"{UNIT_DEVIATION:.0%} of the friction"
        if chosen
        else ""
    )


def _intervals(observer: Observer, switched: Switched) -> str:
    """Return a note if the axis can pass a whole position interval within one sample."""
    widths = [mode.over[1] - mode.over[0] for mode in switched.modes if mode.over is not None]
    top = observer.bench.mechanics.top_speed
    if (
        not widths
        or top is None
        or top.value * observer.sample_period_s <= min(widths)
        or _any_interval(switched)
    ):
        return ""
    return (
        f"at top speed the axis passes an interval of {min(widths):.3g} "
        f"{si_unit('position', observer.axis)} within one sample; use fewer --intervals, or "
        f"--transitions direction{_made_up(switched)}"
    )


def _any_interval(switched: Switched) -> bool:
    moving = [mode.index for mode in switched.modes if mode.direction]
    return all((i, j) in switched.transitions for i in moving for j in moving if i * j > 0)


def _turning(observer: Observer, switched: Switched) -> str:
    """Return a note if a motion can reverse without a sample in mode 0 (stuck)."""
    actuator = observer.bench.actuator
    change = (
        actuator.constant.value
        * actuator.limit.value
        / observer.inertia.value
        * observer.sample_period_s
    )
    if change <= 2.0 * switched.switch_speed.value:
        return ""
    unit = si_unit("velocity", observer.axis)
    return (
        f"the drive changes the speed by up to {change:.3g} {unit} per sample, so that a motion "
        f"can reverse without passing mode 0 (below {switched.switch_speed.value:g} {unit}); such "
        f"a reversal is not certified{_made_up(switched)}"
    )


def _made_up(switched: Switched) -> str:
    after = switched.motion_after_turn_s
    return "" if after is None else f"; its effect decays in {after * 1e3:.3g} ms of motion"


def _rest(switched: Switched) -> list[str]:
    said = "at rest the error of alpha is constant (eigenvalue 1), and no decay is certified"
    after = switched.motion_after_rest_s
    return [
        said
        if after is None
        else f"{said}; the effect of any rest decays in {after * 1e3:.3g} ms of motion"
    ]


def _slow(observer: Observer, switched: Switched) -> str:
    slowest = max(
        time_constant(mode.spectral_radius, observer.sample_period_s) for mode in switched.modes
    )
    return (
        f"the wear is estimated with a time constant of {slowest:.3g} s; for a faster estimate, "
        f"choose a --decay below {switched.decay:g}"
        if slowest > SLOW_S
        else ""
    )


def _dear(switched: Switched) -> str:
    least = switched.smallest_gamma
    if least is None or switched.quiet is not None or switched.gamma <= DEAR * least:
        return ""
    return (
        f"the error bound gamma is {switched.gamma / least:.3g} times the gamma without a decay: "
        f"choose a --decay nearer to 1 than {switched.decay:.5g}"
    )


def _left_out(model: Model, known: tuple[str, ...]) -> str:
    names = [name for name in left_out(model) if name not in known]
    return f"the observer neglects: {', '.join(names)}" if names else ""


def time_constant(radius: float, period: float) -> float:
    """Return the time constant [s] of the error in a mode with the spectral radius `radius`."""
    return -period / math.log(radius) if 0.0 < radius < 1.0 else 0.0
