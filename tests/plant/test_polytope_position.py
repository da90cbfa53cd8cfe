"""Coulomb friction that varies with position: the polytope holds every place."""

from __future__ import annotations

import msgspec
import numpy as np

from frictool.adapters.parameter_intervals import intervals
from frictool.documents.model import Model
from frictool.documents.registry import load
from studies.rigs.clutch_friction import BACKWARD, FORWARD
from studies.rigs.identification_rigs import ROOT


def test_the_hull_holds_table_4_7_in_either_direction() -> None:
    model = load(ROOT / "configs" / "clutch" / "nonlinear.yaml", Model)
    places = np.linspace(0.0, 63.0, 500)
    slip = np.concatenate(
        [
            np.polynomial.polynomial.polyval(places, np.array(side)) / 1.1
            for side in (FORWARD, BACKWARD)
        ]
    )
    low, high = intervals(model)["coulomb"]
    assert low <= slip.min()
    assert high >= slip.max() * (1.0 - 1e-3)  # levels of the document have five digits
    assert high > model.bench.mechanics.coulomb.interval[1]
    flat = msgspec.structs.replace(model, laws=msgspec.structs.replace(model.laws, position=None))
    assert intervals(flat)["coulomb"] == model.bench.mechanics.coulomb.interval
