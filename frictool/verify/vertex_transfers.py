"""Closed-loop transfer functions at every vertex with their upper bounds, called templates.

Thesis figures 5.13 to 5.16 show these functions:

    structure position    e/s, i/s, e/w, x/s    s: position reference behind the prefilter,
                                                e = s - x
    speed cascade         e/s, i/s, e/w, v/s    s: speed reference, e = s - v
    i: drive that reaches the actuator, w: friction in units of the Coulomb friction
    |e/s| <= gamma/|W2|    |i/s| <= gamma/W3    |e/w| <= gamma/|W1 W2|    (thesis 5.54)

The weights are sampled by Tustin's method, as for the verified norm: if the verified norm is below
gamma, every transfer function is below its template. A PI controller of the speed is designed
without weights and has no templates. The transfer functions do not include a proportional law
around a speed loop.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from frictool.documents.certificate import CertifiedWeights
from frictool.documents.controller import Controller, Velocity, Vertex
from frictool.plant.block_diagram import DiagramBlock, connect
from frictool.plant.generalised_plant import (
    Controlled,
    FirstOrderWeight,
    PlantWeights,
    generalised_plant,
)
from frictool.plant.linear_axis import AxisRates
from frictool.plant.lti import Lti, delay, gain, zero_order_hold
from frictool.plant.polytope import PlantPoint
from frictool.presentation.tie_rule import largest
from frictool.typing import Vector
from frictool.verify.feedback_loops import DIFFERENCE, SPEED, low_pass, measured_axis, running_form
from frictool.verify.hinf_norm import norm
from frictool.verify.loop_values import first_order
from frictool.verify.observer_loop import shown_speeds

Name = Literal["error", "drive", "disturbance", "output"]
POINTS = 240
# decades below half the sampling frequency, or down to a tenth of W2's pole if this is lower
DECADES = 4
UNIT = PlantWeights(error=FirstOrderWeight(1.0), disturbance=1.0, drive=1.0)
# row and column in the generalised plant: [W2 e; W3 i] from [reference; W1 friction]
ENTRIES: dict[Name, tuple[int, int]] = {"error": (0, 0), "drive": (1, 0), "disturbance": (0, 1)}


@dataclass(frozen=True)
class WorstGain:
    """Largest ratio of a gain to its template, with its vertex and frequency [rad/s]."""

    ratio: float
    vertex: str
    frequency: float


@dataclass(frozen=True)
class VertexTransfer:
    """One closed-loop transfer function at every vertex.

    - gains: gains of the transfer function (vertices, frequencies)
    - template: upper bound (frequencies,) of the gains
    - worst: largest ratio of a gain to the template

    `template` and `worst` are None if a weight in the template is 0 or unknown.
    """

    name: Name
    gains: NDArray[np.float64]
    template: Vector | None
    worst: WorstGain | None


@dataclass(frozen=True)
class VertexTransfers:
    """Transfer functions of all vertices at the frequencies (n,) [rad/s].

    The templates are proportional to `gamma`: the requested gamma if `is_requested`, else the
    verified norm.
    """

    frequencies: Vector
    vertices: tuple[str, ...]
    transfers: tuple[VertexTransfer, ...]
    gamma: float
    is_requested: bool


def sensitivities(controller: Controller) -> VertexTransfers | str:
    """Return the transfer functions at every vertex, or the reason why there are none."""
    stable = tuple(vertex for vertex in controller.verified.vertices if vertex.stable)
    if not stable:
        return "the controller names no vertex at which its loop is stable"
    weights, verified = controller.judged_by, controller.verified
    gamma = verified.gamma_asked or verified.gamma_verified
    frequencies = _frequencies(controller.sample_period_s, weights)
    responses = np.stack(
        [_closed(controller, vertex, UNIT).response(frequencies) for vertex in stable]
    )
    gains: dict[Name, NDArray[np.float64]] = {
        name: np.abs(responses[:, :, row, column]) for name, (row, column) in ENTRIES.items()
    }
    gains["output"] = np.abs(1.0 - responses[:, :, 0, 0])
    templates = (
        {}
        if weights is None
        else _templates(weights, gamma, frequencies, controller.sample_period_s)
    )
    worst = {} if weights is None else _worst(controller, stable, weights, gamma)
    transfers = tuple(
        VertexTransfer(name, gain, templates.get(name), worst.get(name))
        for name, gain in gains.items()
    )
    return VertexTransfers(
        frequencies,
        tuple(vertex.name for vertex in stable),
        transfers,
        gamma,
        verified.gamma_asked is not None,
    )


def _frequencies(period: float, weights: CertifiedWeights | None) -> Vector:
    highest = np.pi / period
    pole = None if weights is None else weights.error.pole
    lowest = min(highest / 10**DECADES, 0.1 * pole if pole is not None else np.inf)
    return np.geomspace(lowest, highest * (1.0 - 1e-9), POINTS)


def _closed(controller: Controller, vertex: Vertex, weights: PlantWeights) -> Lti:
    controlled: Controlled = "position" if controller.structure == "position" else "speed"
    rates = PlantPoint(
        vertex.name, vertex.inertia, vertex.viscous, vertex.coulomb, vertex.constant
    ).rates
    lag = controller.bench.actuator.loop_time_constant_s
    period = controller.sample_period_s
    if controlled == "speed" and controller.linear.input == "speed_error":
        return _closed_by_speed(controller, rates, lag)
    plant = generalised_plant(controlled, rates, lag, weights, period, controller.delay_samples)
    return plant.closed(running_form(controller.linear, period))


def _closed_by_speed(controller: Controller, rates: AxisRates, lag: float) -> Lti:
    period, velocity = controller.sample_period_s, controller.velocity
    sees = SPEED if velocity.source == "measured" else DIFFERENCE
    drive = gain(1.0, period)
    if lag > 0.0:
        drive = zero_order_hold(FirstOrderWeight(1.0, pole=1.0 / lag).system(0.0), period)
    blocks = {
        "controller": DiagramBlock(running_form(controller.linear, period), ("entering",), ("u",)),
        "delay": DiagramBlock(delay(controller.delay_samples, period), ("u",), ("command",)),
        "axis": measured_axis(rates, lag, period, (sees,)),
        "velocity": _velocity(velocity, period, sees),
        "drive": DiagramBlock(drive, ("command",), ("reaching",)),
    }
    sums: dict[str, dict[str, float]] = {"speed_reference": {}, "uncertain_effort": {}}
    sums |= {"entering": {"s": 1.0, "shown": 1.0}, "error": {"s": 1.0, "speed": -1.0}}
    return connect(blocks, sums, ("s", "friction"), ("error", "reaching"))


def _velocity(velocity: Velocity, period: float, sees: str) -> DiagramBlock:
    """Return the block whose output is minus the estimated speed.

    An observer with several modes is represented by its first mode.
    """
    if velocity.observer is not None:
        return DiagramBlock(shown_speeds(velocity.observer)[0].system, (sees, "u"), ("shown",))
    return DiagramBlock(low_pass(velocity, period), (sees,), ("shown",))


def _templates(
    weights: CertifiedWeights, gamma: float, frequencies: Vector, period: float
) -> dict[Name, Vector]:
    w2 = np.abs(first_order(weights.error).system(period).response(frequencies)[:, 0, 0])
    templates: dict[Name, Vector] = {"error": gamma / w2}
    if weights.drive > 0.0:
        templates["drive"] = np.full_like(frequencies, gamma / weights.drive)
    if weights.disturbance > 0.0:
        templates["disturbance"] = gamma / (weights.disturbance * w2)
    return templates


def _worst(
    controller: Controller, vertices: tuple[Vertex, ...], weights: CertifiedWeights, gamma: float
) -> dict[Name, WorstGain]:
    weighted = PlantWeights(first_order(weights.error), weights.disturbance, weights.drive)
    loops = [_closed(controller, vertex, weighted) for vertex in vertices]
    worst: dict[Name, WorstGain] = {}
    for name, (row, column) in ENTRIES.items():
        entries = (
            Lti(one.a, one.b[:, [column]], one.c[[row]], one.d[[row]][:, [column]], one.period)
            for one in loops
        )
        peaks = [norm(entry) for entry in entries]
        level, at = largest(peak for peak, _ in peaks)
        if level > 0.0:
            worst[name] = WorstGain(level / gamma, vertices[at].name, peaks[at][1])
    return worst
