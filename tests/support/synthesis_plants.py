"""Plants that the tests of the inequalities share: random ones of both domains, and the
clutch's."""

from __future__ import annotations

import numpy as np

from frictool.adapters.model_polytope import polytope
from frictool.plant.generalised_plant import (
    FirstOrderWeight,
    GeneralisedPlant,
    PlantWeights,
    generalised_plant,
    template,
)
from studies.rigs.clutch_model import clutch_model

LAG, PERIOD = 0.003, 1e-3


def random_plant(seed: int, n: int = 3, *, sampled: bool = True) -> GeneralisedPlant:
    """Unstable in open loop; every state is disturbed and judged, command and measurement are
    weighed."""
    random = np.random.default_rng(seed)
    a = random.normal(size=(n, n))
    a *= 1.1 / np.max(np.abs(np.linalg.eigvals(a)))
    if not sampled:
        a += 0.2 * np.eye(n)
    b1 = np.hstack([0.5 * np.eye(n), np.zeros((n, 1))])
    c1 = np.vstack([0.5 * np.eye(n), np.zeros((1, n))])
    d12, d21 = np.vstack([np.zeros((n, 1)), [[0.5]]]), np.hstack([np.zeros((1, n)), [[0.5]]])
    b2, c2 = random.normal(size=(n, 1)), random.normal(size=(1, n))
    return GeneralisedPlant(
        a, b1, b2, c1, c2, np.zeros((n + 1, n + 1)), d12, d21, 1.0 if sampled else 0.0
    )


def random_polytope(
    seed: int, vertices: int, n: int = 3, *, sampled: bool = True, spread: float = 0.1
) -> list[GeneralisedPlant]:
    """Plants that differ in A, B1, C1 and D11 by random steps of the size `spread`."""
    random, middle = np.random.default_rng([seed, vertices]), random_plant(seed, n, sampled=sampled)
    return [
        GeneralisedPlant(
            *(
                getattr(middle, name)
                + (
                    spread * random.normal(size=getattr(middle, name).shape)
                    if name in ("a", "b1", "c1", "d11")
                    else 0.0
                )
                for name in ("a", "b1", "b2", "c1", "c2", "d11", "d12", "d21")
            ),
            middle.period,
        )
        for _ in range(vertices)
    ]


def between(plants: list[GeneralisedPlant], weights: np.ndarray) -> GeneralisedPlant:
    """The barycentric sum of plants, (5.45)."""
    parts = ("a", "b1", "b2", "c1", "c2", "d11", "d12", "d21")
    return GeneralisedPlant(
        *(
            sum(
                weight * getattr(plant, name) for weight, plant in zip(weights, plants, strict=True)
            )
            for name in parts
        ),
        plants[0].period,
    )


def clutch_speed(vertices: slice = slice(None)) -> list[GeneralisedPlant]:
    """The centre and the vertices of the speed loop at 1 ms with one sample of delay."""
    weights, box = (
        PlantWeights(template(40.0, 0.5, 2 / 63), 0.03, 0.5, 0.5, FirstOrderWeight(0.01)),
        polytope(clutch_model()),
    )
    return [
        generalised_plant("speed", point.rates, LAG, weights, PERIOD, 1)
        for point in (box.centre, *box.vertices[vertices])
    ]
