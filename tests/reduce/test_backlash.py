"""Play brought to the actuator and to the sensor, several in a chain, and what lies inside."""

from __future__ import annotations

from pathlib import Path

import msgspec
import numpy as np
import pytest

from frictool.documents.mechanism import Mechanism
from frictool.documents.registry import load
from frictool.errors import NoSolutionError
from frictool.reduce.reduction_chain import chain
from tests.support.small_mechanisms import two_plays

CLUTCH = Path(__file__).parents[2] / "configs" / "clutch" / "mechanism.yaml"


def test_the_clutch_has_three_radians_at_the_rotor_and_below_0_7_mm_at_the_cart() -> None:
    figures = {figure.name: figure for figure in chain(load(CLUTCH, Mechanism), None).play}
    assert figures["rack: at the actuator"].value == pytest.approx(3.0, rel=1e-12)
    assert figures["rack: at the sensor"].value == pytest.approx(3.0, rel=1e-12)
    assert figures["rack: at cart"].value == pytest.approx(3.0 * 0.20414e-3, rel=1e-12)
    assert figures["rack: at cart"].value < 0.7e-3
    assert figures["rack: at cart"].unit == "m"


def test_plays_in_a_chain_add_by_their_ratios() -> None:
    found = chain(two_plays(first=0.02, second=1e-4), None).one
    # behind a gear of 1/5 and a rack of 10 mm: 0.02 rad * 5 and 0.1 mm / (2 mm/rad)
    np.testing.assert_allclose(found.play.width, 0.02 * 5.0 + 1e-4 / (0.01 * 0.2), rtol=1e-12)
    assert [link.name for link in found.play.chain] == ["gear", "rack"]
    # inside it the brushes alone; closed, the friction of all three by their ratios
    np.testing.assert_allclose(found.inside, 0.02, rtol=1e-12)
    np.testing.assert_allclose(
        found.forward.curve, 0.02 + 0.05 * 0.2 + 8.0 * 0.01 * 0.2, rtol=1e-12
    )
    np.testing.assert_allclose(found.inner, 2e-5, rtol=1e-12)
    np.testing.assert_allclose(
        found.inertia, 2e-5 + 1e-4 * 0.2**2 + 0.5 * (0.01 * 0.2) ** 2, rtol=1e-12
    )


def test_a_sensor_behind_a_play_is_refused_with_its_width() -> None:
    whole = two_plays()
    behind = msgspec.structs.replace(
        whole,
        sensors={"encoder": msgspec.structs.replace(whole.sensors["encoder"], on="shaft")},
        travel=None,
    )
    with pytest.raises(NoSolutionError, match=r"sensors\.encoder: 0\.02 rad of backlash \(gear\)"):
        chain(behind, None)
