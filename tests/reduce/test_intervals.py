"""Intervals of a mechanism's quantities through a reduction: every plant that the file allows lies
within."""

from __future__ import annotations

import itertools

import pytest

from frictool.documents.mechanism import Block, FrictionOf, Mechanism, Source
from frictool.documents.quantity import Quantity
from frictool.reduce.interval_propagation import at, propagated

BRUSHES = ("links", "brushes", "parameters")


def described(count: int) -> Mechanism:
    """One friction whose intervals of slip and of rest cross, and `count` inertias that are
    uncertain too."""
    parameters = {
        "coulomb": Quantity(50.0, 30.0, 70.0, "mN m"),
        "breakaway": Quantity(0.055, 0.033, 0.077, "N m"),
        "viscous": Quantity(0.0, unit="N m s/rad"),
    }
    blocks = {f"b{k}": Block(inertia=Quantity(2.0, 1.0, 3.0, "kg m^2")) for k in range(count)}
    return Mechanism(
        "mechanism/1",
        "crossing",
        blocks,
        links={"brushes": FrictionOf("b0", "svc", parameters)},
        sources={"push": Source("b0", "effort")},
    )


def numbers(mechanism: Mechanism) -> dict[str, float]:
    brushes = mechanism.links["brushes"]
    assert isinstance(brushes, FrictionOf)
    of = {
        name: one.value * (1e-3 if one.unit == "mN m" else 1.0)
        for name, one in brushes.parameters.items()
    }
    assert of["breakaway"] >= of["coulomb"]
    inertia = sum(
        block.inertia.value for block in mechanism.blocks.values() if block.inertia is not None
    )
    return {"inertia": inertia, "coulomb": of["coulomb"], "breakaway": of["breakaway"]}


@pytest.mark.parametrize("count", [1, 2, 4])
def test_slip_and_rest_of_one_part_reach_their_ends_and_no_farther(count: int) -> None:
    found = propagated(described(count), numbers, lambda _: None)
    assert found["coulomb"] == pytest.approx((0.03, 0.07))
    assert found["breakaway"] == pytest.approx((0.033, 0.077))
    assert found["inertia"] == pytest.approx((count, 3 * count))


def test_every_plant_of_the_file_is_within() -> None:
    found = propagated(described(4), numbers, lambda _: None)
    for slip, rest in itertools.product((30.0, 45.0, 70.0), (0.033, 0.05, 0.077)):
        if rest < 1e-3 * slip:
            continue
        drawn = at(at(described(4), (*BRUSHES, "coulomb"), slip), (*BRUSHES, "breakaway"), rest)
        for name, value in numbers(drawn).items():
            low, high = found[name]
            assert low - 1e-12 <= value <= high + 1e-12, name
