"""Speed limit that compliant links set on a simulation: against the modes of the mechanism."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from frictool.adapters.mechanism.assembly import assemble
from frictool.plant.mechanism.fastest_link import fastest_link
from frictool.plant.mechanism.linearisation import linearise
from tests.support.mechanism_documents import TRAIN, assembled
from tests.support.mechanism_text import mechanism

TWO = """\
format: mechanism/1
name: two
blocks:
  motor: {{inertia: {{value: {motor}, unit: kg m^2}}}}
  drum: {{inertia: {{value: {drum}, unit: kg m^2}}}}
  weight: {{mass: {{value: 2, unit: kg}}}}
links:
  gear:
    kind: gear
    between: [motor, drum]
    ratio: {ratio}
    compliance: {{stiffness: {{value: {stiffness}, unit: N m/rad}}, damping: {{value: {damping},
      unit: N m s/rad}}}}
  rope: {{kind: rack, between: [drum, weight], radius: {{value: 20, unit: mm}}}}
sources:
  drive: {{on: motor, drive: effort}}
"""
SIZES = st.floats(1e-5, 1e-2)


@given(SIZES, SIZES, st.floats(0.01, 10.0), st.floats(1.0, 1e6))
def test_of_one_link_that_yields_it_is_the_frequency_of_the_mode(
    motor: float, drum: float, ratio: float, stiffness: float
) -> None:
    """A rigid link's far end counts with it."""
    found = assemble(
        mechanism(TWO.format(motor=motor, drum=drum, ratio=ratio, stiffness=stiffness, damping=0.0))
    )
    (mode,) = linearise(found).modes()
    assert fastest_link(found).rate == pytest.approx(mode.frequency, rel=1e-6)
    assert fastest_link(found).link == "gear"


def test_what_settles_faster_than_it_rings_counts_by_its_damping() -> None:
    found = assemble(
        mechanism(TWO.format(motor=1e-4, drum=1e-4, ratio=1.0, stiffness=1.0, damping=100.0))
    )
    assert fastest_link(found).rate == pytest.approx(
        100.0 * (1.0 / 1e-4 + 1.0 / (1e-4 + 2 * 0.02**2))
    )


def test_a_spring_to_the_frame_yields_against_all_that_it_holds(tmp_path: Path) -> None:
    """The cart's play stands between it and the motor: it rings alone."""
    assert fastest_link(assembled(TRAIN, tmp_path)).rate == pytest.approx((2000.0 / 0.5) ** 0.5)
