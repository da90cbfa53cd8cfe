"""A load that changes abruptly at a position: a preloaded limp-home spring, or a bumper."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from pathlib import Path

import msgspec
import numpy as np
import pytest

from frictool.documents.bench import Bench
from frictool.documents.laws import Laws, Load
from frictool.documents.model import Model, Parameters
from frictool.documents.provenance import Provenance
from frictool.documents.quantity import Estimate, Quantity, Span, si_unit
from frictool.documents.registry import load
from frictool.documents.valid_side import ValidSide
from frictool.identify.estimators.explanation_search import search_explanations
from frictool.identify.identification import Identification, identify_records
from frictool.identify.load_kink import LoadKink, load_kink
from frictool.identify.methods import IdentificationSettings
from frictool.identify.model_document import model_of
from frictool.identify.motion_record import MotionRecord, make_record
from frictool.identify.validate.validation import validate
from frictool.logs.log import Log, Stream
from frictool.typing import Vector
from tests.support.linear_axis import PERIOD
from tests.support.loaded_axis import BENCH, COUNT, rotary_bench

SETTINGS = IdentificationSettings()
TRAVEL = 1.5  # rad
TRUTH = {"inertia": 5.0, "viscous": 12.0, "coulomb": 8.0, "offset": 3.0}
Effort = Callable[[Vector, Vector], Vector]  # of position and direction


def recorded(seed: int, effort: Effort, strokes: int = 16) -> MotionRecord:
    """Return a record of smooth strokes over most of the travel, by inverse dynamics."""
    draw = np.random.default_rng(seed)
    ends = np.where(np.arange(strokes + 1) % 2, draw.uniform(1.2, 1.5, strokes + 1), 0.0)
    ends = np.where(ends > 0.0, ends, draw.uniform(0.0, 0.2, strokes + 1))
    parts = []
    for start, end in itertools.pairwise(ends.tolist()):
        s = np.arange(1, 1 + round(draw.uniform(0.5, 1.2) / PERIOD)) * PERIOD
        s = s / s[-1]
        parts.append(start + (end - start) * s**3 * (10.0 - 15.0 * s + 6.0 * s**2))
    x = np.concatenate(parts)
    v = np.gradient(x, PERIOD)
    direction = np.sign(np.where(np.abs(v) > 1e-9, v, 0.0))
    u = TRUTH["inertia"] * np.gradient(v, PERIOD) + TRUTH["viscous"] * v
    u += TRUTH["coulomb"] * direction + TRUTH["offset"] + effort(x, direction)
    u += 0.1 * draw.standard_normal(u.size)
    time = np.arange(x.size) * PERIOD
    return make_record("kink", time, np.floor(x / COUNT) * COUNT, u, COUNT, 0.0)


def limp_home(knot: float, jump: float) -> Effort:
    """Return a spring of 4 N m/rad above the knot, and one of 20 N m/rad below a jump."""
    return lambda x, _: np.where(x > knot, 4.0 * x, 4.0 * knot - jump + 20.0 * (x - knot))


def with_travel(bench: Bench) -> Bench:
    travel = msgspec.structs.replace(bench.mechanics, travel=Span(0.0, 2.0, "rad"))
    return msgspec.structs.replace(bench, mechanics=travel)


def searched(record: MotionRecord, bench: Bench) -> LoadKink | None:
    """Return the kink that is found next to the loads of `auto`."""
    load, _ = search_explanations([record], bench, SETTINGS)
    return load_kink([record], bench, load, SETTINGS)


def identified(record: MotionRecord, bench: Bench) -> Identification:
    """Return the identification by the default method."""
    return identify_records([record], [], bench, "auto", SETTINGS)


@pytest.mark.parametrize(
    ("seed", "knot", "jump"),
    [(2, 1.1, -6.0), pytest.param(1, 0.3, 12.0, marks=pytest.mark.accept)],
)
def test_the_model_holds_on_the_larger_side_of_a_jump(seed: int, knot: float, jump: float) -> None:
    """Position and size of the jump are named; no gravity or ripple replaces the jump."""
    result = identified(recorded(seed, limp_home(knot, jump)), rotary_bench(None))
    (warning,) = (one for one in result.warnings if "load changes by" in one)
    size, place = (float(warning.split(word)[1].split()[0]) for word in ("by", " at"))
    assert size == pytest.approx(abs(jump), rel=0.03)
    assert place == pytest.approx(knot, abs=0.01)
    assert ("above" if knot < 0.5 * TRAVEL else "below") in warning
    assert len(warning) <= 190
    assert result.refused["load"] in warning
    side = model_of(result, rotary_bench(None), Provenance("test", "0")).valid_side
    assert side is not None
    assert result.logged is not None
    assert result.logged.high - result.logged.low > 0.75 * TRAVEL  # both sides are logged
    positions = rotary_bench(None), with_travel(rotary_bench(None))
    for bench, known in zip(positions, (None, result.logged), strict=True):
        assert model_of(result, bench, Provenance("test", "0")).logged_positions == known
    assert side.side in warning
    assert side.of.interval[0] <= knot <= side.of.interval[1]
    assert result.laws is not None
    assert result.laws.load is not None
    stiffness = result.laws.load.stiffness
    assert stiffness is not None
    truth = {**TRUTH, "stiffness": 4.0}
    if knot > 0.5 * TRAVEL:
        truth |= {"stiffness": 20.0, "offset": TRUTH["offset"] - jump - 16.0 * knot}
    for name, interval in {**result.identified, "stiffness": stiffness}.items():
        if name in truth:
            low, high = interval.low or 0.0, interval.high or 0.0
            assert low <= truth[name] <= high
    assert {"inertia", "viscous", "coulomb", "offset"} <= result.identified.keys()


def test_a_bumper_changes_the_stiffness() -> None:
    """A stop of rubber engages without preload."""
    record = recorded(3, lambda x, _: 80.0 * np.maximum(x - 0.9, 0.0))
    kink = searched(record, rotary_bench(None))
    assert kink is not None
    assert kink.position == pytest.approx(0.9, abs=0.03)
    assert kink.jump == 0.0 or abs(kink.jump) < 0.2 * TRUTH["coulomb"]
    assert kink.bend == pytest.approx(80.0, rel=0.1)
    shown = f"the stiffness of the load changes by {kink.bend:.3g} N m/rad"
    assert shown in kink.shown(rotary_bench(None))


def test_a_contact_that_stiffens_is_found_through_a_gear_with_friction() -> None:
    """The gear needs 1.5 times as much effort against the contact as with it."""
    pad = 40.0 / 0.4**2
    record = recorded(9, lambda x, way: pad * (1.0 + 0.2 * way) * np.maximum(x - 0.95, 0.0) ** 2)
    kink = searched(record, rotary_bench(None))
    assert kink is not None
    assert kink.position == pytest.approx(0.95, abs=0.03)
    assert not kink.above
    assert kink.rise == pytest.approx(pad * (record.position.max() - 0.95) ** 2, rel=0.05)
    assert kink.shown(rotary_bench(None)).startswith(f"a load that rises to {kink.rise:.3g} N m")
    assert len(kink.warning(rotary_bench(None))) <= 190


@pytest.mark.parametrize(
    "effort",
    [
        lambda x, direction: 0.0 * x,
        lambda x, direction: 4.0 * direction * (x > 0.7),
        lambda x, direction: 60.0 * direction * np.maximum(x - 0.9, 0.0) ** 2,
        lambda x, direction: 3.0 * direction * np.sin(4.0 * x),
        lambda x, direction: 6.0 * np.sin(3.0 * x + 0.5),
        lambda x, direction: 1.5 * np.sin(25.0 * x),
        lambda x, direction: 8.0 * np.sin(x),
        lambda x, direction: 10.0 * x,
    ],
    ids=["none", "seal", "drag", "friction", "wave", "cogging", "gravity", "spring"],
)
def test_friction_and_smooth_loads_are_no_kink(effort: Effort) -> None:
    """A step of the friction changes its sign with the direction; a load does not."""
    assert searched(recorded(4, effort), rotary_bench(None)) is None


def test_a_small_jump_is_left_to_the_other_effects() -> None:
    """A jump below a fifth of the Coulomb friction is no warning."""
    record = recorded(5, lambda x, _: np.where(x > 0.7, 0.1 * TRUTH["coulomb"], 0.0))
    assert searched(record, rotary_bench(None)) is None


def test_a_declared_load_does_not_hide_a_jump() -> None:
    """The bench names a spring, which is right on either side only."""
    bench = rotary_bench(("offset", "spring"))
    kink = searched(recorded(6, limp_home(0.4, 10.0)), bench)
    assert kink is not None
    assert kink.jump == pytest.approx(10.0, rel=0.03)


def test_validate_judges_the_valid_side_only(tmp_path: Path) -> None:
    """The other side neither contradicts the model nor hides a wrong friction on the valid side."""
    (tmp_path / "bench.yaml").write_text(BENCH)
    bench = load(tmp_path / "bench.yaml", Bench)
    one = {
        name: Estimate(value, unit=si_unit(dimension, "rotary"), source="identified")
        for (name, value), dimension in zip(
            TRUTH.items(), ("inertia", "viscous", "effort", "effort"), strict=True
        )
    }
    parameters = Parameters(**one, breakaway=one["coulomb"])
    spring = Estimate(4.0, unit="N m/rad", source="identified")
    knot = Quantity(0.4, 0.39, 0.41, "rad")
    origin = Provenance("test", "0")
    model = Model(
        "model/1", "arm", "rotary", "coulomb", "auto", 0.95, bench, parameters, origin,
        laws=Laws(load=Load(stiffness=spring)), valid_side=ValidSide("above", knot),
    )  # fmt: skip
    log = log_of(recorded(8, limp_home(0.4, 25.0)))
    judgement = validate(model, log).judgement
    assert judgement.holds
    assert judgement.error is not None
    assert judgement.error < 0.03
    whole = validate(msgspec.structs.replace(model, valid_side=None), log).judgement
    assert whole.holds is False
    other = ValidSide("below", knot)
    beyond = validate(msgspec.structs.replace(model, valid_side=other), log).judgement
    assert beyond.holds is None
    assert "where the model is valid" in beyond.line
    heavy = msgspec.structs.replace(one["inertia"], value=1.5 * TRUTH["inertia"])
    wrong = msgspec.structs.replace(parameters, inertia=heavy)
    assert validate(msgspec.structs.replace(model, parameters=wrong), log).judgement.holds is False


def log_of(record: MotionRecord) -> Log:
    signals = {"position": record.position, "effort": record.effort}
    units = {"position": "rad", "effort": "N m"}
    return Log((Stream("/axis", record.time, signals, units),), {}, "strokes")


def test_one_side_has_no_sample_of_the_other() -> None:
    """Each passage of the knot begins a new part of the record."""
    record = recorded(7, limp_home(0.4, 10.0))
    kink = LoadKink(0.4, 0.01, 10.0, 0.0, 0.0, True, 0.1)
    part = kink.one_side(record)
    assert part is not None
    assert part.position.min() > 0.41
    entries = np.diff((record.position > 0.41).astype(int)) > 0
    assert part.piece[-1] + 1 == np.count_nonzero(entries)
    assert np.all(np.diff(part.time)[np.diff(part.piece) == 0] < 1.5 * PERIOD)
    below = LoadKink(-0.4, 0.01, 10.0, 0.0, 0.0, False, 0.1)
    assert below.one_side(record) is None
