"""Model of the clutch from its bench, for tests without an identification."""

from __future__ import annotations

from pathlib import Path

import msgspec

from frictool.documents.bench import Bench
from frictool.documents.model import Model, Parameters
from frictool.documents.provenance import Provenance
from frictool.documents.quantity import Estimate, Quantity
from frictool.documents.registry import load

ROOT = Path(__file__).parents[2]
Triple = tuple[float, float, float]


def clutch_model(
    *, coulomb: Triple = (0.018, 0.099, 0.180), constant: Triple = (12.8e-3, 13.4e-3, 14.0e-3)
) -> Model:
    """Return the clutch with its a-priori intervals; `coulomb`, `constant`: (low, value, high)."""
    bench = load(ROOT / "configs/clutch/bench.yaml", Bench)
    k = Quantity(low=constant[0], value=constant[1], high=constant[2], unit="N m/A")
    bench = msgspec.structs.replace(
        bench, actuator=msgspec.structs.replace(bench.actuator, constant=k)
    )

    def estimate(low: float, value: float, high: float, unit: str) -> Estimate:
        return Estimate(value=value, low=low, high=high, unit=unit, source="bench")

    parameters = Parameters(
        inertia=estimate(1.11e-5, 1.32e-5, 1.53e-5, "kg m^2"),
        viscous=estimate(0.0, 3.81e-4, 7.62e-4, "N m s/rad"),
        coulomb=estimate(*coulomb, "N m"),
        breakaway=estimate(coulomb[0], 1.1 * coulomb[1], 1.1 * coulomb[2], "N m"),
        offset=estimate(0.0, 0.0, 0.0, "N m"),
    )
    return Model(
        format="model/1",
        name="clutch",
        axis="rotary",
        law="coulomb",
        method="bench",
        confidence=0.95,
        bench=bench,
        parameters=parameters,
        provenance=Provenance("a test", "0"),
    )
