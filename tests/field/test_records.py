"""Public records against the values of their publishers, from the command line."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np

from frictool.typing import Vector
from studies.command_line import run
from studies.field.manifest import HERE
from tests.support.measured_data import data

BENCHES = HERE / "benches"
POINTS = 7200  # of the published cogging map over a turn


def identified(*logs: Path, bench: str, options: tuple[object, ...] = ()) -> dict[str, Any]:
    """Identify from logs with a bench of the benchmark; return the JSON."""
    result = run("identify", *logs, "--bench", BENCHES / bench, "--json", *options)
    assert result.code == 0, result.stderr
    return dict(json.loads(result.stdout))


def inside(facts: dict[str, Any], **published: float) -> bool:
    """Return whether the interval of each parameter contains the published value."""
    found = facts["parameters"]
    return all(found[name]["low"] <= v <= found[name]["high"] for name, v in published.items())


def cogging(load: dict[str, Any], turn: Vector) -> Vector:
    """Return the ripple (n,) of a model in N m at positions (n,) in rad."""
    out = np.zeros(turn.size)
    for one in (load["ripple"], *load.get("harmonics", ())):
        wave = 2.0 * np.pi * one["cycles"] / one["per"]["value"]
        out += one["sine"]["value"] * np.sin(wave * turn)
        out += one["cosine"]["value"] * np.cos(wave * turn)
    return out


def test_the_cogging_map_of_a_motor_in_one_direction(tmp_path: Path) -> None:
    """LAAS: the part with their compensation off, from 8.002 s on."""
    log = tmp_path / "off.mcap"
    source = data("field", "laas_cogging", "speed_test.txt")
    run("ingest", source, "--bench", BENCHES / "laas.yaml", "--from", "8.002", "-o", log)
    load = identified(log, bench="laas.yaml")["laws"]["load"]
    text = data("field", "laas_cogging", "cogging_tableau.txt").read_text().partition("{")[2]
    published = np.array([int(one) for one in re.findall(r"-?\d+", text)])
    assert published.size == POINTS
    found = cogging(load, 2.0 * np.pi * np.arange(POINTS) / POINTS)
    shifts = np.arange(-100, 101)
    correlation = [np.corrcoef(np.roll(published, s), found)[0, 1] for s in shifts]
    assert max(correlation) > 0.95
    assert abs(shifts[int(np.argmax(correlation))]) * 360.0 / POINTS <= 1.0


def test_runs_at_constant_speed_and_a_table_of_breakaways() -> None:
    """Kinova: the published line of friction over speed, and a breakaway that rises from 3.0 to
    5.2 N m with the rate."""
    logs = sorted(data("field", "kinova").glob("velocity_*"))
    table = data("field", "kinova", "static_torque_breakaway_point.csv")
    facts = identified(*logs, bench="kinova.yaml", options=("--breakaway-table", table))
    assert inside(facts, viscous=0.695, coulomb=1.382)
    over_rate = facts["breakaway_over_rate"]
    assert over_rate["per_decade"]["low"] > 0.0
    means = [row["mean"]["value"] for row in over_rate["rates"]]
    assert means == sorted(means)
    assert inside(facts, breakaway=3.04)
    assert inside(facts, breakaway=5.175)


def test_a_joint_whose_current_is_in_another_file(tmp_path: Path) -> None:
    """TX40, joint 1, on the joint's side: viscous and Coulomb friction and offset."""
    log = tmp_path / "tx40.mcap"
    files = [data("field", "tx40", f"{name}_data.csv") for name in ("pos_read", "curr")]
    bench = BENCHES / "tx40_1.yaml"
    run("ingest", *files, "--bench", bench, "--resample", "0.001", "-o", log)
    facts = identified(log, bench="tx40_1.yaml")
    assert inside(facts, viscous=8.05, coulomb=7.14, offset=0.392)


def test_a_commanded_torque_is_refused_as_such() -> None:
    """DFKI: a gravity compensation, and a torque at its limit."""
    for name, words in (
        ("gravity_compensation", "gravity compensation"),
        ("pd__1nm_torque_limited_swingup_failure", "a saturated measurement, or a command"),
    ):
        log = data("field", "dfki", f"control_method_{name}__data_measured.csv")
        result = run("identify", log, "--bench", BENCHES / "dfki.yaml")
        assert result.code != 0
        assert words in result.stderr
