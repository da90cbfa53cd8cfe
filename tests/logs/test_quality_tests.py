"""The kind of test and the signs of a log, on the sample logs and on motions of a mass with
friction."""

from __future__ import annotations

from typing import get_args

import numpy as np
import pytest
import scipy.io

from frictool.documents.bench import Bench, Column, Encoder
from frictool.logs.log import Stream
from frictool.logs.quality.kind_recognition import Kind, kind_of
from frictool.logs.quality.log_kinds import KINDS
from frictool.logs.quality.sign_check import reversal, sign_of
from tests.support.example_logs import ROOT, bench, measured

T = np.arange(8000) / 1000.0


def stream(**signals: np.ndarray) -> Stream:
    return Stream(
        "/axis",
        np.arange(next(iter(signals.values())).size) / 1000.0,
        signals,
        dict.fromkeys(signals, ""),
    )


def sample(name: str) -> Stream:
    _, counts, current = np.loadtxt(
        ROOT / "sample_logs" / f"{name}.csv", delimiter=",", skiprows=1, unpack=True
    )
    return stream(position=counts * 2 * np.pi / 56, current=current)


def emps(**signs: float) -> Stream:
    names = {"position": "qm", "reference": "qg", "voltage": "vir"}
    content = scipy.io.loadmat(measured("emps/DATA_EMPS.mat"), squeeze_me=True)
    return stream(
        **{name: signs.get(name, 1.0) * content[column] for name, column in names.items()}
    )


@pytest.mark.parametrize("kind", ["sines", "ramp", "steps"])
def test_the_sample_logs_are_what_they_are_called(kind: str):
    assert kind_of(sample(kind)) == kind


def test_every_kind_is_explained():
    assert set(get_args(Kind)) == set(KINDS)


def test_kinds_of_constructed_logs():
    position = np.sin(2 * np.pi * T) + 0.5 * np.sin(2 * np.pi * 2.3 * T)
    assert kind_of(stream(position=position, reference=position)) == "sines"
    assert kind_of(stream(position=np.zeros(8000), current=T)) == "rest"
    assert kind_of(stream(position=T**2)) == "stroke"
    rng = np.random.default_rng(3)
    wandering = np.cumsum(rng.normal(size=8000))
    assert (
        kind_of(stream(position=np.cumsum(wandering) / 8000.0 % 50, current=rng.normal(size=8000)))
        == "free"
    )
    jumping = np.where(T % 2.0 < 1.0, 0.0, 5.0)
    assert kind_of(stream(position=position, reference=jumping)) == "steps"
    assert kind_of(stream(current=T)) is None
    assert kind_of(stream(position=T[:20])) is None


def test_the_measured_machine_follows_trapezoids_and_no_sines():
    assert kind_of(emps()) == "free"


@pytest.mark.parametrize("kind", ["sines", "ramp", "steps"])
def test_a_reversed_sensor_of_the_sample_logs_is_found(kind: str):
    good = sample(kind)
    assert sign_of(good).reversed == ()
    assert sign_of(good).text() is None
    bad = stream(position=-good.signals["position"], current=good.signals["current"])
    assert sign_of(bad).reversed == ("position or current",)
    assert "takes energy from the axis" in str(sign_of(bad).text())


def test_the_reference_tells_which_sensor_is_reversed():
    assert sign_of(emps()).reversed == ()
    assert sign_of(emps(voltage=-1.0)).reversed == ("voltage",)
    assert sign_of(emps(position=-1.0)).reversed == ("position",)
    assert sign_of(emps(position=-1.0, reference=-1.0)).reversed == ("voltage",)


def test_a_velocity_against_its_position_is_named():
    position = np.sin(2 * np.pi * T)
    found = sign_of(stream(position=position, velocity=-np.cos(2 * np.pi * T)))
    assert found.reversed == ("velocity",)
    assert "change of position have opposite signs" in str(found.text())


@pytest.mark.parametrize("spring", [0.0, 40.0])
def test_a_mass_with_friction_and_a_spring_takes_work(spring: float):
    """F = m a + c sign(v) + k x over whole strokes: the mass and the spring give back what they
    take."""
    position, omega = np.sin(2 * np.pi * T), 2 * np.pi
    velocity, acceleration = omega * np.cos(omega * T), -(omega**2) * position
    force = 2.0 * acceleration + 30.0 * np.sign(velocity) + spring * position
    assert sign_of(stream(position=position, effort=force)).reversed == ()
    assert sign_of(stream(position=position, effort=-force)).reversed == ("position or effort",)


def test_a_frictionless_axis_tells_nothing_of_signs():
    position = np.sin(2 * np.pi * T)
    for sign in (1.0, -1.0):
        assert sign_of(stream(position=position, effort=sign * position)).reversed == ()


def rig(unit: str, scale: float = 1.0, direction: int = 1, *, reference: bool = False) -> Bench:
    columns = {"position": Column("x", unit, scale=scale), "current": Column("i", "A", scale=0.5)}
    if reference:
        columns["reference"] = Column("r", unit)
    return bench(columns, Encoder(counts_per_revolution=100, direction=direction))


@pytest.mark.parametrize(
    ("name", "document", "advice"),
    [
        ("position", rig("count"), "encoder.direction: -1 in the bench (found: 1)"),
        ("position", rig("count", direction=-1), "encoder.direction: 1 in the bench (found: -1)"),
        ("position", rig("deg", 2.0), "columns.position.scale: -2 in the bench"),
        ("position", rig("deg", direction=-1), "columns.position.scale: -1 in the bench"),
        ("effort", rig("deg"), "columns.current.scale: -0.5 in the bench"),
        ("position or effort", rig("deg"), "columns.position.scale: -1 in the bench"),
        # position and reference must not contradict each other afterwards
        ("position or effort", rig("deg", reference=True), "columns.current.scale: -0.5"),
        ("position or current", rig("count"), "encoder.direction: -1 in the bench"),
    ],
)
def test_the_advice_has_an_effect_on_the_reversed_signal(
    name: str, document: Bench, advice: str
) -> None:
    assert reversal(name, document).startswith(f"set {advice}")


def test_without_a_bench_the_column_is_named() -> None:
    assert "columns.velocity.scale" in reversal("velocity", None)
    assert "encoder.direction" not in reversal("position", None)
