"""`export --lang table`: the friction of the engine over speed and position, its band, and tables
for drives."""

from __future__ import annotations

import csv
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from frictool.adapters.axis_model import axis_of, load_of
from frictool.adapters.slip_curve import slip_curve
from frictool.documents.laws import Laws, Load, Regime, Ripple
from frictool.documents.model import Model
from frictool.documents.provenance import digest
from frictool.documents.quantity import Estimate, Quantity
from frictool.documents.registry import load
from frictool.engine.effort_replay import FREE, replay, replay_parameters
from frictool.errors import NoSolutionError
from frictool.export.export_origin import ExportOrigin
from frictool.export.friction_table import NO_ODRIVE, table_files
from frictool.plant.axis import LOAD_POSITION, POSITION, STATE_SIZE, VELOCITY
from studies.command_line import run
from tests.support.command_line import refused
from tests.support.documentation_pages import ROOT

GOLDEN = Path(__file__).parent / "golden"
ORIGIN = ExportOrigin("0" * 64, "frictool export")
NONLINEAR = ROOT / "configs/clutch/nonlinear.yaml"


def estimate(value: float, half_width: float, unit: str) -> Estimate:
    return Estimate(value, value - half_width, value + half_width, unit, source="identified")


@pytest.fixture(scope="module")
def clutch() -> Model:
    """The clutch with Stribeck friction, two regimes, another direction and intervals."""
    made = load(NONLINEAR, Model)
    assert made.laws is not None
    regimes = (
        Regime(Quantity(100.0, 90.0, 120.0, "rad/s"), estimate(4e-4, 1e-4, "N m s/rad")),
        Regime(
            Quantity(260.0, unit="rad/s"),
            estimate(1e-4, 1e-5, "N m s/rad"),
            estimate(2e-4, 1e-5, "N m s/rad"),
        ),
    )
    parameters = replace(
        made.parameters,
        coulomb=estimate(0.12, 0.01, "N m"),
        breakaway=estimate(0.16, 0.02, "N m"),
        viscous=estimate(2e-4, 5e-5, "N m s/rad"),
        stribeck_velocity=estimate(20.0, 5.0, "rad/s"),
    )
    mechanics = replace(made.bench.mechanics, backlash=None, backlash_coulomb=None)
    return replace(
        made,
        law="stribeck",
        parameters=parameters,
        laws=replace(made.laws, regimes=regimes, position=None, stribeck_exponent=1.5),
        bench=replace(made.bench, mechanics=mechanics),
    )


def table(text: str | bytes) -> dict[str, Any]:
    assert isinstance(text, str)
    rows = list(csv.reader(text.splitlines()[1:]))
    return dict(zip(rows[0], np.array(rows[1:], dtype=float).T, strict=True))


def test_an_effort_as_large_as_the_friction_keeps_the_speed(clutch: Model) -> None:
    files, _ = table_files(clutch, ORIGIN, ())
    columns = table(files["clutch_non_linear_friction.csv"])
    p = replay_parameters(axis_of(clutch)._replace(lag=0.0))
    for name, sign in (("forward", 1.0), ("backward", -1.0)):
        for speed, friction in zip(columns["speed [rad/s]"], columns[f"{name} [N m]"], strict=True):
            if speed < 1.0:
                continue
            state = np.zeros(STATE_SIZE)
            state[VELOCITY] = sign * speed
            state[POSITION] = state[LOAD_POSITION] = 30.0  # away from the end stops
            out, speeds = np.empty(2), np.empty(2)
            effort = np.full(2, sign * friction)
            assert replay(p, np.empty(0), state, effort, effort, FREE, 1e-4, out, speeds) == 0
            assert abs(speeds[1]) == pytest.approx(speed, abs=1e-6 * speed)


@given(st.lists(st.floats(0.0, 1.0), min_size=8, max_size=8))
def test_the_band_holds_every_friction_within_the_intervals(
    clutch: Model, places: list[float]
) -> None:
    sides = slip_curve(clutch, forward=False)
    speed = np.linspace(0.0, 400.0, 101)
    low, high = sides.band(speed)
    at = iter(places)

    def drawn(one: Quantity) -> Quantity:
        first, last = one.interval
        return Quantity(first + next(at) * (last - first))

    inside = sides._replace(
        coulomb=drawn(sides.coulomb),
        breakaway=drawn(sides.breakaway),
        viscous=drawn(sides.viscous),
        stribeck_velocity=drawn(sides.stribeck_velocity or Quantity(1.0)),
        knees=tuple(drawn(one) for one in sides.knees),
        slopes=tuple(drawn(one) for one in sides.slopes),
    ).friction(speed)
    assert np.all(inside >= low - 1e-15)
    assert np.all(inside <= high + 1e-15)
    assert np.all(low[1:] < high[1:])


def test_the_drive_s_table_has_few_rows_and_states_its_error(clutch: Model) -> None:
    files, notes = table_files(clutch, ORIGIN, ())
    columns = table(files["clutch_non_linear_frict_comp.csv"])
    speed = columns["speed [rad/s]"]
    assert speed.size == 20
    fine = np.linspace(0.0, 400.0, 20001)
    both = np.mean(
        [slip_curve(clutch, forward=one).friction(fine) for one in (True, False)], axis=0
    )
    error = float(np.max(np.abs(np.interp(fine, speed, columns["friction [N m]"]) - both)))
    (note,) = [line for line in notes if line.startswith("frict_comp")]
    assert note.startswith("frict_comp: 20 rows, interpolation error at most ")
    stated = float(note.split("at most ")[1].split()[0])
    assert stated == pytest.approx(error, rel=0.05)
    assert error < 0.01 * float(both.max())
    np.testing.assert_allclose(columns["current [A]"] * 13.4e-3, columns["friction [N m]"])


def test_moteus_s_table_is_the_ripple_of_one_turn(clutch: Model) -> None:
    ripple = Ripple(
        7.0,
        Quantity(2.0 * math.pi, unit="rad"),  # type: ignore[arg-type]
        estimate(0.01, 0.001, "N m"),
        estimate(-0.02, 0.001, "N m"),
    )
    made = replace(clutch, laws=Laws(load=Load(ripple=ripple)))
    files, _ = table_files(made, ORIGIN, ())
    text = files["clutch_non_linear_moteus.cfg"]
    assert isinstance(text, str)
    first, *rest = text.splitlines()
    assert first.startswith("conf set motor.cogging_dq_scale ")
    scale = float(first.split()[-1])
    assert [line.split()[2] for line in rest] == [f"motor.cogging_dq_comp.{k}" for k in range(1024)]
    entries = np.array([int(line.split()[-1]) for line in rest])
    assert np.abs(entries).max() == 127
    opposing = load_of(made).at(2.0 * np.pi * np.arange(1024) / 1024)
    assert np.max(np.abs(entries * scale * 13.4e-3 - opposing)) <= 0.5001 * scale * 13.4e-3
    columns = table(files["clutch_non_linear_position.csv"])
    np.testing.assert_allclose(
        columns["load [N m]"], load_of(made).at(columns["position [rad]"]), atol=1e-9
    )
    double = replace(ripple, cycles=14.0)
    both = replace(clutch, laws=Laws(load=Load(ripple=ripple, harmonics=(double,))))
    text = table_files(both, ORIGIN, ())[0]["clutch_non_linear_moteus.cfg"]
    assert isinstance(text, str)
    first, *rest = text.splitlines()
    unit = float(first.split()[-1]) * 13.4e-3
    entries = np.array([int(line.split()[-1]) for line in rest])
    opposing = load_of(both).at(2.0 * np.pi * np.arange(1024) / 1024)
    assert np.max(np.abs(entries * unit - opposing)) <= 0.5001 * unit
    odd = replace(made, laws=Laws(load=Load(ripple=replace(ripple, cycles=7.5))))
    files, notes = table_files(odd, ORIGIN, ())
    assert "clutch_non_linear_moteus.cfg" not in files
    assert "no moteus table: 7.5 cycles per turn; allowed: a whole number" in notes
    assert NO_ODRIVE in notes


def test_files_are_those_of_the_folder(tmp_path: Path) -> None:
    result = run(
        "export", NONLINEAR, "--lang", "table", "--without", "backlash", "-o", tmp_path / "out"
    )
    assert result.code == 0, result.stderr
    written = {path.name: path.read_text() for path in (tmp_path / "out").iterdir()}
    assert len(written) == 3
    for name, text in written.items():
        assert digest(NONLINEAR) in text.splitlines()[0]
        assert text.splitlines()[1:] == (GOLDEN / name).read_text().splitlines()[1:], name


def test_refuses_hysteresis_and_a_bench_without_a_top_speed(clutch: Model, tmp_path: Path) -> None:
    refused(
        run("export", NONLINEAR, "--lang", "table", "-o", tmp_path / "out"),
        4,
        "a table cannot represent backlash (backlash of the bench); to omit it, add "
        "--without backlash",
    )
    mechanics = replace(clutch.bench.mechanics, top_speed=None)
    with pytest.raises(NoSolutionError, match=r"add mechanics\.top_speed"):
        table_files(replace(clutch, bench=replace(clutch.bench, mechanics=mechanics)), ORIGIN, ())
