"""The uncertainty channel: annex (20)-(23) and (28)-(29)."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from frictool.adapters.model_polytope import (
    default_unit,
    half_widths,
    polytope,
    uncertain_centre,
    uncertain_polytope,
)
from frictool.adapters.parameter_intervals import intervals
from frictool.plant.polytope import PlantPoint
from frictool.plant.uncertainty_channel import with_channel
from studies.rigs.annex_model import annex_model
from studies.rigs.clutch_model import clutch_model

CENTRE = PlantPoint("centre", 1.32e-5, 3.8e-4, 0.1, 0.0134)


@given(
    share=st.floats(-1.0, 1.0),
    unit=st.floats(1e-3, 10.0),
    widths=st.tuples(*[st.floats(0.0, 0.3)] * 4),
)
def test_closing_the_channel_moves_the_plant_to_first_order(
    share: float, unit: float, widths: tuple[float, ...]
) -> None:
    """w_d = Delta z_d is the plant with every parameter moved by Delta times its half-width, but
    for products of deviations (20)-(21)."""
    values = (CENTRE.inertia, CENTRE.viscous, CENTRE.coulomb, CENTRE.constant)
    small = 1e-4
    wide = {
        name: small * w * v
        for name, w, v in zip(
            ("inertia", "viscous", "coulomb", "constant"), widths, values, strict=True
        )
    }
    found = with_channel(CENTRE, wide, unit)
    moved = PlantPoint(
        "p", *(v + share * w for v, w in zip(values, wide.values(), strict=True))
    ).rates
    closed = share * found.rates.push
    assert found.rates.drive + closed * found.uncertainty.drive == pytest.approx(
        moved.drive, rel=1e-7
    )
    assert -found.rates.viscous + closed * found.uncertainty.viscous == pytest.approx(
        -moved.viscous, rel=1e-7
    )
    assert -found.rates.friction + closed * found.uncertainty.friction == pytest.approx(
        -moved.friction, rel=1e-7
    )


def test_the_unit_does_not_change_what_the_channel_does() -> None:
    one, other = (
        with_channel(CENTRE, {"inertia": 2e-6, "coulomb": 0.027}, unit) for unit in (0.0318, 0.027)
    )
    assert one.rates.push * one.uncertainty.drive == pytest.approx(
        other.rates.push * other.uncertainty.drive
    )
    assert one.uncertainty.drive != other.uncertainty.drive


def test_annex_22_and_29_with_the_numbers_of_table_2() -> None:
    lft = uncertain_centre(annex_model())
    assert lft.unit == pytest.approx(0.027)
    assert lft.rates.push == pytest.approx(0.027 / 1.32e-5)
    assert lft.uncertainty.friction == pytest.approx((2.1e-6 * 0.1 / 1.32e-5 - 0.027) / 0.027)
    assert lft.uncertainty.viscous == pytest.approx((2.1e-6 * 3.8e-4 / 1.32e-5 - 3.8e-4) / 0.027)
    assert lft.uncertainty.drive == pytest.approx((1.2e-3 - 2.1e-6 * 13.4e-3 / 1.32e-5) / 0.027)
    box, (slow, fast) = uncertain_polytope(annex_model(), ("regime",))
    assert box.vertices == (slow.point, fast.point)
    assert slow.uncertainty.viscous == 0.0
    assert slow.uncertainty.friction == pytest.approx(2.1e-6 * 0.127 / 1.32e-5 / 0.027)
    assert fast.uncertainty.friction == pytest.approx(
        2.1e-6 * (0.127 - 7.6e-4 * 260.0) / 1.32e-5 / 0.027
    )


def test_what_is_scheduled_leaves_the_channel() -> None:
    model = clutch_model()
    _, plants = uncertain_polytope(model, ("inertia", "constant"))
    assert len(plants) == 4
    assert all(plant.uncertainty.drive == 0.0 for plant in plants)
    assert all(
        plant.uncertainty.viscous * plant.unit == pytest.approx(-half_widths(model)["viscous"])
        for plant in plants
    )


def test_the_unit_where_the_coulomb_friction_is_certain() -> None:
    sure = clutch_model(coulomb=(0.099, 0.099, 0.099))
    assert default_unit(clutch_model()) == pytest.approx(0.081)
    low, high = intervals(sure)["coulomb"]
    assert high > low  # the bench's range over the product's life is still there
    assert np.isfinite(default_unit(sure))
    with pytest.raises(ValueError, match="unit of the uncertainty channel"):
        with_channel(polytope(sure).centre, {}, 0.0)
