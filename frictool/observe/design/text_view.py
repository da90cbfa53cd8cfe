"""Output of `observe design` as text and as JSON."""

from __future__ import annotations

from typing import Any

from frictool.documents.model import Model
from frictool.documents.observer import Mode, Observer, Switched
from frictool.documents.quantity import si_unit
from frictool.observe.design.design_notes import count_speed, notes, time_constant


def text(observer: Observer, model: Model) -> str:
    """Return the design of an observer as text."""
    switched = observer.switched
    if switched is None:
        return "\n".join(
            [*_tracking(observer), *(f"note: {line}" for line in notes(observer, model))]
        )
    unit = si_unit("velocity", observer.axis)
    lines = [
        f"{observer.name}: {switched.wear} switched observer, "
        f"{observer.sample_period_s * 1e3:g} ms, {len(switched.modes)} modes, "
        f"{len(switched.transitions)} transitions, "
        f"stuck below {switched.switch_speed.value:g} {unit}",
        f"gamma {switched.gamma:.4g}{_without(switched)}, "
        f"largest gain in simulation {switched.simulated_gain:.4g}; "
        f"each sample multiplies the error by at most {switched.decay:.5g}",
        *_table(observer, switched),
        f"two modes that alternate: spectral radius {switched.switching_radius:.4f}",
        f"""alpha: {
            _span(
                [
                    time_constant(mode.spectral_radius, observer.sample_period_s)
                    for mode in switched.modes
                    if mode.direction
                ]
            )
        } ms""",
        *(f"note: {line}" for line in notes(observer, model)),
    ]
    return "\n".join(lines)


def json_view(observer: Observer, model: Model) -> dict[str, Any]:
    """Return the design of an observer as a JSON object."""
    switched, tracking = observer.switched, observer.tracking
    if switched is None:
        assert tracking is not None
        section = {
            "bandwidth_rad_s": tracking.bandwidth_rad_s,
            "gains": list(tracking.gains),
            "cell": tracking.cell,
        }
        return {
            "kind": observer.kind,
            **section,
            "inertia": observer.inertia.value,
            "notes": notes(observer, model),
        }
    return {
        "kind": observer.kind,
        "inertia": observer.inertia.value,
        "gamma": switched.gamma,
        "smallest_gamma": switched.smallest_gamma,
        "simulated_gain": switched.simulated_gain,
        "decay": switched.decay,
        "switch_speed": switched.switch_speed.value,
        "weights": list(switched.weights),
        "switching_radius": switched.switching_radius,
        "stuck_speed": switched.stuck_speed,
        "motion_after_rest_s": switched.motion_after_rest_s,
        "motion_after_turn_s": switched.motion_after_turn_s,
        "quiet": switched.quiet,
        "noise_gain": switched.noise_gain,
        "count_speed": count_speed(observer),
        "modes": [_mode(mode, observer.sample_period_s) for mode in switched.modes],
        "transitions": [list(pair) for pair in switched.transitions],
        "notes": notes(observer, model),
    }


def _tracking(observer: Observer) -> list[str]:
    tracking = observer.tracking
    assert tracking is not None
    position, effort = si_unit("position", observer.axis), si_unit("effort", observer.axis)
    return [
        f"{observer.name}: tracking observer, {observer.sample_period_s * 1e3:g} ms, bandwidth "
        f"{tracking.bandwidth_rad_s:.4g} rad/s; "
        f"dead zone of the innovation {tracking.cell:.4g} {position}",
        f"gains of the innovation: position {tracking.gains[0]:.4g}, "
        f"speed {tracking.gains[1]:.4g} 1/s, disturbance "
        f"{tracking.gains[2]:.4g} {effort}/{position}",
    ]


def _mode(mode: Mode, period: float) -> dict[str, Any]:
    return {
        "index": mode.index,
        "direction": mode.direction,
        "over": None if mode.over is None else list(mode.over),
        "friction": mode.friction,
        "deviation": mode.deviation,
        "gains": [list(row) for row in mode.gains],
        "spectral_radius": mode.spectral_radius,
        "time_constant_s": time_constant(mode.spectral_radius, period),
    }


def _without(switched: Switched) -> str:
    least = switched.smallest_gamma
    if switched.quiet is not None and least is not None:
        noise = (
            "" if switched.noise_gain is None else f"; noise gain at most {switched.noise_gain:.4g}"
        )
        return (
            f" (up to {switched.quiet:g} times the smallest, {least:.4g}, "
            f"for gains that pass less encoder noise{noise})"
        )
    return "" if least is None or switched.decay == 1.0 else f" ({least:.4g} without a decay)"


def _table(observer: Observer, switched: Switched) -> list[str]:
    heads = (
        "mode",
        f"over {si_unit('position', observer.axis)}",
        f"friction {si_unit('effort', observer.axis)}",
        "deviation",
        "L",
        "radius",
    )
    rows = [heads, *(_row(mode) for mode in switched.modes)]
    filled = [column for column in range(len(heads)) if any(row[column] for row in rows[1:])]
    widths = [max(len(row[column]) for row in rows) for column in filled]
    return [
        "  ".join(
            row[column].ljust(width) for column, width in zip(filled, widths, strict=True)
        ).rstrip()
        for row in rows
    ]


def _row(mode: Mode) -> tuple[str, ...]:
    over = "" if mode.over is None else f"{mode.over[0]:.4g} .. {mode.over[1]:.4g}"
    size = ("", "") if not mode.friction else (f"{mode.friction:.4g}", f"{mode.deviation:.3g}")
    return (
        str(mode.index),
        over,
        *size,
        " ".join(f"{row[0]:.4g}" for row in mode.gains),
        f"{mode.spectral_radius:.4f}",
    )


def _span(seconds: list[float]) -> str:
    low, high = f"{1e3 * min(seconds):.3g}", f"{1e3 * max(seconds):.3g}"
    return f"time constant {low}" if low == high else f"time constant {low} to {high}"
