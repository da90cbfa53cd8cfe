"""Loads that a bench declares stay in the model, and a load that the log does not tell widens the
other intervals or is refused."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest

from frictool.documents.laws import Load as LoadLaw
from frictool.documents.load_terms import Term
from frictool.documents.model import Model
from frictool.documents.registry import load as load_document
from frictool.engine.effort_replay import FREE, replay, replay_parameters
from frictool.identify.methods import IdentificationSettings
from frictool.identify.methods import run as fit_by
from frictool.identify.motion_record import MotionRecord, make_record
from frictool.plant.axis import AxisParameters, rest
from frictool.plant.axis_friction_laws import AxisFrictionLevels, AxisLaws
from frictool.plant.position_load import LoadHarmonic, PositionLoad
from frictool.typing import Vector
from studies.command_line import CommandResult
from studies.command_line import run as command
from tests.support.linear_axis import PERIOD
from tests.support.loaded_axis import BENCH, COUNT, Loaded, estimates, rotary_bench

DECLARED: tuple[Term, ...] = ("offset", "spring", "gravity", "viscous_by_direction")
SAMPLES, NOISE, SEEDS = 12_000, 2.0, 20  # N m, standard deviation of the effort's noise
INERTIA, VISCOUS, COULOMB = 4.5, 12.0, 8.0
FINE = 1e-3 * COUNT


def axis_with_small_loads(seed: int) -> Loaded:
    """Return an axis with a spring, gravity and viscous friction by direction, each about as large
    as its interval is wide."""
    draw, time = np.random.default_rng([seed, 12]), np.arange(SAMPLES) * PERIOD
    truth = {"inertia": 5.0 * draw.uniform(0.8, 1.2), "viscous": 12.0 * draw.uniform(0.7, 1.3)}
    truth |= {"coulomb": 8.0 * draw.uniform(0.7, 1.3), "offset": draw.uniform(-1.0, 1.0)}
    truth |= {
        "stiffness": draw.uniform(0.0, 0.5),
        "gravity_sine": draw.uniform(-0.5, 0.5),
        "gravity_cosine": draw.uniform(-0.5, 0.5),
    }
    truth["viscous_backward"] = truth["viscous"] * draw.uniform(0.98, 1.02)
    level = truth["coulomb"]
    sliding = {name: truth[name] for name in ("inertia", "viscous", "coulomb", "offset")}
    axis = AxisParameters(
        **sliding,
        breakaway=level,
        laws=AxisLaws(backward=AxisFrictionLevels(truth["viscous_backward"], level, level)),
    )
    load = PositionLoad(
        truth["stiffness"], (LoadHarmonic(1.0, truth["gravity_sine"], truth["gravity_cosine"]),)
    )
    swings = ((25.0, 0.9), (18.0, 0.37), (11.0, 0.23))
    effort = sum(a * np.sin(2.0 * np.pi * f * time + draw.uniform(0.0, 6.0)) for a, f in swings)
    x, v = np.empty(SAMPLES), np.empty(SAMPLES)
    assert (
        replay(
            replay_parameters(axis),
            load.as_array(),
            rest(draw.uniform(-0.2, 0.2)),
            effort,
            effort,
            FREE,
            PERIOD,
            x,
            v,
        )
        == 0
    )
    noisy = effort + NOISE * draw.standard_normal(SAMPLES)
    return Loaded(
        truth,
        make_record("loaded", time, np.floor(x / COUNT) * COUNT, noisy, COUNT, 0.0),
        rotary_bench(DECLARED),
    )


@pytest.mark.parametrize(
    "method", ["least-squares", pytest.param("weighted", marks=pytest.mark.accept)]
)
def test_small_declared_loads_leave_the_other_intervals_honest(method: str) -> None:
    """Fewer than 16 of 20 intervals of 95 % hold the truth by chance once in 400 draws."""
    held: Counter[str] = Counter()
    given: Counter[str] = Counter()
    for seed in range(SEEDS):
        axis = axis_with_small_loads(seed)
        found = estimates(fit_by(method, [axis.record], axis.bench, IdentificationSettings()))
        given.update(list(found))
        held.update(name for name, one in found.items() if one.low <= axis.truth[name] <= one.high)
    assert min(given[name] for name in axis.truth) >= 18, given
    assert all(held[name] >= given[name] - 4 for name in given), held


def identified(
    folder: Path, record: MotionRecord, load: str, count: float, *options: str
) -> tuple[CommandResult, Path]:
    """Run `identify` on a record with a bench that declares this load and an encoder with this
    count in rad."""
    bench, log, target = folder / "bench.yaml", folder / "log.csv", folder / "model.yaml"
    bench.write_text(
        BENCH.replace(f"{2.0 * np.pi / COUNT:.10g}", f"{2.0 * np.pi / count:.10g}")
        + f"load: {load}\n"
    )
    rows = np.column_stack((record.time, np.rint(record.position / count), record.effort))
    np.savetxt(log, rows, delimiter=",", header="time,encoder,torque", comments="", fmt="%.10g")
    return command("identify", log, "--bench", bench, "-o", target, *options), target


def driven_along(
    swings: Sequence[tuple[float, float]],
    middle: float,
    load: Callable[[Vector], Vector],
    noise: float,
) -> MotionRecord:
    """Return the log of an axis that follows sines, each with its amplitude in rad and angular
    frequency in rad/s, under a load of x.

    The effort is held over a sample, and is that of its middle. The axis has no offset.
    """
    time = np.arange(10_000) * PERIOD

    def motion(at: Vector) -> tuple[Vector, Vector, Vector]:
        x = sum((a * np.sin(w * at) for a, w in swings), np.full(at.size, middle))
        v = sum((a * w * np.cos(w * at) for a, w in swings), np.zeros(at.size))
        return x, v, -sum((a * w * w * np.sin(w * at) for a, w in swings), np.zeros(at.size))

    x, v, acceleration = motion(time + 0.5 * PERIOD)
    effort = INERTIA * acceleration + VISCOUS * v + COULOMB * np.sign(v) + load(x)
    effort += noise * np.random.default_rng(5).standard_normal(time.size)
    return make_record("driven", time, motion(time)[0], effort, FINE, 0.0)


def laws_of(path: Path) -> LoadLaw:
    """Return the load of a model file."""
    laws = load_document(path, Model).laws
    assert laws is not None
    assert laws.load is not None
    return laws.load


@pytest.mark.parametrize("method", ["output-error", pytest.param("auto", marks=pytest.mark.accept)])
def test_declared_loads_stay_in_the_model(tmp_path: Path, method: str) -> None:
    axis = axis_with_small_loads(0)
    result, target = identified(
        tmp_path,
        axis.record,
        "{terms: [offset, spring, viscous_by_direction]}",
        COUNT,
        "--method",
        method,
    )
    assert result.code == 0, result.stderr
    assert "load in addition to friction: spring" in result.stdout
    laws = load_document(target, Model).laws
    assert laws is not None
    assert laws.backward is not None
    assert laws_of(target).stiffness is not None


@pytest.mark.parametrize("most", ["", ", most: {value: 4, unit: N m}"])
def test_gravity_that_the_travel_does_not_tell_widens_the_offset(tmp_path: Path, most: str) -> None:
    """Over two degrees 3 sin x - 2 cos x is a constant, and the axis has no offset."""
    record = driven_along(
        [(0.014, 9.0), (0.0035, 4.1)], 0.4, lambda x: 3.0 * np.sin(x) - 2.0 * np.cos(x), 0.03
    )
    result, target = identified(tmp_path, record, f"{{terms: [offset, gravity]{most}}}", FINE)
    assert result.code == 0, result.stderr
    assert "move further" in result.stdout
    model = load_document(target, Model)
    low, high = model.parameters.offset.interval
    assert low <= 0.0 <= high
    assert high - low > 2.0
    if most:
        # a load of at most 4 N m moves the offset by 4 N m, and by a little more for the spring
        assert high - low < 10.0
    for name, truth in (("inertia", INERTIA), ("viscous", VISCOUS), ("coulomb", COULOMB)):
        low, high = getattr(model.parameters, name).interval
        assert low <= truth <= high, name


@pytest.mark.parametrize("method", ["auto", pytest.param("output-error", marks=pytest.mark.accept)])
def test_a_spring_that_one_sine_does_not_tell_from_the_inertia_holds_the_range_of_the_bench(
    tmp_path: Path, method: str
) -> None:
    """Along a sine the position is the acceleration times a constant: only the inertia of the bench
    tells the stiffness."""
    omega = np.pi
    record = driven_along([(0.4, omega)], 0.0, lambda x: 20.0 * x, 0.3)
    result, target = identified(
        tmp_path, record, "{terms: [offset, spring]}", COUNT, "--method", method
    )
    assert result.code == 0, result.stderr
    assert "the loads over the position are fitted with the bench's inertia" in " ".join(
        result.stdout.split()
    )
    stiffness = laws_of(target).stiffness
    assert stiffness is not None
    low, high = stiffness.interval
    assert low <= 20.0 <= high
    assert high - low == pytest.approx(
        2.0 * 2.0 * omega**2, rel=0.1
    )  # the bench knows the inertia to +-2 kg m^2
    assert load_document(target, Model).parameters.inertia.source == "bench"


@pytest.mark.parametrize(
    "options", [("power-balance", "--time-constant", "0.01"), ("weak",), ("recursive",)]
)
def test_a_method_that_does_not_know_a_declared_load_is_refused(
    tmp_path: Path, options: tuple[str, ...]
) -> None:
    result, target = identified(
        tmp_path,
        axis_with_small_loads(0).record,
        "{terms: [offset, spring]}",
        COUNT,
        "--method",
        *options,
    )
    assert result.code == 1
    assert "cannot fit load.terms of the bench (offset, spring)" in result.stdout + result.stderr
    assert not target.exists()
