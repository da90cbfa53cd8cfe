"""Energy of a mechanism: kinetic energy, and energy stored in compliant links and in pushes.

A push is a constant or position-dependent effort. The energies and the entries of `work`
(engine/mechanism/state.py) satisfy the balance:

    kinetic + stored - (kinetic + stored at the start) = work of sources and external efforts
        - losses in joints, couplings, friction, cams, impacts and stops
"""

from __future__ import annotations

from typing import NamedTuple

from frictool.engine.mechanism import array_layout as ly
from frictool.engine.mechanism.array_layout import CompiledMechanism
from frictool.engine.mechanism.curves import curve_integral
from frictool.engine.mechanism.efforts import coupling_stretch
from frictool.engine.mechanism.state import OPEN, MechanismState, WorkByElement, work_by_element
from frictool.runtime.kernels import kernel
from frictool.typing import IntVector, Vector


class EnergyBalance(NamedTuple):
    """Energies of a mechanism [J].

    - stored: energy in couplings and in pushes (constant or position-dependent efforts). It is 0
      for an unstrained coupling, for a constant push at position 0, and for a force curve at the
      first point of the curve
    - put_in: work of sources and external efforts
    - lost: work that all other elements absorb, minus the work that they return
    """

    kinetic: float
    stored: float
    put_in: float
    lost: float

    @property
    def total(self) -> float:
        """Return kinetic + stored + lost - put_in [J], which is constant over a run."""
        return self.kinetic + self.stored + self.lost - self.put_in


@kernel
def _held(k: IntVector, p: Vector, y: Vector, modes: IntVector) -> tuple[float, float]:
    n = k[ly.BLOCKS]
    kinetic = 0.0
    stored = 0.0
    for i in range(n):
        kinetic += 0.5 * ly.mass_of(k, p, i) * y[n + i] ** 2
    for c in range(k[ly.COUPLINGS]):
        row = ly.coupling_row(k, c)
        s, _ = coupling_stretch(k, p, c, y)
        if ly.gap(p, row) > 0.0:
            mode = modes[n + 2 * k[ly.JOINTS] + c]
            if mode == OPEN:
                continue
            s = s - mode * ly.gap(p, row)
        stored += 0.5 * ly.stiffness(p, row) * s * s
        curve = ly.coupling_curve(k, c)
        if curve >= 0:
            stored += curve_integral(k, p, curve, s)
    for q in range(k[ly.PUSHES]):
        block, curve = ly.push_block(k, q), ly.push_curve(k, q)
        stored -= ly.push_of(k, p, q) * y[block]
        if curve >= 0:
            stored -= curve_integral(k, p, curve, y[block])
    return kinetic, stored


def balance(machine: CompiledMechanism, state: MechanismState) -> EnergyBalance:
    """Return kinetic and stored energy in `state`, and the energy supplied and lost so far [J]."""
    kinetic, stored = _held(machine.whole, machine.numbers, state.y, state.modes)
    work: WorkByElement = work_by_element(machine, state)
    put_in = float(work.sources.sum() + work.external.sum())
    lost = sum(float(part.sum()) for part in work[2:])
    return EnergyBalance(kinetic, stored, put_in, lost)
