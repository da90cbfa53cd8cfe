"""The published problems, a subset of tests/accept/check_annex.py."""

from __future__ import annotations

import numpy as np
import pytest

from frictool.adapters.model_polytope import uncertain_polytope
from frictool.lmi.hinf_synthesis import minimise, vertex_controllers
from frictool.plant.lti import tustin
from frictool.verify.hinf_norm import norm
from frictool.verify.speed_loop import check_loop
from studies.rigs.annex_model import annex_model
from studies.rigs.published_plants import LAG, READINGS, annex_lft, annex_mixed, position


@pytest.mark.parametrize("name", READINGS)
def test_annex_c_within_one_per_cent(name: str) -> None:
    reading = READINGS[name]
    assert minimise([annex_lft(reading)], 1.05).optimum == pytest.approx(reading.lft, rel=0.01)
    assert minimise(annex_mixed(reading), 1.05).optimum == pytest.approx(reading.mixed, rel=0.01)


@pytest.mark.parametrize(
    ("disturbance", "drive", "known"), [(1.0, 1.26, 27.15), (0.1, 0.05, 0.912)]
)
def test_position_within_one_per_cent(disturbance: float, drive: float, known: float) -> None:
    assert minimise(position(20.0, disturbance, drive), 1.05).optimum == pytest.approx(
        known, rel=0.01
    )


def test_the_annex_controllers_agree_below_1_khz_and_are_unstable_sampled() -> None:
    reading = READINGS["W4 = G4, W5 = 1, d = half-width of F_c"]
    plants = annex_mixed(reading)
    lyapunov = minimise(plants, 1.1)
    slow, fast = vertex_controllers(plants, lyapunov)
    frequencies = 2.0 * np.pi * np.geomspace(1e-2, 1e3, 300)
    assert np.max(np.abs(fast.response(frequencies) / slow.response(frequencies) - 1.0)) < 0.04
    _, uncertain = uncertain_polytope(annex_model(), ("regime",), reading.unit)
    for plant, posed, k in zip(uncertain, plants, (slow, fast), strict=True):
        assert norm(posed.closed(k))[0] <= 1.01 * lyapunov.gamma
        assert check_loop(tustin(k, 1e-3), plant.rates, LAG, 0).spectral_radius > 1.5
