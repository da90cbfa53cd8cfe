"""Report of a run that ends at rest."""

from __future__ import annotations

import numpy as np

from frictool.cli.simulate_summary import _rests


def test_what_rounding_leaves_of_an_oscillation_is_rest() -> None:
    t = np.linspace(0.0, 10.0, 1001)
    ringing = np.exp(-4.0 * t) * np.sin(30.0 * t)
    assert _rests(ringing)
    assert not _rests(ringing + 1e-6)
    assert not _rests(np.exp(-0.5 * t))
    assert _rests(np.zeros(5))
