"""Units of SI symbols are compared without pint; pint is the reference."""

from __future__ import annotations

import pytest

from frictool.documents.quantity import SI_UNITS, dimension_of, unit_scale

WRITTEN = sorted({unit for pair in SI_UNITS.values() for unit in pair} | {"N s", "kg m/s^2", "1"})


@pytest.mark.parametrize("unit", WRITTEN)
def test_units_of_another_dimension_are_refused_as_by_pint(unit: str) -> None:
    for dimension, (target, _) in SI_UNITS.items():
        if dimension_of(unit) != dimension_of(target):
            with pytest.raises(ValueError, match="does not measure"):
                unit_scale(unit, dimension, "rotary")
        elif "rad" in unit or "rad" not in target:
            assert unit_scale(unit, dimension, "rotary").factor == pytest.approx(1.0, rel=1e-15)
