"""Input of a speed controller: eta = (integral of the speed reference) - position.

Each sample adds only the changes of the integral and of the position to eta. If the last drive was
limited and the change of eta would move the drive further into this limit, eta keeps its value
(conditional integration). A positive eta requests a positive drive, which is the sign convention of
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
    """Return eta [rad | m], the integrated speed reference minus the position.

    - increment: speed reference times the sample period
    - motion: change of the position since the last sample
    - limited: -1 or +1 if the last drive was at its lower or upper limit, else 0
    - resting: node that is true while the drive is off near the target (mode REST); eta then
      restarts from 0 at the next sample
    - bound: largest |eta|
    """
    program.block(
        "eta = integral(speed reference) - position, held while it would push a limited "
        "drive further into its limit"
    )
    before = program.state("eta_before", -bound, bound)
    zero = program.constant(0.0)
    change = program.named("change", increment - motion)
    eta = program.named("eta", program.select(limited * change > zero, before, before + change))
    program.update("eta_before", eta if resting is None else program.select(resting, zero, eta))
    return eta
