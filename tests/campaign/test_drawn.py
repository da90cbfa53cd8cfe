"""A draw as a scenario: each factor at its place, the ends at the ends, the file the same as the
scenario."""

from __future__ import annotations

import math
from pathlib import Path

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.campaign.draws.drawn_scenario import nominal_of, scenario_of
from frictool.campaign.draws.factor_space import FactorSpace, space_of
from frictool.campaign.draws.spread_factors import spread_factors
from frictool.documents.conditions import DriftPoint
from frictool.documents.quantity import Quantity, Span
from frictool.documents.registry import load
from frictool.documents.scenario import Scenario
from frictool.documents.spread import (
    CountBand,
    FactorBand,
    InstantBand,
    Spread,
    SpreadFault,
    Temperature,
    Warmth,
)
from frictool.documents.writing import to_yaml
from studies.rigs.campaign_rig import EVERYTHING, SLOW_WEAR, played, trial
from studies.rigs.step_logs import ENCODER_STEP
from tests.support.campaign_trials import factors

SPREAD_SIZE = 15  # of EVERYTHING
TRIAL = trial()


def at(base: Scenario, **values: float) -> Scenario:
    """The scenario with each factor in the middle, but for those given by what their names end
    in."""
    space = space_of(spread_factors(base))
    chosen = [
        next((v for end, v in values.items() if f.name.endswith(end)), 0.5 * (f.low + f.high))
        for f in space.factors
    ]
    return scenario_of(base, space, np.array(chosen), (0, 0), ENCODER_STEP)


def test_everything_that_is_spread_is_a_factor() -> None:
    names = space_of(spread_factors(played(EVERYTHING))).names
    assert len(names) == len(set(names)) == SPREAD_SIZE
    assert all(name.startswith("spread.") for name in names)


def test_a_range_of_one_value_is_that_value() -> None:
    spread = Spread(parameters={"inertia": Span(2e-5, 2e-5, "kg m^2")}, wear=FactorBand(1.0, 1.5))
    assert at(played(spread)).given == {"inertia": Quantity(value=2e-5, unit="kg m^2")}


def test_wear_and_temperature_are_factors_throughout() -> None:
    spread = Spread(
        wear=FactorBand(1.0, 1.5),
        temperature=Temperature(Warmth(viscous=1.4), Warmth(viscous=0.6, constant=0.9)),
    )
    drawn = at(played(spread), wear=1.25, temperature=0.75)
    assert drawn.drifts.friction == (DriftPoint(0.0, 1.25),)
    assert drawn.drifts.viscous[0].factor == pytest.approx(0.8)
    assert drawn.drifts.constant[0].factor == pytest.approx(0.925)
    slow = at(played(spread, drifts=SLOW_WEAR), wear=1.5)
    assert [(point.at_s, point.factor) for point in slow.drifts.friction] == [
        (0.0, 1.5),
        (0.5, pytest.approx(1.8)),
    ]


def test_the_start_is_drawn_and_so_is_its_place_within_the_count() -> None:
    assert at(played(Spread(start=Span(2.0, 9.0, "rad"))), start=3.5).start.value == 3.5
    for part in (0.0, 0.25, 0.999):
        place = at(played(Spread(within_count=True)), within_count=part).start.value / ENCODER_STEP
        assert place == pytest.approx(math.floor(5.0 / ENCODER_STEP) + part)


def test_a_fault_of_no_counts_is_none() -> None:
    spread = Spread(
        sensor_faults=(SpreadFault("lost_counts", InstantBand(0.1, 0.1), counts=CountBand(-1, 1)),)
    )
    assert at(played(spread), counts=0.0).sensor_faults == ()
    (fault,) = at(played(spread), counts=-1.0).sensor_faults
    assert (fault.counts, fault.at_s, fault.until_s) == (-1, 0.1, None)


@settings(max_examples=20)
@given(
    st.lists(st.floats(0.0, 1.0), min_size=SPREAD_SIZE + 5, max_size=SPREAD_SIZE + 5),
    st.integers(0, 10**6),
)
def test_a_drawn_scenario_survives_its_file_to_the_last_bit(
    tmp_path_factory: pytest.TempPathFactory, unit: list[float], draw: int
) -> None:
    drawn = TRIAL.scenario(np.array(unit), draw)
    path = tmp_path_factory.getbasetemp() / "drawn.yaml"
    path.write_text(to_yaml(drawn))
    assert load(path, Scenario) == drawn


def test_the_nominal_scenario_is_the_file_without_what_varies() -> None:
    base = played(EVERYTHING, variants="random", plants=3)
    assert nominal_of(base) == msgspec.structs.replace(played(), variants="nominal")


def test_noise_is_of_the_draw_and_without_noise_the_seed_stays() -> None:
    space = FactorSpace(factors(1).factors)
    values = np.array([0.5])
    seeds = {scenario_of(played(), space, values, (0, draw), 0.1).seed for draw in range(10)}
    assert len(seeds) == 10
    quiet = msgspec.structs.replace(played(), drive_noise=0.0)
    assert scenario_of(quiet, space, values, (0, 7), 0.1).seed == quiet.seed


def test_ends_of_bands_are_in_order(tmp_path: Path) -> None:
    for wrong in (
        lambda: FactorBand(1.5, 1.0),
        lambda: CountBand(2, -2),
        lambda: InstantBand(1.0, 0.5),
    ):
        with pytest.raises(ValueError, match="allowed: low <= high"):
            wrong()
