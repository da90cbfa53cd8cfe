"""The search for a certificate's cells ends, whatever the box."""

from __future__ import annotations

import pytest

from frictool.documents.certificate import Box
from frictool.synth.certificate_construction import (
    MOST_CELLS,
    Rectangle,
    _CellSearch,
    _outward,
    _TriedCell,
)
from frictool.verify.certificate_box import inverse_inertia, surroundings


class NothingHolds(_CellSearch):
    """A search in which the inequalities hold nowhere; cells without plants are empty, as they
    are."""

    def __init__(self, box: Box) -> None:
        drive, viscous = surroundings(box)
        self.box, self.whole, self.count = box, (_outward(drive), _outward(viscous)), 0

    def _tried(self, rates: Rectangle) -> _TriedCell:
        self.count += 1
        assert self.count < 10 * MOST_CELLS, "halved for ever"
        if inverse_inertia(self.box, *rates) is None:
            return _TriedCell(rates, float("inf"), empty=True)
        return _TriedCell(rates, -1.0)


@pytest.mark.parametrize("viscous", [(0.0, 0.0), (1e-5, 1e-5), (0.0, 1e-4)])
@pytest.mark.parametrize("constant", [(0.0134, 0.0134), (0.0128, 0.014)])
@pytest.mark.parametrize("inertia", [(1.3e-5, 1.3e-5), (1.1e-5, 1.5e-5)])
def test_it_ends_where_a_parameter_is_known_exactly(
    viscous: tuple[float, float], constant: tuple[float, float], inertia: tuple[float, float]
) -> None:
    search = NothingHolds(
        Box(inertia=inertia, viscous=viscous, coulomb=(0.1, 0.2), constant=constant)
    )
    assert search.cells() is None
