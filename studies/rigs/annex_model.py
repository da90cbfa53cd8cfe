"""Model of the clutch of annex C: table 2, with the friction of figure 7 as speed regimes (30)."""

from __future__ import annotations

import msgspec

from frictool.documents.laws import Laws, Regime
from frictool.documents.model import Model
from frictool.documents.quantity import Estimate, Quantity
from studies.rigs.clutch_model import Triple, clutch_model

INERTIA: Triple = (1.32e-5 - 2.1e-6, 1.32e-5, 1.32e-5 + 2.1e-6)
CONSTANT: Triple = (
    13.4e-3 - 1.2e-3,
    13.4e-3,
    13.4e-3 + 1.2e-3,
)  # as printed; table 5.2 has half of this width
VISCOUS: Triple = (0.0, 3.8e-4, 7.6e-4)
COULOMB: Triple = (0.073, 0.1, 0.127)
KNEE = 260.0  # rad/s


def annex_model() -> Model:
    """Return the model with the intervals of table 2.

    Viscous friction is 0 below the knee, and 0 to 7.6e-4 N m s/rad above it.
    """

    def ranged(found: Triple, unit: str) -> Quantity:
        return Quantity(low=found[0], value=found[1], high=found[2], unit=unit)

    def estimate(found: Triple, unit: str) -> Estimate:
        return Estimate(low=found[0], value=found[1], high=found[2], unit=unit, source="bench")

    model = clutch_model(coulomb=COULOMB, constant=CONSTANT)
    mechanics = msgspec.structs.replace(
        model.bench.mechanics,
        inertia=ranged(INERTIA, "kg m^2"),
        viscous=ranged(VISCOUS, "N m s/rad"),
        coulomb=ranged(COULOMB, "N m"),
    )
    parameters = msgspec.structs.replace(
        model.parameters,
        inertia=estimate(INERTIA, "kg m^2"),
        viscous=estimate((0.0, 0.0, 0.0), "N m s/rad"),
    )
    regime = Regime(
        above=Quantity(value=KNEE, unit="rad/s"), viscous=estimate(VISCOUS, "N m s/rad")
    )
    bench = msgspec.structs.replace(model.bench, mechanics=mechanics)
    return msgspec.structs.replace(
        model, bench=bench, parameters=parameters, laws=Laws(regimes=(regime,))
    )
