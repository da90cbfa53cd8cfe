"""Stored trials: a mapping in arrays, whose size does not grow with what a result contains."""

from __future__ import annotations

import math
import tracemalloc

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from frictool.campaign.trials.stored_trials import MOST_DRAWS, StoredTrials
from frictool.campaign.trials.trial_sharing import DrawJobs
from frictool.campaign.trials.trials import BROKEN, MET, TrialResult

RESULTS = st.builds(
    lambda draw, value, failed: (
        TrialResult(draw, (), (), "no plant")
        if failed
        else TrialResult(draw, (value, math.inf), (MET, BROKEN))
    ),
    st.integers(0, 40),
    st.floats(allow_nan=False),
    st.booleans(),
)


@given(st.lists(RESULTS))
def test_it_is_a_dict_in_the_order_of_the_draws(results: list[TrialResult]) -> None:
    stored, plain = StoredTrials(), dict[int, TrialResult]()
    for one in results:
        stored[one.draw] = plain[one.draw] = one
    assert list(stored.items()) == sorted(plain.items())
    assert len(stored) == len(plain)
    for draw in list(plain)[::2]:
        del stored[draw], plain[draw]
    assert dict(stored) == plain
    assert 41 not in stored


@pytest.mark.parametrize("draw", [-1, MOST_DRAWS])
def test_an_index_that_no_campaign_has_is_an_error(draw: int) -> None:
    with pytest.raises(IndexError, match="allowed"):
        StoredTrials()[draw] = TrialResult(draw, (1.0,), (MET,))


def test_a_trial_takes_a_hundred_bytes_and_a_waiting_job_eight() -> None:
    tracemalloc.start()
    stored = StoredTrials()
    for draw in range(20_000):
        stored[draw] = TrialResult(draw, (0.5 + draw,) * 7, (MET,) * 7)
    units = np.zeros((20_000, 13))
    before = tracemalloc.get_traced_memory()[0]
    jobs = DrawJobs(units, np.arange(20_000))
    assert sum(1 for _ in jobs) == len(jobs)
    size = tracemalloc.get_traced_memory()[0]
    tracemalloc.stop()
    assert size - before < 20_000 * 10
    assert before - units.nbytes < 20_000 * 200
    assert jobs[7] == (7, (0.0,) * 13)
