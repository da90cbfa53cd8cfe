"""The two tests of thesis 6.3.2 and 6.4.2 under the PID: what converges with a perfect encoder, and
how the real one degrades it."""

from __future__ import annotations

import functools
import math
from pathlib import Path

import msgspec
import numpy as np
import pytest

from frictool.adapters.observer_composition import switched_facts
from frictool.documents.controller import Controller
from frictool.documents.model import Model
from frictool.documents.observer import Observer
from frictool.documents.provenance import Provenance
from frictool.documents.registry import load
from frictool.documents.scenario import Scenario
from frictool.logs.log import Stream
from frictool.observe.design import additive, multiplicative
from frictool.observe.design.friction_map import friction_at
from frictool.observe.design.switched_settings import SwitchedObserverSettings
from frictool.observe.motion_block import MotionBlock
from frictool.observe.observer_run import ObserverOutput, run_along
from frictool.simulate.closed_loop import simulate_closed_loop
from studies.observers.switched_observers import First, Second, Truth, first, second, truth

ROOT = Path(__file__).parents[2]
CLUTCH = ROOT / "configs/clutch"
PLANTS = {"first": CLUTCH / "observers/perfect.yaml", "second": CLUTCH / "nonlinear.yaml"}
INTERVALS = 8  # a few, for speed
LOW = 0.8  # the observer's inertia in the second test, over the plant's
PROVENANCE = Provenance("written by a test", "0")


@functools.cache
def plant(test: str) -> Model:
    return load(PLANTS[test], Model)


@functools.cache
def log(test: str) -> Stream:
    """The test under the PID of laws/linear.yaml."""
    scenario = load(CLUTCH / f"observers/{test}.yaml", Scenario)
    controller = load(ROOT / "studies/rigs/controllers/linear.yaml", Controller)
    return simulate_closed_loop(plant(test), controller, scenario, PROVENANCE).streams[0]


@functools.cache
def observer(test: str, kind: str, decay: float, quiet: float | None = None) -> Observer:
    """As the Makefile designs it."""
    model = plant(test)
    settings = SwitchedObserverSettings(
        intervals=INTERVALS,
        decay=decay,
        quiet=quiet,
        switch_speed=10.0 if test == "first" else 100.0,
        inertia=None if test == "first" else LOW * model.parameters.inertia.value,
    )
    return (multiplicative if kind == "multiplicative" else additive).design(
        model, settings, PROVENANCE
    )


@functools.cache
def known(test: str) -> Truth:
    return truth(plant(test), log(test))


def along(test: str, own: Observer) -> ObserverOutput:
    stream = log(test)
    return next(
        run_along(
            own,
            [
                MotionBlock(
                    stream.time, stream.signals["position"], stream.signals["effort"], follows=False
                )
            ],
        )
    )


def figures(test: str, *design: object) -> First | Second:
    own = observer(test, *design)
    return (first if test == "first" else second)(known(test), along(test, own), own)


def test_the_multiplicative_observer_finds_friction_that_has_grown_by_half() -> None:
    found = figures("first", "multiplicative", 0.997, 4.0)
    assert isinstance(found, First)
    assert found.settled < 0.6
    assert found.before == pytest.approx(1.0, abs=0.02)
    assert found.after == pytest.approx(1.5, rel=0.05)


def test_a_decay_alone_fails_with_the_real_encoder() -> None:
    """Without noise in the problem the gains are for a perfect encoder: with the real one alpha
    drifts to its bound, f + alpha = 3 f."""
    own = observer("second", "additive", 0.997)
    degraded = figures("second", "additive", 0.997)
    assert isinstance(degraded, Second)
    most = switched_facts(own).wear[1]
    assert degraded.high == pytest.approx(most, rel=1e-12)
    assert most == pytest.approx(
        2.0
        * max(
            np.max(friction_at(own.friction, side, np.linspace(0.0, 63.0, 999))) for side in (1, -1)
        ),
        rel=1e-4,
    )
    assert degraded.friction > 100.0


def test_the_additive_observer_finds_it_where_it_may_be_fast() -> None:
    """As printed its alpha hardly moves; with a decay of 0.94 the friction over a period is within
    5 %."""
    printed, found = figures("first", "additive", 1.0), figures("first", "additive", 0.94, 4.0)
    assert isinstance(printed, First)
    assert isinstance(found, First)
    assert math.isinf(printed.settled)
    assert printed.friction == pytest.approx(100.0 * (1.0 - 1.0 / 1.5), abs=0.5)
    assert found.settled < 0.6
    assert found.friction < 5.0


@pytest.mark.accept
def test_the_real_encoder_degrades_both() -> None:
    """Figures 6.6 to 6.10: more error of the speed, alpha off 1 and moving, an additive one between
    about -0.1 and 0.15 N m."""
    factor, added = (
        figures("second", "multiplicative", 0.997, 4.0),
        figures("second", "additive", 0.94, 4.0),
    )
    ideal, ideal_added = (
        figures("first", "multiplicative", 0.997, 4.0),
        figures("first", "additive", 0.94, 4.0),
    )
    assert isinstance(factor, Second)
    assert isinstance(added, Second)
    assert factor.velocity > 2.0 * ideal.velocity
    assert added.velocity > 2.0 * ideal_added.velocity
    assert factor.low < 0.95
    assert factor.high > 1.1
    assert -0.15 < added.low < -0.05
    assert 0.1 < added.high < 0.2
    assert added.friction > 3.0 * ideal_added.friction
    assert factor.friction > 5.0


def test_the_figures_of_a_perfect_estimate_and_of_one_that_is_off() -> None:
    """The tool itself: nothing wrong where nothing is, and as wrong as it is made."""
    own, true = observer("first", "multiplicative", 0.997, 4.0), known("first")
    worn = np.where(true.time >= 5.0, 1.5, 1.0)
    exact = ObserverOutput(true.time, true.time, true.velocity, true.friction, worn)
    found = first(true, exact, own)
    assert (
        found.settled,
        found.before,
        found.after,
        found.friction,
        found.within,
        found.velocity,
    ) == (0.0, 1.0, 1.5, 0.0, 1.0, 0.0)
    off = ObserverOutput(
        true.time,
        true.time,
        true.velocity + 3.0,
        0.9 * true.friction,
        np.where(true.time >= 7.0, worn, 1.0),
    )
    found = first(true, off, own)
    assert found.settled == pytest.approx(2.0, abs=1e-9)
    assert found.friction == pytest.approx(10.0, abs=1e-9)
    assert found.velocity == pytest.approx(3.0, abs=1e-12)
    assert found.within == 0.0
    late = msgspec.structs.replace(
        own, switched=msgspec.structs.replace(own.switched, wear="additive")
    )
    assert math.isinf(first(true, off, late).settled)
