"""The published EMPS pipeline: its published values on the measured record, known parameters on a simulated one, refusals."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.io import loadmat

from frictool.documents.bench import Bench
from frictool.documents.registry import load
from frictool.identify.inverse_dynamic import PUBLISHED, Pipeline, inverse_dynamic
from frictool.identify.least_squares import least_squares
from frictool.identify.outcome import NothingUsable
from frictool.identify.record import Record, make_record
from sample_logs.make import TRUTH, sines
from tests.identify.benches import EMPS, data, record

PUBLISHED_VALUES = {"inertia": (95.1089, 2e-3), "viscous": (203.5034, 1e-2), "coulomb": (20.3935, 1e-2), "offset": (-3.1648, 2e-2)}


@pytest.fixture(scope="module")
def emps() -> Record:
    file = loadmat(data("emps", "DATA_EMPS.mat"))
    effort = file["vir"].ravel() * float(file["gtau"].item())
    return make_record("emps", file["t"].ravel(), file["qm"].ravel(), effort, resolution=5e-8, lag=0.0)


@pytest.fixture(scope="module")
def bench() -> Bench:
    return load(EMPS, Bench)


def test_published_values_of_emps(emps: Record, bench: Bench) -> None:
    found = inverse_dynamic([emps], bench, 0.95)
    for name, (value, tolerance) in PUBLISHED_VALUES.items():
        assert found.parameters[name].value == pytest.approx(value, rel=tolerance)
        assert found.parameters[name].low < value < found.parameters[name].high
    assert found.force_error == pytest.approx(0.0408, abs=5e-4)
    assert found.held_out_force_error == pytest.approx(found.force_error, rel=0.05)


def test_least_squares_agrees_on_emps(emps: Record, bench: Bench) -> None:
    found = least_squares([emps], bench, 0.95)
    assert found.parameters["inertia"].value == pytest.approx(95.1, rel=0.01)
    assert found.parameters["viscous"].low < 203.5 < found.parameters["viscous"].high
    assert found.parameters["coulomb"].low < 20.39 < found.parameters["coulomb"].high


def test_known_parameters_of_an_axis_without_backlash(bench: Bench) -> None:
    truth = TRUTH._replace(encoder_step=1e-4, backlash=0.0, breakaway=0.099)
    found = inverse_dynamic([record(sines(3, truth), truth)], bench, 0.95)
    assert found.parameters["viscous"].value == pytest.approx(truth.viscous, rel=0.05)
    assert found.parameters["coulomb"].value == pytest.approx(truth.coulomb, rel=0.05)
    assert found.parameters["inertia"].value == pytest.approx(truth.inertia, rel=0.05)


def test_a_constant_keeps_its_size(bench: Bench) -> None:
    """The decimation filter passes a constant at the bottom of its ripple; the offset must not take that for itself."""
    truth = TRUTH._replace(encoder_step=1e-4, backlash=0.0, breakaway=0.099, offset=0.05)
    log = record(sines(3, truth), truth)
    found = [inverse_dynamic([log], bench, 0.95, Pipeline(decimate=n)).parameters["offset"].value for n in (1, 10)]
    assert found[1] == pytest.approx(found[0], rel=5e-3)
    assert found[1] == pytest.approx(0.05, rel=0.02)


def test_refusals(bench: Bench) -> None:
    log = record(sines(1))
    with pytest.raises(NothingUsable, match="not below half"):
        inverse_dynamic([log], bench, 0.95, Pipeline(cutoff_hz=600.0))
    short = make_record("short", log.time[:200], log.position[:200], log.effort[:200], log.resolution, log.lag)
    with pytest.raises(NothingUsable, match="too few"):
        inverse_dynamic([short], bench, 0.95)
    kept = np.r_[0:5000, 5100:9000]
    holed = make_record("holed", log.time[kept], log.position[kept], log.effort[kept], log.resolution, log.lag)
    with pytest.raises(NothingUsable, match="gaps"):
        inverse_dynamic([holed], bench, 0.95)
    still = make_record("still", log.time, np.zeros(log.time.size), log.effort, log.resolution, log.lag)
    with pytest.raises(NothingUsable, match="excite"):
        inverse_dynamic([still], bench, 0.95, PUBLISHED)
