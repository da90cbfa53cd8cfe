"""Regions of closed-loop poles: every pole is inside, the norm keeps gamma, and a region that
cannot be is refused with its reason."""

from __future__ import annotations

import numpy as np
import pytest

from frictool.errors import NoSolutionError
from frictool.lmi.hinf_synthesis import PoleDisc, PoleHalfPlane, controller, minimise
from frictool.plant.generalised_plant import GeneralisedPlant
from frictool.verify.hinf_norm import norm
from studies.rigs.published_plants import position
from tests.support.synthesis_plants import clutch_speed, random_plant

NEAR_THE_ORIGIN = 1e-12


def closed_poles(
    plant: GeneralisedPlant, region: PoleHalfPlane | PoleDisc | None
) -> tuple[np.ndarray, float, float, float]:
    """Closed-loop poles, true norm, gamma and the optimum."""
    found = minimise([plant], 1.05, region)
    loop = plant.closed(controller(plant, found))
    return np.linalg.eigvals(loop.a), norm(loop)[0], found.gamma, found.optimum


@pytest.mark.parametrize("seed", range(4))
def test_half_plane(seed: int) -> None:
    plant = random_plant(seed, sampled=False)
    _, _, _, free = closed_poles(plant, None)
    poles, reached, gamma, optimum = closed_poles(plant, PoleHalfPlane(0.8))
    assert np.max(poles.real) < -0.8
    assert reached <= gamma
    assert optimum >= free * (1.0 - 1e-3)  # a restriction costs


@pytest.mark.parametrize("seed", range(4))
def test_disc_in_continuous_time_bounds_the_fast_poles(seed: int) -> None:
    plant = random_plant(seed, sampled=False)
    disc = PoleDisc(-10.0, 10.0)
    poles, reached, gamma, _ = closed_poles(plant, disc)
    assert np.max(np.abs(poles - disc.centre)) < disc.radius
    assert reached <= gamma


@pytest.mark.parametrize("seed", range(4))
def test_disc_in_discrete_time(seed: int) -> None:
    plant = random_plant(seed, sampled=True)
    poles, reached, gamma, _ = closed_poles(plant, PoleDisc(0.1, 0.8))
    assert np.max(np.abs(poles - 0.1)) < 0.8
    assert reached <= gamma


def test_the_whole_unit_disc_is_no_restriction() -> None:
    plant = random_plant(2, sampled=True)
    assert minimise([plant], 1.05, PoleDisc(0.0, 1.0)).optimum == pytest.approx(
        minimise([plant], 1.05).optimum, rel=1e-6
    )


def test_a_disc_cures_the_fast_poles_of_the_position_loop() -> None:
    """D12 = 0: the free optimum is not attained and its controllers are fast. A disc of 4000 rad/s
    costs some gamma."""
    plants = position()[::5]
    free, held = minimise(plants, 1.05), minimise(plants, 1.05, PoleDisc(-2000.0, 2000.0))
    fastest = [
        float(np.max(np.abs(np.linalg.eigvals(controller(plants[0], found).a))))
        for found in (free, held)
    ]
    assert fastest[0] > 4000.0 > fastest[1]
    assert held.optimum < 1.5 * free.optimum
    for plant in plants:
        loop = plant.closed(controller(plant, held))
        assert norm(loop)[0] <= held.gamma
        assert np.max(np.abs(np.linalg.eigvals(loop.a) + 2000.0)) < 2000.0 * (1.0 + NEAR_THE_ORIGIN)


def test_a_disc_has_to_contain_the_poles_of_the_weights() -> None:
    """W2 has its pole at 0.317 rad/s, the drive its own at 333 rad/s."""
    plants = position()[:1]
    with pytest.raises(
        NoSolutionError,
        match=r"pole at -0\.3175 is not observable in the measurement.*weights.*region",
    ):
        minimise(plants, 1.05, PoleDisc(-1001.0, 1000.0))


@pytest.mark.parametrize(
    ("plants", "region", "said"),
    [
        (position()[:1], PoleDisc(-10.0, 11.0), "left half-plane"),
        (position()[:1], PoleDisc(-10.0, 0.0), "left half-plane"),
        (position()[:1], PoleHalfPlane(-1.0), "decay of 0"),
        (clutch_speed(slice(0, 0)), PoleDisc(0.5, 0.6), "unit disc"),
        (clutch_speed(slice(0, 0)), PoleHalfPlane(1.0), "continuous time"),
    ],
)
def test_a_region_outside_the_region_of_stability_is_refused(
    plants: list[GeneralisedPlant], region: PoleHalfPlane | PoleDisc, said: str
) -> None:
    with pytest.raises(ValueError, match=said):
        minimise(plants, 1.05, region)
