"""Strokes that are shorter than two smoothing windows."""

from __future__ import annotations

import numpy as np
import pytest

from frictool.identify.estimators.least_squares import least_squares
from frictool.identify.fit_warnings import short_stroke_warnings
from frictool.identify.methods import IdentificationSettings
from frictool.identify.motion_record import make_record
from tests.support.loaded_axis import rotary_bench

PERIOD = 1e-3


@pytest.mark.parametrize(("samples", "warned"), [(14, True), (100, False)])
def test_strokes_near_the_window_are_warned_of(samples: int, warned: bool) -> None:
    """A sine with strokes of `samples` samples; the shortest window has 11 samples."""
    rate = np.pi / (samples * PERIOD)
    time = PERIOD * np.arange(4000)
    position, velocity = np.sin(rate * time), rate * np.cos(rate * time)
    effort = -1e-3 * rate**2 * position + 0.01 * velocity + 0.1 * np.sign(velocity)
    log = make_record("log", time, position, effort, 1e-5, lag=1.0)
    fit = least_squares([log], rotary_bench(None), IdentificationSettings())
    assert bool(short_stroke_warnings(fit, [log])) == warned
