"""Switched observers of the thesis, (6.4) and (6.22): a model and correction gains per mode.

    mode   0 if |omega| < Sigma, else the cell of the direction that contains theta (6.17)
    e      = y - theta
    theta' = theta + T omega + L1 e
    omega' = omega + T/J (u - F) + L2 e      slipping
           = a omega + L2 e                  stuck, a = 0 (6.18), or 1
    F      = alpha f_i (6.13), or f(theta) + alpha (6.22), against the motion
    alpha' = alpha + L3 e                    slipping, within [alpha_min, alpha_max]
           = alpha                           stuck

T is the sample period, J the inertia, u the effort, F the friction, and Sigma the switching speed.
A cell is an interval of positions in one direction of motion with the gains L1, L2, L3 and the
friction f_i; f(theta) is a polynomial. y is the measured position; theta, omega and alpha are the
estimates of position, speed and wear at one sample. theta and omega determine the mode. F has the
sign of omega. In mode 0, called stuck, alpha keeps its value.

Limitation: the certificate of the thesis, (6.6), assumes that the mode is known. The certificate is
not valid at samples at which plant and observer are in different modes. Sigma should be some
encoder steps per period. With a coarse encoder, the speed is then below Sigma during most of the
travel, and both observers fail (figures: docs/theory/observers.md).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from frictool.control.observer_output import ObserverNodes
from frictool.control.program import Program, ProgramNode

STATES = ("estimated_position", "estimated_velocity", "estimated_wear")


@dataclass(frozen=True)
class SlipMode:
    """Mode of the switched observer in slip: an interval of positions in one direction.

    - high: upper end of the interval [rad | m]
    - friction: magnitude f_i of the friction [N m | N]
    - gains: correction gains L1 [1], L2 [1/s], L3 [wear per rad | m]
    """

    high: float
    friction: float
    gains: tuple[float, float, float]


@dataclass(frozen=True)
class SwitchedParameters:
    """Parameters of the switched observer, in SI.

    - switch_speed: speed Sigma [rad/s | m/s] below which the axis counts as stuck
    - forward, backward: cells in order of position; the first and the last cell also apply beyond
      the travel
    - stuck: gains (L1, L2) of mode 0 (stuck)
    - kept: factor a on the estimated speed at each sample of mode 0 (stuck)
    - additive: True if wear is an increase of friction, False if it is a factor
    - curves (forward, backward): friction f as polynomials of the position, coefficients in rising
      powers; if `additive`, these curves replace the cells' friction
    - travel: (low, high) position, beyond which the polynomials keep their values
    - viscous: viscous friction [N m s/rad | N s/m], 0 in the thesis
    - offset: constant effort that opposes a positive drive [N m | N], 0 in the thesis
    - top_speed: bound of the estimated speed [rad/s | m/s]
    - wear: bounds (alpha_min, alpha_max) of the estimated wear
    """

    period: float
    inertia: float
    switch_speed: float
    forward: tuple[SlipMode, ...]
    backward: tuple[SlipMode, ...]
    stuck: tuple[float, float]
    kept: float
    additive: bool
    curves: tuple[tuple[float, ...], tuple[float, ...]]
    travel: tuple[float, float]
    viscous: float
    offset: float
    top_speed: float
    wear: tuple[float, float]


@dataclass(frozen=True)
class ActiveModeNodes:
    """Nodes of the mode at a sample: `is_stuck` is true in mode 0; `gains` are L1, L2, L3."""

    is_stuck: ProgramNode
    gains: tuple[ProgramNode, ProgramNode, ProgramNode]


def write_prediction(
    program: Program, position: ProgramNode, facts: SwitchedParameters
) -> tuple[ObserverNodes, ActiveModeNodes]:
    """Write the states of the observer; return the estimates and the active mode at this sample.

    `position` is the measured position y [rad | m]. The observer starts at this position, at rest,
    without wear.
    """
    program.block("switched observer: mode from the estimate; gains and friction of this mode")
    top = facts.top_speed
    theta = program.state(STATES[0], position.low, position.high, start="position")
    omega = program.state(STATES[1], -top, top)
    wear = program.state(STATES[2], *facts.wear, start=0.0 if facts.additive else 1.0)
    zero = program.constant(0.0)
    is_stuck = program.named(
        "is_stuck", abs(omega) < program.constant(facts.switch_speed, "switch_speed")
    )
    is_forward = program.named("is_forward", omega > zero)
    sides = [
        _DirectionCells(program, theta, cells, name)
        for cells, name in ((facts.forward, "forward"), (facts.backward, "backward"))
    ]
    stuck = [program.constant(gain, f"stuck_gain_{row}") for row, gain in enumerate(facts.stuck)]
    slips = [program.select(is_forward, *(side.gain(row) for side in sides)) for row in range(3)]
    gains = [
        program.named(f"chosen_gain_{row}", program.select(is_stuck, stuck[row], slips[row]))
        for row in range(2)
    ]
    size = _friction(program, theta, wear, is_forward, sides, facts)
    friction = program.named(
        "estimated_friction",
        program.select(is_stuck, zero, program.select(is_forward, size, -size)),
    )
    return ObserverNodes(theta, omega, friction, wear), ActiveModeNodes(
        is_stuck, (gains[0], gains[1], program.named("chosen_gain_2", slips[2]))
    )


def write_correction(
    program: Program,
    position: ProgramNode,
    effort: ProgramNode,
    estimates: ObserverNodes,
    chosen: ActiveModeNodes,
    facts: SwitchedParameters,
) -> None:
    """Write the next states of the observer: prediction by the model plus measurement correction.

    - position: measured position y [rad | m]
    - effort: drive effort u [N m | N] until the next sample
    """
    program.block("switched observer: prediction by the model of the mode, correction by its gains")
    theta, omega, wear = (program.states[name] for name in STATES)
    error = program.named("innovation", position - theta)
    one = program.constant(1.0)
    period = program.constant(facts.period, "period")
    program.update(STATES[0], program.dot([one, period, chosen.gains[0]], [theta, omega, error]))
    push = effort - estimates.friction
    if facts.viscous != 0.0:
        push = push - program.constant(facts.viscous, "observer_viscous") * omega
    if facts.offset != 0.0:
        push = push - program.constant(facts.offset, "observer_offset")
    slipping = omega + program.constant(facts.period / facts.inertia, "period_per_inertia") * push
    standing = program.constant(facts.kept, "stuck_speed") * omega
    program.update(
        STATES[1], program.select(chosen.is_stuck, standing, slipping) + chosen.gains[1] * error
    )
    least, most = (
        program.constant(end, name)
        for end, name in zip(facts.wear, ("least_wear", "most_wear"), strict=True)
    )
    learned = program.smaller(program.larger(wear + chosen.gains[2] * error, least), most)
    program.update(STATES[2], program.select(chosen.is_stuck, wear, learned))


class _DirectionCells:
    def __init__(
        self, program: Program, theta: ProgramNode, cells: Sequence[SlipMode], name: str
    ) -> None:
        self.program, self.cells, self.name = program, cells, name
        self.below = [
            theta < program.constant(cell.high, f"{name}_edge_{k}")
            for k, cell in enumerate(cells[:-1])
        ]

    def gain(self, row: int) -> ProgramNode:
        return self._of_cell(f"gain_{row}", [cell.gains[row] for cell in self.cells])

    def friction(self) -> ProgramNode:
        return self._of_cell("friction", [cell.friction for cell in self.cells])

    def _of_cell(self, what: str, values: Sequence[float]) -> ProgramNode:
        nodes = [
            self.program.constant(value, f"{self.name}_{what}_{k}")
            for k, value in enumerate(values)
        ]
        chosen = nodes[-1]
        for is_below, node in zip(reversed(self.below), reversed(nodes[:-1]), strict=True):
            chosen = self.program.select(is_below, node, chosen)
        return chosen


def _friction(
    program: Program,
    theta: ProgramNode,
    wear: ProgramNode,
    is_forward: ProgramNode,
    sides: list[_DirectionCells],
    facts: SwitchedParameters,
) -> ProgramNode:
    if not facts.additive:
        known = program.select(is_forward, *(side.friction() for side in sides))
        return program.named("friction_size", wear * program.named("friction_known", known))
    low, high = (
        program.constant(end, name)
        for end, name in zip(facts.travel, ("map_low", "map_high"), strict=True)
    )
    within = program.named("position_on_map", program.smaller(program.larger(theta, low), high))
    curves = [
        program.polynomial(
            within,
            [program.constant(c, f"{side.name}_curve_{power}") for power, c in enumerate(curve)],
        )
        for curve, side in zip(facts.curves, sides, strict=True)
    ]
    return program.named(
        "friction_size", program.named("friction_known", program.select(is_forward, *curves)) + wear
    )
