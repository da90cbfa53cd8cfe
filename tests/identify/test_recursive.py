"""Recursive least squares by Givens rotations: against least squares on all rows so far, weighted
by how old they are."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.identify.estimators.recursive import givens_path, path
from frictool.identify.methods import IdentificationSettings, run
from frictool.identify.rows.slip_fit import SMALLEST_SHARE, slipping
from studies.rigs.identification_rigs import clutch, record
from studies.rigs.sample_logs import TRUTH, sines


@settings(derandomize=True, deadline=None, max_examples=30)
@given(seed=st.integers(0, 10_000), count=st.integers(5, 60), forgetting=st.floats(0.8, 1.0))
def test_every_value_is_that_of_least_squares(seed: int, count: int, forgetting: float) -> None:
    draw = np.random.default_rng(seed)
    rows = draw.normal(size=(count, 4))
    found, root = np.empty((count, 3)), np.sqrt(forgetting)
    givens_path(rows, root, found)
    assert np.isnan(found[:2]).all()
    for k in range(3, count):
        weight = root ** np.arange(k, -1, -1.0)
        plain = np.linalg.lstsq(
            rows[: k + 1, :3] * weight[:, None], rows[: k + 1, 3] * weight, rcond=None
        )[0]
        assert found[k] == pytest.approx(plain, rel=1e-6, abs=1e-8)


def test_the_path_ends_where_the_method_does() -> None:
    log = record(sines(5))
    window = 51
    samples, _ = slipping([log], clutch(), SMALLEST_SHARE, window)
    end = path(samples, 0.95)[-1]
    fit = run("recursive", [log], clutch(), IdentificationSettings(window=window, forgetting=0.95))
    for name, value in zip(("inertia", "viscous", "coulomb", "offset"), end, strict=True):
        if name in fit.parameters:
            assert fit.parameters[name].value == pytest.approx(value, rel=1e-9)


def test_forgetting_follows_a_friction_that_drifts() -> None:
    """Coulomb friction 10 % higher in the second of two logs: least squares gives their mean,
    forgetting the second."""
    logs = [
        record(sines(seed, TRUTH._replace(coulomb=value)))
        for seed, value in ((1, 0.099), (2, 0.109))
    ]
    values = [
        run("recursive", logs, clutch(), IdentificationSettings(forgetting=f))
        .parameters["coulomb"]
        .value
        for f in (1.0, 0.9)
    ]
    assert values[0] == pytest.approx(0.104, rel=0.01)
    assert values[1] == pytest.approx(0.109, rel=0.01)
