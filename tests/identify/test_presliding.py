"""Presliding from slow loops on a SIMULATED bench: each law's parameters come back within their
intervals, and are told from the others."""

from __future__ import annotations

import json
from pathlib import Path

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.documents.model import Model
from frictool.documents.registry import load
from frictool.documents.writing import to_yaml
from frictool.friction.preisach_cycles import masing_everett
from frictool.identify.fit_result import Interval, UnusableLogs
from frictool.identify.motion_record import MotionRecord
from frictool.identify.presliding.elasto_plastic import elasto_plastic, elasto_plastic_path
from frictool.identify.presliding.loops import find_loops
from frictool.identify.presliding.lugre import lugre, lugre_path
from frictool.identify.presliding.maxwell import element_paths, maxwell
from frictool.identify.presliding.preisach import preisach
from studies.command_line import run
from studies.rigs.identification_rigs import CLUTCH
from tests.support.command_line import refused
from tests.support.presliding_bench import (
    BREAKAWAY,
    COUNT,
    INERTIA,
    MAXWELL,
    PERIOD,
    STIFFNESS,
    TURNS,
    Z_BA,
    Z_MAX,
    centred_cycles,
    curve,
    slow_loops,
)
from tests.support.short_logs import first_part

KNOWN = Interval(BREAKAWAY, 0.995 * BREAKAWAY, 1.005 * BREAKAWAY)
BENCH = f"""\
format: bench/1
name: contact
axis: rotary
sample_period_s: {PERIOD}
encoder: {{counts_per_revolution: {round(2.0 * np.pi / COUNT)}}}
actuator:
  drive: current
  constant: {{value: 1, unit: N m/A}}
  limit: {{value: 5, unit: A}}
mechanics:
  inertia: {{value: {INERTIA}, unit: kg m^2}}
  viscous: {{value: 0.01, low: 0, high: 0.02, unit: N m s/rad}}
  coulomb: {{value: 1.4, low: 1.2, high: 1.6, unit: N m}}
  breakaway: {{value: {BREAKAWAY}, low: {KNOWN.low}, high: {KNOWN.high}, unit: N m}}
columns:
  time: {{column: time, unit: s}}
  position: {{column: position, unit: rad}}
  current: {{column: current, unit: A}}
"""


def holds(interval: Interval, truth: float) -> bool:
    return interval.low <= truth <= interval.high


def test_lugre_is_found_and_told_from_the_others() -> None:
    loops = find_loops([slow_loops("lugre", 1, COUNT)], KNOWN)
    found = lugre(loops, 0.95)
    assert holds(found.parameters[0], STIFFNESS)
    assert found.parameters[0].half_width < 0.02 * STIFFNESS
    assert found.held_out < 0.2 * maxwell(loops, 0.95).held_out


def test_elasto_plastic_is_found_and_told_from_the_others() -> None:
    loops = find_loops([slow_loops("elasto_plastic", 1, COUNT)], KNOWN)
    found = elasto_plastic(loops, 0.95)
    assert holds(found.parameters[0], STIFFNESS)
    assert holds(found.parameters[1], Z_BA)
    assert found.held_out < 0.2 * min(lugre(loops, 0.95).held_out, maxwell(loops, 0.95).held_out)


def test_maxwell_slip_is_found_and_told_from_the_others() -> None:
    loops = find_loops([slow_loops("maxwell_slip", 1, COUNT)], KNOWN)
    found = maxwell(loops, 0.95)
    assert all(
        holds(one, curve(float(d))) for d, one in zip(found.displacement, found.force, strict=True)
    )
    assert holds(found.stiffness, float(MAXWELL[1].sum()))
    assert holds(found.limit, Z_MAX)
    assert found.held_out < 0.2 * lugre(loops, 0.95).held_out


def test_a_noisy_effort_does_not_end_a_branch_of_preisach_before_the_axis_turns() -> None:
    """Near z_max the effort is flat; cut at its own reversal, the branches of the largest
    amplitudes ended 5 % early and were not used."""
    for seed in (0, 3):
        assert preisach(
            find_loops([centred_cycles(2, 0.01, seed, 0.3)], KNOWN), 0.95
        ).everett.shape == (21, 21)


def test_preisach_of_centred_cycles_is_masing_s() -> None:
    found = preisach(find_loops([centred_cycles(3, 0.002)], KNOWN), 0.95)
    truth = masing_everett().reshape(21, 21)
    assert found.everett.shape == truth.shape
    lower = np.tril(np.ones(truth.shape, dtype=bool), -1)
    assert np.mean((np.abs(found.everett - truth) <= found.half_width)[lower]) > 0.9
    assert holds(found.saturation, BREAKAWAY)
    with pytest.raises(UnusableLogs, match="no set of centred cycles"):
        preisach(find_loops([slow_loops("lugre", 1, COUNT)], KNOWN), 0.95)


@settings(max_examples=20, deadline=None)
@given(st.lists(st.floats(-2.0, 2.0), min_size=2, max_size=30), st.floats(0.1, 0.9))
def test_paths_do_not_depend_on_how_finely_they_are_walked(
    places: list[float], share: float
) -> None:
    """Kernels against a walk in a hundred plain steps; no force beyond the breakaway."""
    position = np.concatenate(([0.0], places)) * Z_MAX
    fine = np.interp(
        np.linspace(0.0, position.size - 1.0, 100 * (position.size - 1) + 1),
        np.arange(position.size),
        position,
    )
    elements, values = np.array([0.3, 0.8]) * Z_MAX, []
    for path in (position, fine):
        starts, one, two, three = (
            np.arange(path.size) == 0,
            np.empty(path.size),
            np.empty(path.size),
            np.empty((path.size, 2)),
        )
        lugre_path(path, starts, STIFFNESS, BREAKAWAY, one)
        elasto_plastic_path(path, starts, STIFFNESS, BREAKAWAY, share, two)
        element_paths(path, starts, elements, three)
        values.append(
            [
                force[:: 1 if path is position else 100]
                for force in (one, two, three[:, 0], three[:, 1])
            ]
        )
    for coarse, walked, size in zip(*values, (BREAKAWAY, BREAKAWAY, *elements), strict=True):
        assert coarse == pytest.approx(walked, abs=5e-3 * size)
        assert np.abs(coarse).max() <= size * (1.0 + 1e-9)


def test_what_does_not_tell_presliding_is_refused() -> None:
    with pytest.raises(
        UnusableLogs, match=r"longest branch .* \d encoder counts; .* a step of at most"
    ):
        find_loops([slow_loops("lugre", 1, 0.5 * Z_MAX)], KNOWN)
    with pytest.raises(UnusableLogs, match="reverses 2 times; needed: at least 5"):
        find_loops([slow_loops("lugre", 1, COUNT, turns=(0.8, -0.8, 0.8))], KNOWN)
    with pytest.raises(UnusableLogs, match="needed for the presliding distance: at least 50 %"):
        maxwell(
            find_loops([slow_loops("maxwell_slip", 1, 0.1 * COUNT, turns=(0.2, -0.2) * 4)], KNOWN),
            0.95,
        )


def csv(log: MotionRecord, folder: Path) -> Path:
    path = folder / "loops.csv"
    rows = [
        f"{t:.3f},{x:.9f},{u:.6f}"
        for t, x, u in zip(log.time, log.position, log.effort, strict=True)
    ]
    path.write_text("\n".join(["time [s],position [rad],current [A]", *rows, ""]))
    return path


def test_the_command_writes_presliding_into_the_model(tmp_path: Path) -> None:
    bench, target = tmp_path / "bench.yaml", tmp_path / "model.yaml"
    bench.write_text(BENCH)
    result = run(
        "identify",
        "--loops",
        csv(slow_loops("lugre", 2, COUNT), tmp_path),
        "--bench",
        bench,
        "-o",
        target,
        "--json",
    )
    assert result.code == 0, result.stderr
    found, model = json.loads(result.stdout)["presliding"], load(target, Model)
    assert model.presliding is not None
    assert model.presliding.law == found["law"] == "lugre"
    low, high = model.presliding.stiffness.interval
    assert low <= STIFFNESS <= high
    low, high = model.presliding.limit.interval
    assert low <= BREAKAWAY / STIFFNESS <= high
    assert "preisach" in model.presliding.refused
    assert [entry.name for entry in model.provenance.inputs] == ["loops.csv", "bench.yaml"]
    assert (
        "presliding, by lugre"
        in run("identify", "--loops", tmp_path / "loops.csv", "--bench", bench).stdout
    )


@pytest.mark.parametrize(
    "law",
    [
        "elasto_plastic",
        *(pytest.param(law, marks=pytest.mark.accept) for law in ("lugre", "maxwell_slip")),
    ],
)
def test_validate_plays_what_the_loops_identify(law: str, tmp_path: Path) -> None:
    """The identified contact follows loops whose effort has no noise, ten times closer than stick
    and slip."""
    bench, target = tmp_path / "bench.yaml", tmp_path / "model.yaml"
    bench.write_text(BENCH)
    loops = csv(slow_loops(law, 2, COUNT), tmp_path)
    command = ("identify", "--loops", loops, "--bench", bench, "-o", target)
    assert run(*command).code == 0
    other = csv(slow_loops(law, 3, COUNT, TURNS[:6], noise=0.0), tmp_path)
    model = load(target, Model)
    assert model.presliding is not None
    assert model.presliding.law == law
    played = json.loads(run("validate", target, other, "--json").stdout)
    target.write_text(to_yaml(msgspec.structs.replace(model, presliding=None)))
    stuck = json.loads(run("validate", target, other, "--json").stdout)
    assert played["position_error_rel"] < 0.1 * stuck["position_error_rel"]


def test_a_log_of_sliding_is_no_loops(tmp_path: Path) -> None:
    """One line, no model: strokes of a sample log, whose encoder sees many counts."""
    sines = tmp_path / "sines.csv"
    sines.write_text(first_part("sines.csv", 5_000))
    result = run("identify", "--loops", sines, "--bench", CLUTCH)
    refused(result, 1, "no law of presliding fits these loops (the axis must not slip)")


def test_the_clutch_is_refused_in_one_line(tmp_path: Path) -> None:
    target, steps = tmp_path / "model.yaml", CLUTCH.parents[2] / "sample_logs" / "ramp.csv"
    still = tmp_path / "loops.csv"
    rows = steps.read_text().splitlines()[:1] + [
        f"{0.001 * k:.3f},3,{2.0 * np.sin(0.01 * k):.3f}" for k in range(4000)
    ]
    still.write_text("\n".join([*rows, ""]))
    refused(
        run("identify", "--loops", still, "--bench", CLUTCH, "-o", target),
        1,
        "presliding: the longest branch between two reversals has 0 encoder counts",
        "a step of at most",
    )
    assert not target.exists()
    sines = tmp_path / "sines.csv"
    sines.write_text(first_part("sines.csv"))
    method = ("--method", "least-squares")
    both = run("identify", sines, "--loops", still, "--bench", CLUTCH, *method)
    assert both.code == 0, both.stderr
    assert "not identified: presliding: the longest branch" in both.stdout
