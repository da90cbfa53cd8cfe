"""Switched observers designed from models: what is stored, what is verified, what is told and what
is refused."""

from __future__ import annotations

from functools import lru_cache

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.documents.model import Model
from frictool.documents.observer import Observer
from frictool.documents.provenance import Provenance
from frictool.documents.registry import load
from frictool.documents.writing import to_yaml
from frictool.errors import NoSolutionError
from frictool.lmi.switched_observer_gains import ObserverMode, SwitchedGains, switched_gains
from frictool.observe.design import additive, multiplicative
from frictool.observe.design.design_notes import notes
from frictool.observe.design.friction_map import friction_at
from frictool.observe.design.mode_matrices import ModeConstants, subsystems
from frictool.observe.design.switched_settings import SwitchedObserverSettings, decay_of
from frictool.observe.design.verification import verify
from frictool.observe.motion_block import MotionBlock
from frictool.observe.observer_run import run_along
from frictool.plant.lti import Lti
from frictool.verify.hinf_norm import norm
from studies.rigs.clutch_model import ROOT

NOWHERE = Provenance("drawn", "0")
CLUTCH, EMPS = ROOT / "configs/clutch/nonlinear.yaml", ROOT / "configs/emps/published.yaml"
FEW = SwitchedObserverSettings(intervals=4)


@lru_cache
def _model(emps: bool = False) -> Model:
    return load(EMPS if emps else CLUTCH, Model)


@lru_cache
def _clutch(few: SwitchedObserverSettings = FEW) -> Observer:
    return multiplicative.design(_model(), few, NOWHERE)


@lru_cache
def _emps() -> Observer:
    return multiplicative.design(_model(emps=True), SwitchedObserverSettings(), NOWHERE)


@lru_cache
def _light() -> Observer:
    """Return a fast observer with an inertia of its own."""
    settings = SwitchedObserverSettings(intervals=4, decay=0.97, inertia=0.8 * 1.32e-5)
    return additive.design(_model(), settings, NOWHERE)


@lru_cache
def _found() -> SwitchedGains:
    switched = _clutch().switched
    assert switched is not None
    return switched_gains(subsystems(_clutch()), switched.transitions, switched.decay)


def test_a_constant_friction_has_one_interval_a_direction() -> None:
    observer = _emps()
    assert observer.switched is not None
    assert [mode.index for mode in observer.switched.modes] == [-1, 0, 1]
    assert observer.switched.modes[0].friction == 20.3935
    assert observer.axis == "linear"
    assert any(
        "an assumed error of 1% of the friction" in line
        for line in notes(observer, _model(emps=True))
    )


@pytest.mark.parametrize(
    ("emps", "kind"),
    [
        (False, "multiplicative"),
        (True, "additive"),
        pytest.param(False, "additive", marks=pytest.mark.accept),
        pytest.param(True, "multiplicative", marks=pytest.mark.accept),
    ],
)
def test_what_is_stored_is_what_was_verified(kind: str, emps: bool) -> None:
    module = multiplicative if kind == "multiplicative" else additive
    observer = module.design(_model(emps), FEW, NOWHERE)
    switched = observer.switched
    assert switched is not None
    assert observer.kind == kind
    modes = subsystems(observer)
    for mode in switched.modes:
        loop = modes[mode.index].a - np.array(mode.gains) @ modes[mode.index].c
        assert np.max(np.abs(np.linalg.eigvals(loop))) == pytest.approx(
            mode.spectral_radius, rel=1e-12
        )
        assert mode.spectral_radius < switched.decay
        if mode.direction:  # a mode alone is a linear system, of which the norm is known
            own = norm(
                Lti(loop, modes[mode.index].q, modes[mode.index].weight, np.zeros((3, 1)), 1.0)
            )[0]
            assert own <= switched.gamma
    assert switched.smallest_gamma is not None
    assert switched.smallest_gamma <= switched.gamma
    assert (
        0.9 * switched.gamma < switched.simulated_gain <= switched.gamma
    )  # the search for the worst disturbance finds it
    assert switched.switching_radius < 1.0
    stuck = next(mode for mode in switched.modes if mode.direction == 0)
    assert stuck.gains[2][0] == 0.0


@pytest.mark.accept  # tests/cli/test_observe_design.py writes the same bytes twice
def test_the_same_inputs_give_the_same_text_and_it_is_read_back() -> None:
    again = multiplicative.design(_model(), FEW, NOWHERE)
    assert to_yaml(again) == to_yaml(_clutch())


@given(st.integers(0, 10**6))
@settings(max_examples=4, deadline=None)
def test_rests_of_any_length_between_motions_that_are_long_enough_are_made_up_for(
    seed: int,
) -> None:
    """The error as it really is, alpha standing still in mode 0: below what it was after each
    motion of motion_after_rest_s."""
    observer, found, random = _clutch(), _found(), np.random.default_rng(seed)
    switched = observer.switched
    assert switched is not None
    assert switched.motion_after_rest_s is not None
    modes = subsystems(observer)
    loops = {
        mode.index: modes[mode.index].a - np.array(mode.gains) @ modes[mode.index].c
        for mode in switched.modes
    }
    rest = modes[0].a - np.array(switched.modes[4].gains)[:, :1] @ modes[0].c[:1]
    assert switched.modes[4].index == 0
    samples = int(np.ceil(switched.motion_after_rest_s / observer.sample_period_s)) + 1
    e = random.normal(size=3) / np.sqrt(np.diag(found.t @ found.t.T))
    for _ in range(6):
        mode = int(random.choice([i for i in loops if i]))
        before = found.value(mode, e)
        e = np.linalg.matrix_power(loops[mode], samples) @ e
        e = np.linalg.matrix_power(rest, int(random.integers(1, 400))) @ e
        assert found.value(int(random.choice([i for i in loops if i])), e) < before


def test_alpha_finds_a_friction_that_has_grown_along_a_sweep() -> None:
    """The recursion (6.4) beside a plant of its own kind, with half as much friction more: to 5 %
    on average after half a second."""
    observer = _clutch()
    assert observer.switched is not None
    modes, facts = subsystems(observer), ModeConstants.of(observer)
    forward = [mode for mode in observer.switched.modes if mode.direction == 1]
    x, v, estimate, alphas = 0.0, 60.0, np.array([0.0, 60.0, 1.0]), []
    for _ in range(1000):
        cell = next(
            (mode for mode in forward if mode.over is not None and x < mode.over[1]), forward[-1]
        )
        mode, push = modes[cell.index], 0.18 + 2e-3 * (60.0 - v)
        estimate = (
            mode.a @ estimate
            + np.array([0.0, facts.period / facts.inertia, 0.0]) * push
            + np.array(cell.gains) @ (x - mode.c @ estimate)
        )
        friction = 1.5 * float(friction_at(observer.friction, 1, x))
        x, v = x + facts.period * v, v + facts.period / facts.inertia * (push - friction)
        alphas.append(estimate[2])
    assert x > 50.0
    assert np.mean(alphas[500:]) == pytest.approx(1.5, rel=0.05)
    worst = max(
        mode.deviation / mode.friction for mode in forward
    )  # alpha takes up what the intervals leave out
    assert np.max(np.abs(np.array(alphas[500:]) / 1.5 - 1.0)) < 1.5 * worst


def _broken(change: str) -> None:
    observer = _clutch()
    assert observer.switched is not None
    modes, found = subsystems(observer), _found()
    gains = {i: each.copy() for i, each in found.gains.items()}
    if change == "gains":
        gains[2] *= 1.5
    if change == "sign":
        gains[2][2] *= -1.0
    verify(modes, observer.switched.transitions, gains, found)


def test_gains_that_were_changed_are_not_verified() -> None:
    _broken("nothing")
    for change in ("gains", "sign"):
        with pytest.raises(NoSolutionError, match="not verified: the inequalities do not hold"):
            _broken(change)


def test_a_gamma_that_is_too_small_is_seen_in_simulation(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("frictool.observe.design.verification.proved_gamma", lambda *_: 10.0)
    with pytest.raises(
        NoSolutionError,
        match=r"not verified: the simulated gain .* is .*, above the proved gamma 10;",
    ):
        _broken("nothing")


def test_a_friction_of_zero_tells_nothing_of_its_wear() -> None:
    today = _model(emps=True).parameters
    bare = msgspec.structs.replace(
        today, coulomb=msgspec.structs.replace(today.coulomb, value=0.0, low=None, high=None)
    )
    model = msgspec.structs.replace(_model(emps=True), parameters=bare)
    with pytest.raises(NoSolutionError, match=r"^mode -1: .*one cause is friction of 0, on which"):
        multiplicative.design(model, SwitchedObserverSettings(), NOWHERE)
    assert additive.design(model, SwitchedObserverSettings(), NOWHERE).kind == "additive"


def test_settings_that_cannot_be_are_refused() -> None:
    bench = _model().bench
    slow = msgspec.structs.replace(
        bench, mechanics=msgspec.structs.replace(bench.mechanics, top_speed=None)
    )
    with pytest.raises(
        NoSolutionError, match=r"no mechanics\.top_speed; give --switch-speed, such as 10rad/s"
    ):
        additive.design(
            msgspec.structs.replace(_model(), bench=slow), SwitchedObserverSettings(), NOWHERE
        )
    with pytest.raises(NoSolutionError, match=r"switch speed: found 1e\+09 rad/s; allowed: below"):
        additive.design(_model(), SwitchedObserverSettings(intervals=4, switch_speed=1e9), NOWHERE)
    with pytest.raises(NoSolutionError, match="decay nearer to 1"):
        additive.design(_model(), SwitchedObserverSettings(intervals=4, decay=0.3), NOWHERE)
    with pytest.raises(ValueError, match="stuck_speed: found 2"):
        SwitchedObserverSettings(stuck_speed=2.0)
    with pytest.raises(ValueError, match="the weight of the speed > 0"):
        SwitchedObserverSettings(weights=(1.0, 0.0, 1.0))


def test_the_decay_keeps_its_time_constant_at_shorter_periods() -> None:
    fast = msgspec.structs.replace(
        _model(), bench=msgspec.structs.replace(_model().bench, sample_period_s=1e-4)
    )
    assert decay_of(_model(), SwitchedObserverSettings()) == pytest.approx(0.997)
    assert decay_of(fast, SwitchedObserverSettings()) ** 10 == pytest.approx(0.997)
    assert decay_of(fast, SwitchedObserverSettings(decay=0.9)) == 0.9
    slow = msgspec.structs.replace(
        _model(), bench=msgspec.structs.replace(_model().bench, sample_period_s=1e-2)
    )
    assert decay_of(slow, SwitchedObserverSettings()) == 0.997


def test_a_decay_that_costs_much_of_gamma_is_told() -> None:
    fast = _light()
    assert fast.switched is not None
    assert fast.switched.smallest_gamma is not None
    assert any("choose a --decay nearer to 1" in line for line in notes(fast, _model()))
    assert not any("choose a --decay nearer to 1" in line for line in notes(_clutch(), _model()))


def test_notes_tell_a_coarse_encoder_with_its_figures_and_are_silent_of_a_fine_one() -> None:
    told = notes(_clutch(), _model())
    assert "one count of 0.1122 rad changes the estimated speed by up to" in told[0]
    assert any("the effect of any rest decays in" in line for line in told)
    assert not any("coarse" in line for line in notes(_emps(), _model(emps=True)))


def test_an_inertia_of_ones_own_is_in_the_matrices_and_in_the_document() -> None:
    light = _light()
    assert light.inertia.value == pytest.approx(1.056e-5)
    modes: dict[int, ObserverMode] = subsystems(light)
    assert modes[1].a[1, 2] == pytest.approx(-1e-3 / 1.056e-5)


@pytest.mark.parametrize("kind", ["multiplicative", "additive"])
def test_what_runs_is_what_was_certified(kind: str) -> None:
    """Each step of the program along a log is (6.4) with the matrices and the gains of the mode
    that its estimate is in."""
    observer = _clutch() if kind == "multiplicative" else additive.design(_model(), FEW, NOWHERE)
    switched, modes, facts = observer.switched, subsystems(observer), ModeConstants.of(observer)
    assert switched is not None
    random, time = np.random.default_rng(5), 1e-3 * np.arange(800)
    position, speed = 30.0 + 25.0 * np.sin(6.0 * time), 150.0 * np.cos(6.0 * time)
    levels = np.where(
        speed > 0.0, *(friction_at(observer.friction, direction, position) for direction in (1, -1))
    )
    effort = (
        1.2 * np.sign(speed) * levels
        - facts.inertia * 900.0 * np.sin(6.0 * time)
        + 1e-4 * random.normal(size=time.size)
    )
    piece = MotionBlock(time, position, effort, False)
    found = next(iter(run_along(observer, [piece])))
    assert found.wear is not None
    states = np.column_stack([found.position, found.velocity, found.wear])
    seen = set()
    for k in range(time.size - 1):
        x, v, alpha = states[k]
        direction = 0 if abs(v) < switched.switch_speed.value else int(np.sign(v))
        own = sorted(
            (mode for mode in switched.modes if mode.direction == direction),
            key=lambda mode: mode.over or (0.0, 0.0),
        )
        cell = next((mode for mode in own if mode.over is not None and x < mode.over[1]), own[-1])
        mode, seen = modes[cell.index], seen | {cell.index}
        known = (
            direction * float(friction_at(observer.friction, direction, x))
            if kind == "additive" and direction
            else 0.0
        )
        push = facts.period / facts.inertia * (piece.effort[k] - known) * abs(direction)
        measured = np.array([position[k], alpha])[: len(mode.c)]
        expected = (
            mode.a @ states[k]
            + np.array([0.0, push, 0.0])
            + np.array(cell.gains) @ (measured - mode.c @ states[k])
        )
        assert states[k + 1] == pytest.approx(expected, rel=1e-9, abs=1e-9)
    assert len(seen) >= (7 if kind == "multiplicative" else 3)
