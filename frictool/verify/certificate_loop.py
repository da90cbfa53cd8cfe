"""Closed loop of a certificate in interval arithmetic, built row by row from stored coefficients.

    [x+]   [A  B] [x]    x: delay line, drive (with a lag), speed, eta, W2 and W4 (if they
    [z ] = [C  D] [w]       have a state), controller
                         w: reference, friction times W1, noise
                         z: W2 e, W3 i, W_u u, W_eta eta (each if it is weighted)

The plant is that of generalised_plant.py. Only the axis depends on the parameters, and the loop is
affine in its coefficients, because u = c x_k + d y enters the axis only once.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Literal

import numpy as np

from frictool.documents.certificate import CertifiedWeights, Filter
from frictool.documents.controller import StateSpace
from frictool.verify.enclosed_axis import EnclosedAxis
from frictool.verify.interval_arithmetic import Enclosure

_Signals = Callable[[str], Enclosure]
SENSITIVITY = CertifiedWeights(
    error=Filter(1.0), disturbance=0.0, drive=0.0
)  # with controlled position: (5.54)


@dataclass(frozen=True)
class CertificateLoop:
    """Data of the loop that are the same for every plant; `period` and `lag` in s.

    `sections` replace the controller's matrices if the target runs sections. Each is b0 b1 b2 a0 a1
    a2 with a0 = 1, as stored.
    """

    controller: StateSpace
    controlled: Literal["position", "speed"]
    delay: int
    lag: float
    period: float
    weights: CertifiedWeights
    sections: tuple[tuple[float, ...], ...] = ()

    @property
    def inner(self) -> list[str]:
        """Names of the controller's states; a section of order n (0 to 2) has n states."""
        if not self.sections:
            return [f"controller {k}" for k in range(len(self.controller.a))]
        return [
            f"section {k}.{order}"
            for k, section in enumerate(self.sections)
            for order in range(1, _order(section) + 1)
        ]

    @property
    def states(self) -> list[str]:
        """Names of the states in order."""
        axis = ["drive"] * (self.lag > 0.0) + ["speed", "eta"]
        filters = [
            name
            for name, weight in (("W2", self.weights.error), ("W4", self.weights.noise))
            if weight.pole is not None
        ]
        return [*(f"delay {k}" for k in range(self.delay)), *axis, *filters, *self.inner]

    @property
    def inputs(self) -> list[str]:
        """Names of the inputs in order."""
        weights = self.weights
        return (
            ["reference"]
            + ["friction"] * (weights.disturbance > 0.0)
            + ["noise"] * (weights.noise.gain > 0.0)
        )


def closed_loop(loop: CertificateLoop, axis: EnclosedAxis) -> tuple[Enclosure, int]:
    """Return [A B; C D] at one corner of the axis, and the number of states."""
    names = [*loop.states, *loop.inputs]
    unit = Enclosure.matrix(np.identity(len(names), dtype=object))
    nothing = Enclosure.matrix(np.zeros(len(names), dtype=object))
    rows = {name: Enclosure(unit.centre[k], unit.radius[k]) for k, name in enumerate(names)}

    def signal(name: str) -> Enclosure:
        return rows.get(name, nothing)

    weights = loop.weights
    speed = loop.controlled == "speed"
    after: dict[str, Enclosure] = {}
    noise = _filtered(weights.noise, loop.period, "W4", signal("noise"), signal, after)
    eta = signal("eta") if speed else signal("eta") + signal("reference")
    measured = eta + noise
    u = (
        _through_sections(loop, measured, signal, after)
        if loop.sections
        else _through_matrices(loop, measured, signal, after)
    )
    for index in range(loop.delay):
        after[f"delay {index}"] = u if index == 0 else signal(f"delay {index - 1}")
    command = signal(f"delay {loop.delay - 1}") if loop.delay else u
    drive = command if axis.lagless else signal("drive")
    _axis(loop, axis, signal, command, after)
    error = signal("reference") - signal("speed") if speed else eta
    outputs = [_filtered(weights.error, loop.period, "W2", error, signal, after)]
    outputs += [
        Enclosure.of(gain) * row
        for gain, row in (
            (weights.drive, drive),
            (weights.command, u),
            (weights.eta, signal("eta")),
        )
        if gain
    ]
    return Enclosure.stacked([*(after[name] for name in loop.states), *outputs]), len(loop.states)


def _through_matrices(
    loop: CertificateLoop, measured: Enclosure, signal: _Signals, after: dict[str, Enclosure]
) -> Enclosure:
    """Return the requested drive; write the controller's next states into `after`."""
    k = loop.controller
    inner = [signal(name) for name in loop.inner]
    for name, row, (gain,) in zip(loop.inner, k.a, k.b, strict=True):
        after[name] = _combined([*row, gain], [*inner, measured])
    return _combined([*k.c[0], k.d[0][0]], [*inner, measured])


def _through_sections(
    loop: CertificateLoop, measured: Enclosure, signal: _Signals, after: dict[str, Enclosure]
) -> Enclosure:
    """Return the requested drive of the sections; write their next states into `after`.

    Transposed direct form II, as in control/second_order_sections.py. Products of coefficients are
    exact.
    """
    passing = measured
    for k, section in enumerate(loop.sections):
        b0, b1, b2, _, a1, a2 = section
        leaving = Enclosure.of(b0) * passing + signal(f"section {k}.1")
        for order, ahead, back in ((1, b1, a1), (2, b2, a2))[: _order(section)]:
            fed = Enclosure.of(ahead) * passing + Enclosure.of(-back) * leaving
            after[f"section {k}.{order}"] = fed + signal(
                f"section {k}.{order + 1}"
            )  # zero after the last state
        passing = leaving
    return passing


def _order(section: tuple[float, ...]) -> int:
    _, b1, b2, _, a1, a2 = section
    return 2 if b2 or a2 else int(bool(b1 or a1))


def _axis(
    loop: CertificateLoop,
    axis: EnclosedAxis,
    signal: _Signals,
    command: Enclosure,
    after: dict[str, Enclosure],
) -> None:
    """Write the axis's next states into `after`, by the equations of linear_axis.py."""
    drive, speed = signal("drive"), signal("speed")
    friction = Enclosure.of(loop.weights.disturbance) * signal("friction")
    if not axis.lagless:
        after["drive"] = axis.kept_drive * drive + (Enclosure.of(1) - axis.kept_drive) * command
    driven = axis.speed_from_drive * drive + axis.speed_from_command * command
    after["speed"] = axis.kept_speed * speed + driven + axis.speed_from_friction * friction
    moved = axis.eta_from_drive * drive + axis.eta_from_command * command
    after["eta"] = (
        signal("eta") + axis.eta_from_speed * speed + moved + axis.eta_from_friction * friction
    )
    if loop.controlled == "speed":
        after["eta"] = after["eta"] + Enclosure.of(loop.period) * signal("reference")


def _combined(gains: Sequence[float], rows: Sequence[Enclosure]) -> Enclosure:
    total = Enclosure.of(gains[0]) * rows[0]
    for gain, row in zip(gains[1:], rows[1:], strict=True):
        total = total + Enclosure.of(gain) * row
    return total


def _filtered(
    weight: Filter,
    period: float,
    name: str,
    entering: Enclosure,
    signal: _Signals,
    after: dict[str, Enclosure],
) -> Enclosure:
    """Return the output of a weight's Tustin equivalent: x+ = a x + (1 - a) e, z = c x + d e.

    Writes x+ into `after` if the weight has a state.
    """
    gain = Fraction(weight.gain)
    if weight.pole is None:
        return Enclosure.of(gain) * entering
    half = Fraction(weight.pole) * Fraction(period) / 2
    high = (
        gain * Fraction(weight.pole) / Fraction(weight.zero)
        if weight.zero is not None
        else Fraction(0)
    )
    kept = (1 - half) / (1 + half)
    through = half / (1 + half)
    after[name] = Enclosure.of(kept) * signal(name) + Enclosure.of(1 - kept) * entering
    direct = high + through * (gain - high)
    return Enclosure.of((gain - high) / (1 + half)) * signal(name) + Enclosure.of(direct) * entering
