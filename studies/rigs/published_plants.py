"""Published problems with numbers: annex C (section 5, table 3), and the position loop of 5.4.3.

The thesis does not state d, which is the unit of the uncertainty channel. W4 of (25) can be
understood in more than one way. A `Reading` is one choice of these values.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from frictool.adapters.model_polytope import polytope, uncertain_centre, uncertain_polytope
from frictool.plant.generalised_plant import (
    FirstOrderWeight,
    GeneralisedPlant,
    PlantWeights,
    generalised_plant,
    template,
)
from frictool.plant.linearised_vertices import Form, vertex_rates
from frictool.plant.polytope import Polytope
from frictool.synth.weights import decade
from studies.rigs.annex_model import annex_model
from studies.rigs.clutch_model import clutch_model

LAG = 3e-3  # s, tau_i
W2 = FirstOrderWeight(100.0, 2.0 * np.pi * 79.6, 5e-3 * 2.0 * np.pi * 79.6)  # (24) with table 3
G1, G3, G4, F4, F5 = 0.1, 0.01, 0.001, 796.0, 1.6e-3
LOW_PASS = decade(G4, F4)  # (25) as printed
HIGH_PASS = FirstOrderWeight(
    G4, LOW_PASS.pole, LOW_PASS.zero
)  # reciprocal of (25), as the text describes it


@dataclass(frozen=True)
class Reading:
    """Choice of W4, W5, d [N m] and the weights of commanded current and eta.

    It includes the resulting gamma for LFT and for LPV+LFT.
    """

    noise: FirstOrderWeight
    uncertainty: FirstOrderWeight
    unit: float
    lft: float
    mixed: float
    command: float = 0.0
    eta: float = 0.0

    @property
    def weights(self) -> PlantWeights:
        return PlantWeights(W2, G1, G3, self.command, self.noise, self.eta, self.uncertainty)


READINGS = {
    "W4 = G4, d 0.0318 N m": Reading(FirstOrderWeight(G4), decade(1.0, F5), 0.0318, 1.030, 1.050),
    "W4 = G4, W5 = 1, d = half-width of F_c": Reading(
        FirstOrderWeight(G4), FirstOrderWeight(1.0), 0.027, 1.020, 1.045
    ),
    "W4 as printed (25), d 0.0318 N m": Reading(LOW_PASS, decade(1.0, F5), 0.0318, 0.862, 0.875),
    "regularised": Reading(HIGH_PASS, decade(1.0, F5), 0.02, 1.1037, 1.1446, 0.1 * G3, 10.0),
}


def annex_lft(reading: Reading) -> GeneralisedPlant:
    """Return the plant of the LFT form (22) with the weights of `reading`, continuous."""
    found = uncertain_centre(annex_model(), reading.unit)
    return generalised_plant(
        "speed", found.rates, LAG, reading.weights, uncertainty=found.uncertainty
    )


def annex_mixed(reading: Reading) -> list[GeneralisedPlant]:
    """Return the plants of the LPV+LFT form (28)-(32) for rho = 0 and rho = 1."""
    _, plants = uncertain_polytope(annex_model(), ("regime",), reading.unit)
    return [
        generalised_plant("speed", one.rates, LAG, reading.weights, uncertainty=one.uncertainty)
        for one in plants
    ]


def position(
    bandwidth: float = 20.0,
    disturbance: float = 0.1,
    drive: float = 0.05,
    *,
    box: Polytope | None = None,
    form: Form = "exact",
    margin: float = 0.5,
    static_error: float = 2 / 63,
    lag: float = LAG,
) -> list[GeneralisedPlant]:
    """Return the plants at the vertices (5.68) with the weights of 5.4.3.1, continuous.

    box: polytope of plants; None for the clutch of table 5.2.
    """
    weights = PlantWeights(template(bandwidth, margin, static_error), disturbance, drive)
    rates = vertex_rates(box or polytope(clutch_model()), form)
    return [generalised_plant("position", one, lag, weights) for one in rates]
