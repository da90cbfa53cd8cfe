"""The band around the target, inside which the drive ends at zero: no limit cycle can start where
nothing drives (5.2.2, 5.2.3).

====  =====
=======================================================================================================
code  mode   what runs
====  =====
=======================================================================================================
0     RUN    the position law gives the speed reference, the speed loop is closed
1     BRAKE  the speed reference is 0, the speed loop is closed
2     REST   the drive is 0, the speed loop is open and reset
====  =====
=======================================================================================================

The band acts where |e| <= band and the prefilter has settled, |f'| < settled_speed: with the error
alone the axis would be dropped in the middle of a move, whenever it happens to follow the filtered
reference closely. `cut` goes to REST at once, `brake` first brings the measured speed below
`rest_speed`. Leaving the band, or a moving prefilter, is RUN again.

What holds of it is boundedness and rest; the decrease of (5.12) has no sign and proves no
stability. Rule: a band above the way that friction needs to stop from the speed at which it acts,
and above two encoder steps; small bands with a cut hunt at low friction.
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
    """Whether |e| <= band and, where it has to, the prefilter moves slower than `settled_speed`
    [per s]."""
    inside = abs(error) <= band
    if reference_speed is None or settled_speed is None:
        return inside
    return inside & (abs(reference_speed) < program.constant(settled_speed, "settled_speed"))


def next_mode(
    program: Program, inside: ProgramNode, speed: ProgramNode | None, rest_speed: float
) -> ProgramNode:
    """The mode at this sample. `speed`: the measured one, where the band brakes; None where it
    cuts."""
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
