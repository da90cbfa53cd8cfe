"""Texts for delays, margins and plants in messages."""

from __future__ import annotations

import math

from frictool.documents.bench import Bench
from frictool.documents.controller import Vertex
from frictool.documents.quantity import si_unit
from frictool.plant.polytope import PlantPoint

NOT_CERTIFIED = (
    "this loop feeds back the speed of an observer, for which there is no certificate; `verify` "
    "computes its margins again"
)


def delay_words(samples: int) -> str:
    """Return a delay in words.

    >>> delay_words(0), delay_words(1)
    ('0 samples of delay', '1 sample of delay')
    """
    return f"{samples} sample{'' if samples == 1 else 's'} of delay"


def rounded_down(margin: float) -> str:
    """Return a proved margin rounded down to four digits.

    >>> rounded_down(0.62559)
    '0.6255'
    """
    return f"{math.floor(1e4 * margin) / 1e4:.4f}"


def plant_units(bench: Bench) -> dict[str, str]:
    """Return the SI units of inertia, viscous and Coulomb friction, and the drive's constant."""
    mechanical = {"inertia": "inertia", "viscous": "viscous", "coulomb": "effort"}
    units = {name: si_unit(dimension, bench.axis) for name, dimension in mechanical.items()}
    return units | {"constant": bench.actuator.constant.unit}


def plant_words(plant: PlantPoint | Vertex, bench: Bench) -> str:
    """Return the parameters of a plant as text: inertia 1.11e-05 kg m^2, viscous 0 N m s/rad ..."""
    return ", ".join(
        f"{name} {getattr(plant, name):.4g} {unit}" for name, unit in plant_units(bench).items()
    )
