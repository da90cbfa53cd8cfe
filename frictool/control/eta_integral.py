"""What a speed controller on eta is given, eta = integral(omega_c) - position, and its hold while
the drive is limited.

Both integrals advance by their difference, so that no number grows with the distance travelled.
While the last drive was limited and eta would move further into that limit, eta is held
(conditional integration). A positive eta asks for a positive drive: that is the sign convention of
`controller.yaml`.
"""

from __future__ import annotations

from frictool.control.program import Program, ProgramNode


def next_eta(
    program: Program,
    increment: ProgramNode,
    motion: ProgramNode,
    limited: ProgramNode,
    resting: ProgramNode | None,
    bound: float,
) -> ProgramNode:
    """eta [rad | m] at this sample, 0 after a rest.

    increment: T omega_c; motion: the position's difference since the last sample; limited: -1, 0,
    +1, the limit that the last drive met.
    """
    program.block(
        "eta = integral(speed reference) - position, held while it would push a limited drive further into its limit"
    )
    before = program.state("eta_before", -bound, bound)
    zero = program.constant(0.0)
    change = program.named("change", increment - motion)
    eta = program.named("eta", program.select(limited * change > zero, before, before + change))
    program.update("eta_before", eta if resting is None else program.select(resting, zero, eta))
    return eta
