"""Rest band: positions around the target within which the controller releases the drive.

====  =====  ==================================================================
code  mode   action
====  =====  ==================================================================
0     RUN    the position law sets the speed reference; the speed loop is closed
1     BRAKE  the speed reference is 0; the speed loop is closed
2     REST   the drive is 0; the speed loop is open and reset
====  =====  ==================================================================

Sections 5.2.2 and 5.2.3 of the thesis describe the band. A limit cycle cannot start while the drive
is 0. The band acts if the position error satisfies |e| <= band and the prefilter has settled: the
speed f' of the filtered reference satisfies |f'| < settled_speed. Without the second condition, the
drive would be cut during a move whenever the axis follows the filtered reference closely. The
action `cut` enters REST immediately; the action `brake` first brings the measured speed below
`rest_speed`. The mode is RUN again when the error leaves the band or the prefilter moves.

Property: the motion is bounded and ends at rest. Stability is not proved, because the derivative of
the Lyapunov function in (5.12) of the thesis has no definite sign. The band should be above two
encoder steps, and above the distance in which friction stops the axis after the band begins to act.
With `cut` and a small band, the axis hunts at low friction.
"""

from __future__ import annotations

from frictool.control.program import Program, ProgramNode

RUN, BRAKE, REST = 0.0, 1.0, 2.0


def is_settled(
    program: Program,
    error: ProgramNode,
    band: ProgramNode,
    reference_speed: ProgramNode | None,
    settled_speed: float | None,
) -> ProgramNode:
    """Return the condition |error| <= band and |reference speed| < `settled_speed` [rad/s | m/s].

    - error: position error [rad | m]
    - band: half-width of the rest band [rad | m]

    The condition on the reference speed is left out if `reference_speed` or `settled_speed` is
    None.
    """
    inside = abs(error) <= band
    if reference_speed is None or settled_speed is None:
        return inside
    return inside & (abs(reference_speed) < program.constant(settled_speed, "settled_speed"))


def next_mode(
    program: Program, inside: ProgramNode, speed: ProgramNode | None, rest_speed: float
) -> ProgramNode:
    """Return the mode at this sample: RUN, BRAKE or REST.

    - inside: condition of `is_settled`
    - speed: measured speed [rad/s | m/s] for the action `brake`, None for the action `cut`
    - rest_speed: speed below which braking ends [rad/s | m/s]
    """
    rest = program.constant(REST)
    before = program.state("mode", RUN, REST, start=REST)
    if speed is None:
        at_rest = rest
    else:
        stays = (before >= rest) | (abs(speed) < program.constant(rest_speed, "rest_speed"))
        at_rest = program.select(stays, rest, program.constant(BRAKE))
    mode = program.named("mode_now", program.select(inside, at_rest, program.constant(RUN)))
    program.update("mode", mode)
    return mode
