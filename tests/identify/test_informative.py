"""A parameter that spans more than a factor of ten is not identified, and no document is written
that cannot be read back."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from frictool.adapters.axis_model import axis_of
from frictool.documents.model import Model
from frictool.documents.quantity import Quantity
from frictool.documents.registry import load
from frictool.identify import outcome
from frictool.identify.breakaway_parameters import (
    impossible_breakaway,
    without_impossible_breakaway,
)
from frictool.identify.estimators import stribeck_curve
from frictool.identify.fit_result import Interval
from frictool.identify.interval_checks import (
    below_coulomb,
    contradicts,
    too_vague,
    why_uninformative,
)
from studies.command_line import run
from tests.identify.arm import PERIOD, Arm, write_bench, write_log
from tests.support.command_line import refused

ARM = Arm(viscous=0.02, counts=20000)
SPEEDS = np.geomspace(0.2, 3.0, 7)  # rad/s


def runs(folder: Path, stribeck_velocity: float, seed: int) -> Path:
    """A log of constant speeds to and fro whose friction falls over a speed far below, or well
    within, theirs."""
    draw = np.random.default_rng(seed)
    speed = np.concatenate(
        [np.full(1000, side * value) for value in SPEEDS for side in (1.0, -1.0)]
    )
    size = np.abs(speed)
    friction = (
        ARM.coulomb
        + (3.0 * ARM.breakaway - ARM.coulomb) * np.exp(-((size / stribeck_velocity) ** 2))
        + ARM.viscous * size
    )
    position = np.floor(np.cumsum(speed) * PERIOD / ARM.step) * ARM.step
    return write_log(
        folder / "runs.csv",
        position,
        np.sign(speed) * friction + 0.01 * draw.standard_normal(speed.size),
    )


def identify(folder: Path, log: Path) -> dict[str, dict[str, dict[str, float]]]:
    """Return the JSON of `identify --method stribeck-curve` after its model was read and
    simulated."""
    model = folder / "model.yaml"
    result = run(
        "identify",
        log,
        "--bench",
        write_bench(folder, ARM),
        "--method",
        "stribeck-curve",
        "-o",
        model,
        "--json",
    )
    assert result.code == 0, result.stderr
    axis_of(load(model, Model))
    return dict(json.loads(result.stdout))


@pytest.mark.parametrize(
    "seed", [0, *(pytest.param(seed, marks=pytest.mark.accept) for seed in range(1, 5))]
)
def test_a_fall_that_the_runs_do_not_reach_is_not_identified(tmp_path: Path, seed: int) -> None:
    """At the slowest run friction has fallen but for a fortieth: the breakaway would be
    extrapolated over orders of magnitude."""
    told = identify(tmp_path, runs(tmp_path, 0.105, seed))
    assert not {"breakaway", "stribeck_velocity"} & told["parameters"].keys()
    assert "slower runs would determine it" in str(told["not_identified"]["breakaway"])
    coulomb = told["parameters"]["coulomb"]
    assert coulomb["low"] <= ARM.coulomb <= coulomb["high"]


def test_a_fall_within_the_runs_is_identified(tmp_path: Path) -> None:
    told = identify(tmp_path, runs(tmp_path, 0.6, 1))["parameters"]
    assert told["breakaway"]["low"] <= 3.0 * ARM.breakaway <= told["breakaway"]["high"]
    assert told["stribeck_velocity"]["low"] <= 0.6 <= told["stribeck_velocity"]["high"]


def test_breakaway_and_stribeck_velocity_are_refused_together(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The line that remains explains less than half of the effort of a friction that falls."""
    monkeypatch.setattr(
        stribeck_curve,
        "too_vague",
        lambda name, _: "too vague" if name == "stribeck_velocity" else None,
    )
    log, bench = runs(tmp_path, 0.6, 1), write_bench(tmp_path, ARM)
    result = run("identify", log, "--bench", bench, "--method", "stribeck-curve", "--json")
    told = json.loads(result.stdout)
    assert result.code == 4
    assert told["parameters"] == {}
    assert "too vague; slower runs would determine it" in told["not_identified"]["breakaway"]
    assert "does not explain the effort" in told["not_identified"]["coulomb"]


def test_the_rule() -> None:
    """Inertia, breakaway and Stribeck velocity are above 0; viscous and Coulomb friction may be 0,
    where the bench's interval judges."""
    for name in ("inertia", "breakaway", "stribeck_velocity"):
        assert "reaches zero" in str(too_vague(name, Interval(1.0, 0.0, 2.0)))
        assert too_vague(name, Interval(1.0, 0.2, 2.0)) is None
        assert "spans a factor of 10.5; allowed: at most 10" in str(
            too_vague(name, Interval(1.0, 0.2, 2.1))
        )
    assert too_vague("offset", Interval(1.0, 0.01, 2.0)) is None
    near_zero = Interval(0.01, -0.01, 0.03)
    assert why_uninformative("viscous", near_zero, Quantity(0.5, 0.0, 1.0)) is None
    assert why_uninformative("viscous", near_zero, Quantity(0.01)) is None
    assert "10 times the bench's value" in str(
        why_uninformative("viscous", near_zero, Quantity(0.002))
    )
    assert below_coulomb(Interval(1.0, 0.9, 1.1), Interval(1.2, 1.05, 1.3)) is None
    assert "allowed: at least Coulomb friction" in str(
        below_coulomb(Interval(1.0, 0.9, 1.1), Interval(1.2, 1.15, 1.3))
    )


@pytest.mark.parametrize("width", [None, Quantity(2.0, unit="rad")])
def test_ramps_inside_an_unstated_backlash_name_the_key(width: Quantity | None) -> None:
    bench = SimpleNamespace(mechanics=SimpleNamespace(backlash=width))
    found = {"breakaway": Interval(1.0, 0.9, 1.1), "coulomb": Interval(1.2, 1.15, 1.3)}
    made = outcome.Outcome(found, ramp=SimpleNamespace(by_position=None))
    reason = without_impossible_breakaway(made, bench).refused["breakaway"]
    assert ("state mechanics.backlash" in reason) == (width is None)
    assert len(f"not identified: breakaway: {reason}") <= 190
    varying = outcome.Outcome(found, ramp=SimpleNamespace(by_position=object()))
    assert without_impossible_breakaway(varying, bench) is varying  # a warning states the reason
    assert impossible_breakaway(varying, bench) == reason


@pytest.mark.parametrize(
    "known", [Quantity(5.0, 0.0, 50.0), Quantity(5.0, 2.0, 9.0), Quantity(5.0)]
)
@pytest.mark.parametrize("name", ["viscous", "coulomb"])
def test_a_narrower_interval_of_friction_is_no_worse(name: str, known: Quantity) -> None:
    """An interval inside a usable one, with the bench's value in both, excludes more values."""
    ends = np.geomspace(0.05, 60.0, 12)
    lows = [-20.0, -1.0, 0.0, *ends[ends < 5.0].tolist()]
    highs = ends[ends > 5.0].tolist()
    usable = {
        (low, high): why_uninformative(name, Interval(5.0, low, high), known) is None
        for low in lows
        for high in highs
    }
    assert len(set(usable.values())) == 2
    for (low, high), accepted in usable.items():
        inside = [one for (a, b), one in usable.items() if a >= low and b <= high]
        assert not accepted or all(inside)
    # values below 0 exclude nothing: friction has none
    assert all(usable[low, high] == usable[0.0, high] for low in (-20.0, -1.0) for high in highs)


def test_intervals_that_touch_do_not_contradict_each_other() -> None:
    known = Quantity(2.0, 1.0, 3.0)
    assert not contradicts(Interval(4.0, 3.0, 5.0), known)
    assert not contradicts(Interval(0.5, 0.0, 1.0), known)
    assert contradicts(Interval(4.0, 3.1, 5.0), known)
    assert contradicts(Interval(0.5, 0.0, 0.9), known)


def test_a_model_that_cannot_be_read_is_not_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Should a rule above miss something, the document is read back before it is written."""
    log, bench, model = runs(tmp_path, 0.6, 1), write_bench(tmp_path, ARM), tmp_path / "model.yaml"
    rule = outcome.without_negative

    def broken(name: str, interval: Interval, known: Quantity | None) -> Interval:
        vague = Interval(0.6, -1.0, 2.2)
        return vague if name == "stribeck_velocity" else rule(name, interval, known)

    # of the checks of an interval, those that would notice are off
    monkeypatch.setattr(outcome, "without_negative", broken)
    monkeypatch.setattr(outcome, "why_uninformative", lambda *_: None)
    monkeypatch.setattr(outcome, "NEVER_NEGATIVE", ())
    refused(
        run("identify", log, "--bench", bench, "--method", "stribeck-curve", "-o", model),
        4,
        "not written",
        "stribeck_velocity",
    )
    assert not model.exists()
