"""A campaign and the test of a design simulate breakaways that a controller cannot overcome."""

from __future__ import annotations

import numpy as np
import pytest
from msgspec.structs import replace

from frictool.campaign import ControllerJudge
from frictool.campaign.design_trial import design_test
from frictool.campaign.draws.sampling import draws_of
from frictool.campaign.trials.trial_player import CampaignSetting, TrialPlayer, metrics_of
from frictool.campaign.trials.trials import BROKEN
from frictool.campaign.trials.varied_space import space_of_setting
from frictool.documents.model import Model
from frictool.documents.quantity import Quantity
from frictool.simulate.document_agreement import DocumentNames
from studies.rigs.clutch_model import clutch_model
from studies.rigs.step_logs import clutch_spec
from studies.rigs.step_scenario import controller, scenario
from studies.rigs.verified_controller import truthful

SPEC = clutch_spec(rest=None)
STEP, COUNT = 35.0, 0.12  # rad: step from 5 to 40 rad, and encoder count
LARGEST = 1.0  # N m, upper end of the breakaway; the drive gives 0.64 to 0.70 N m at its limit


def stuck_model() -> Model:
    """Return the clutch with a breakaway that the drive does not overcome at the upper end.

    It has no backlash, in which the motor would gain speed."""
    model = clutch_model()
    known = Quantity(value=0.11, low=0.02, high=LARGEST, unit="N m")
    mechanics = replace(model.bench.mechanics, backlash=None, backlash_coulomb=None)
    bench = replace(model.bench, mechanics=replace(mechanics, breakaway=known))
    return replace(model, bench=bench)


def test_a_campaign_fails_where_the_drive_does_not_overcome_the_breakaway() -> None:
    setting = CampaignSetting(
        stuck_model(),
        truthful(controller()),
        scenario(40.0),
        SPEC,
        None,
        DocumentNames(),
        "double",
    )
    space = space_of_setting(setting)
    assert "breakaway" in space.names
    units = draws_of("random", 60, space.size, 1).units
    values = dict(zip(space.names, space.values(units).T, strict=True))
    player = TrialPlayer(setting, space, 1)
    stuck = values["breakaway"] > 50.0 * values["constant"] + np.abs(values.get("offset", 0.0))
    assert 10 < np.sum(stuck) < 50
    names = [one.key for one in metrics_of(player.nominal())]
    for draw in np.flatnonzero(stuck):
        trial = player.played(units[draw], int(draw))
        assert trial.met[names.index("static_error")] == BROKEN
        assert trial.metric_values[names.index("static_error")] == pytest.approx(STEP, abs=COUNT)


def test_the_test_of_a_design_fails_at_the_upper_end_of_the_breakaway() -> None:
    test = design_test(stuck_model(), SPEC, scenario(40.0))
    largest = ControllerJudge(test.model, test.scenario, SPEC, test.plants)(
        truthful(controller()), only=range(1, 1 + test.vertices)
    )
    column = [one.key for one in largest.metrics].index("static_error")
    np.testing.assert_allclose(largest.values[:, column], STEP, atol=COUNT)
    assert not largest.passed
