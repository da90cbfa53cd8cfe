"""The study of violations: its simulator against theory, its draws, and its judgement."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from frictool.documents.bench import Bench
from frictool.documents.registry import load
from frictool.logs.formats import FORMATS
from studies.violations.__main__ import main
from studies.violations.families import FAMILIES, draw_violation
from studies.violations.judgement import PARAMETERS, judge, summary
from studies.violations.motion import Physics, Servo, play
from studies.violations.recording import record


def played(physics: Physics, effort: np.ndarray) -> np.ndarray:
    motion = np.empty((2, effort.size))
    play(
        physics, Servo(0.0, 0.0, 1e9), effort, np.zeros(effort.size), 1e-3, 1.0, motion,
        np.empty(effort.size),
    )  # fmt: skip
    return motion


def test_a_mass_coasts_to_rest_and_stays_there() -> None:
    physics = Physics(inertia=2.0, viscous=0.0, coulomb=1.0, offset=0.0)
    effort = np.where(np.arange(4000) < 1000, 3.0, 0.0)
    position, velocity = played(physics, effort)
    assert velocity[1000] == pytest.approx(1.0, rel=1e-9)  # (3 - 1)/2 for 1 s
    assert position[-1] == pytest.approx(0.5 + 1.0, rel=1e-9)  # v^2/(2 coulomb/inertia) = 1
    assert velocity[3001:].tolist() == [0.0] * 999


def test_an_effort_below_the_friction_moves_nothing() -> None:
    physics = Physics(inertia=1.0, viscous=0.0, coulomb=1.0, offset=0.5)
    assert np.all(played(physics, np.full(100, 1.49)) == 0.0)
    assert played(physics, np.full(100, 1.51))[1, -1] > 0.0


def test_viscous_friction_ends_at_the_speed_of_balance() -> None:
    physics = Physics(inertia=0.1, viscous=0.5, coulomb=1.0, offset=0.0)
    velocity = played(physics, np.full(5000, 2.0))[1]
    assert velocity[200] == pytest.approx(2.0 * (1.0 - np.exp(-1.0)), rel=1e-6)
    assert velocity[-1] == pytest.approx(2.0, rel=1e-6)


def test_a_belt_swings_at_its_resonance() -> None:
    machine = draw_violation("test", "belt", 0)
    physics = machine.physics._replace(
        viscous=0.0, coulomb=0.0, offset=0.0, belt_damping=0.0, inertia=1.0, belt_inertia=1.0,
        belt_stiffness=0.5 * (2.0 * np.pi * 10.0) ** 2,
    )  # fmt: skip
    kick = np.where(np.arange(2000) < 1, 1.0, 0.0)
    velocity = played(physics, kick)[1, 1:]
    spectrum = np.abs(np.fft.rfft(velocity - velocity.mean()))
    assert np.argmax(spectrum) / 2.0 == pytest.approx(10.0, abs=0.5)


def test_a_text_determines_the_records() -> None:
    one, other, third = (
        record(draw_violation(seed, "mild_mix", 1), "noise").current for seed in ("a", "a", "b")
    )
    assert np.array_equal(one, other)
    assert one.size != third.size or not np.array_equal(one, third)


def test_documents_are_read(tmp_path: Path) -> None:
    assert FORMATS
    assert main(["1", "--seed", "a", "--family", "spring", "--documents", str(tmp_path)]) == 0
    folder = tmp_path / "spring" / "0"
    bench = load(folder / "bench.yaml", Bench)
    truth = json.loads((folder / "truth.json").read_text())
    assert bench.mechanics.inertia.low is not None
    assert bench.mechanics.inertia.low < truth["inertia"] < bench.mechanics.inertia.high
    assert (folder / "log.csv").read_text().startswith("time,encoder,current\n")


@pytest.mark.parametrize("family", FAMILIES)
def test_each_family_is_identified_and_judged(family: str) -> None:
    verdicts = [judge("quick", family, 0, "least-squares")]
    one = summary(family, verdicts)
    assert one.records == 1
    assert all(0 <= one.held[name][0] <= one.held[name][1] <= 1 for name in PARAMETERS)
    assert all(np.isfinite(list(verdict.half.values())).all() for verdict in verdicts)


@pytest.mark.parametrize(
    ("records", "least"), [(4, 13), pytest.param(8, 28, marks=pytest.mark.accept)]
)
def test_the_true_model_holds(records: int, least: int) -> None:
    """Fewer of the 95 % intervals than `least` hold by chance in 1 or 0.3 % of all draws."""
    verdicts = [judge("quick", "true_model", number, "least-squares") for number in range(records)]
    hits = sum(sum(one.held.values()) for one in verdicts)
    assert hits >= least
    assert not any(one.false_claims for one in verdicts)
