"""Models of `warm_axes`: with the true friction over temperature, or with a slightly wrong one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from frictool.documents.laws import FrictionOverTemperature, Laws, TemperatureChange
from frictool.documents.model import Model, Parameters
from frictool.documents.quantity import Estimate, Quantity, Span
from frictool.observe.motion_block import MotionBlock
from frictool.observe.wear.wear_estimator import WearEstimator
from frictool.observe.wear_estimate import WearEstimate
from tests.support.provenance import HERE
from tests.support.warm_axes import COLD, HOT, WarmAxis

REFERENCE = 55.0  # degC
WIDTH = 1.96  # standard deviations in half an interval of 95 %


def warm_model(
    axis: WarmAxis, deviations: tuple[float, float] = (0.0, 0.0), seed: int | None = None
) -> Model:
    """Return the model of an unworn axis at REFERENCE, with the law of Reynolds.

    deviations: standard deviations of the slopes of viscous and Coulomb friction, 1/K; with a
    `seed`, the slopes are wrong by a random error of this size.
    """
    new = replace(axis.truth, wear=1.0)
    draw = np.random.default_rng([0 if seed is None else seed, 43]).standard_normal(2)
    errors = np.zeros(2) if seed is None else draw * deviations
    true = (np.log(0.5) / (HOT - COLD), -new.fall * new.coulomb_cold / new.coulomb(REFERENCE))
    viscous, coulomb = (
        TemperatureChange(_estimate(slope + error, "1/K", WIDTH * deviation))
        for slope, error, deviation in zip(true, errors, deviations, strict=True)
    )
    law = FrictionOverTemperature(
        Quantity(REFERENCE, unit="degC"), Span(COLD, HOT, "degC"), viscous, coulomb
    )
    level = new.coulomb(REFERENCE)
    return Model(
        format="model/1",
        name="warm",
        axis="rotary",
        law="coulomb",
        method="least-squares",
        confidence=0.95,
        bench=axis.bench,
        parameters=Parameters(
            inertia=_estimate(new.inertia, "kg m^2"),
            viscous=_estimate(new.viscous(REFERENCE), "N m s/rad"),
            coulomb=_estimate(level, "N m"),
            breakaway=_estimate(1.1 * level, "N m"),
            offset=_estimate(new.offset, "N m"),
        ),
        provenance=HERE,
        laws=Laws(temperature=law),
    )


def _estimate(value: object, unit: str, half: float = 0.0) -> Estimate:
    number = float(np.asarray(value))
    return Estimate(number, number - half, number + half, unit, source="identified")


def wear_of(model: Model, axis: WarmAxis, temperature: bool = True) -> WearEstimate:
    """Return the wear estimated from the first log of an axis; without its `temperature` if so."""
    record = axis.records[0]
    signal = record.temperature if temperature else None
    warm = None if signal is None else signal.values
    estimator = WearEstimator(model)
    block = MotionBlock(record.time, record.position, record.effort, False, None, warm)
    return [*estimator.take(block), *estimator.finish()][-1]
