"""Competing explanations: the effect that acts is found, and no load is claimed in its place."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import msgspec
import numpy as np
import pytest

from frictool.adapters.axis_model import load_law
from frictool.documents.bench import Bench
from frictool.documents.laws import Gravity, Laws, Load
from frictool.documents.load_terms import LoadTerms, RipplePeriod, Term
from frictool.documents.quantity import Estimate, Quantity
from frictool.documents.registry import load as load_document
from frictool.identify import identify
from frictool.identify.estimators.explanation_search import _certain, search_explanations
from frictool.identify.estimators.load_hypotheses import harmonic
from frictool.identify.estimators.position_spectrum import highest_peak
from frictool.identify.estimators.searched_records import SearchedRecords
from frictool.identify.fit_result import Explanation, SlidingFit, UnusableLogs
from frictool.identify.fit_warnings import unstable_load_warnings
from frictool.identify.identification import identify_records
from frictool.identify.methods import IdentificationSettings, run
from frictool.identify.motion_record import MotionRecord, make_record, record_of
from frictool.identify.regression.joint_test import joint_probability
from frictool.identify.regression.tsqr import triangles
from frictool.identify.rows import effects
from frictool.identify.rows.slip_fit import stroke_samples
from frictool.identify.rows.smoothing import smoothed
from frictool.identify.rows.strokes import find_strokes
from frictool.identify.text_view import explanation_line, explanation_place
from frictool.logs.channels.bench_match import match_bench
from frictool.typing import Vector
from studies.rigs.identification_rigs import record
from studies.rigs.sample_logs import sines
from studies.violations.families import draw_violation
from studies.violations.machine import draw_machine, generator_of
from studies.violations.recording import record as record_machine
from tests.identify.arm import PERIOD, Arm, play, write_bench
from tests.support.identification_statistics import experiment
from tests.support.linear_axis import linear_bench
from tests.support.loaded_axis import COUNT, Loaded, loaded_axis, rotary_bench

Extra = Callable[[Vector, Vector, Vector, Vector], Vector]
USUAL = IdentificationSettings()


def needing(axis: Loaded, extra: Extra) -> MotionRecord:
    """Return the record of a motor that also supplies extra(t, x, v, s) along the same motion."""
    record = axis.record
    velocity = np.nan_to_num(smoothed(record, 21)[1])
    share = (record.time - record.time[0]) / float(np.ptp(record.time))
    more = extra(share, record.position, velocity, find_strokes(record).sign)
    return replace(record, effort=record.effort + more)


def drift(t: Vector, x: Vector, v: Vector, s: Vector) -> Vector:
    return 2.0 * np.sin(4.0 * t)


def warming(t: Vector, x: Vector, v: Vector, s: Vector) -> Vector:
    return (4.0 * s + 5.0 * v) * (np.exp(-3.0 * t) - 0.3)


def over_travel(t: Vector, x: Vector, v: Vector, s: Vector) -> Vector:
    return 2.5 * s * np.sin(1.5 * x)


EFFECTS: dict[Term, Extra] = {
    "drift": drift,
    "warming": warming,
    "friction_over_position": over_travel,
}


def claims(fit: SlidingFit) -> set[str]:
    """Return the loads that a fit claims."""
    load = None if fit.laws is None else fit.laws.load
    names = ("stiffness", "gravity", "ripple")
    return set() if load is None else {one for one in names if getattr(load, one) is not None}


def used(fit: SlidingFit) -> list[str]:
    """Return the explanations that a fit used."""
    return [one.name for one in fit.explanations if one.state == "used"]


@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.accept)])
@pytest.mark.parametrize("kind", list(EFFECTS))
def test_an_effect_is_not_taken_for_a_load(kind: Term, seed: int) -> None:
    axis = loaded_axis(seed, "", known=False)
    fit = run("auto", [needing(axis, EFFECTS[kind])], axis.bench, USUAL)
    assert used(fit) == [kind]
    assert not claims(fit)
    for name in ("inertia", "viscous", "coulomb"):
        assert fit.parameters[name].value == pytest.approx(axis.truth[name], rel=0.08), name


@pytest.mark.parametrize("seed", [1, *(pytest.param(k, marks=pytest.mark.accept) for k in (2, 3))])
@pytest.mark.parametrize("scale", [1.0, 5.0])
def test_an_eccentric_encoder_is_not_gravity(scale: float, seed: int) -> None:
    """Scaled, the same efforts move a fifth of the inertia over more than a turn.

    Over less than a turn other loads look alike, and the eccentricity is left in the residual.
    """
    axis = loaded_axis(seed, "", known=False)
    x, count = scale * axis.record.position, scale * COUNT
    assert (np.ptp(x) > 2.0 * math.pi) == (scale > 1.0)
    read = np.floor((x + 0.05 * np.sin(x + 1.0)) / count) * count
    record = replace(axis.record, position=read, resolution=count)
    fit = run("auto", [record], axis.bench, USUAL)
    assert not claims(fit)
    if scale > 1.0:
        assert used(fit) == ["eccentricity"]
        inertia = axis.truth["inertia"] / scale
        assert fit.parameters["inertia"].value == pytest.approx(inertia, rel=0.02)
    else:
        assert "eccentricity" not in used(fit)
        assert any("eccentric" in " ".join((one.what, *one.rivals)) for one in fit.explanations)


def swinging(seed: int, cycles: int) -> tuple[Loaded, dict[str, float]]:
    """Return an axis that swings over 200 deg with gravity and a ripple, and the true loads."""
    draw = np.random.default_rng([seed, 5])
    time = np.arange(30_000) * 1e-3
    x = np.zeros(time.size)
    for amplitude, f in ((1.0, 0.31), (0.5, 0.57), (0.25, 1.1)):
        x += amplitude * np.sin(2.0 * np.pi * f * time + draw.uniform(0.0, 6.0))
    v: Vector = np.gradient(x, time)
    truth = {name: draw.uniform(0.5, 2.0) * draw.choice((-1.0, 1.0)) for name in "abcd"}
    effort: Vector = 5.0 * np.gradient(v, time) + 12.0 * v + 8.0 * np.sign(v)
    effort += truth["a"] * np.sin(x) + truth["b"] * np.cos(x)
    effort += 0.4 * (truth["c"] * np.sin(cycles * x) + truth["d"] * np.cos(cycles * x))
    effort += 0.05 * draw.standard_normal(time.size)
    log = make_record("log", time, np.floor(x / COUNT) * COUNT, effort, COUNT, 0.0)
    return Loaded({}, log, rotary_bench(None)), truth


@pytest.mark.parametrize(
    ("cycles", "axes", "least"),
    [(3, 2, 3), *(pytest.param(k, 6, 10, marks=pytest.mark.accept) for k in (2, 3))],
)
def test_a_ripple_of_about_one_period_in_the_travel_is_not_a_spring(
    cycles: int, axes: int, least: int
) -> None:
    """Without this ripple, a spring and a shorter ripple take its place, and gravity is wrong."""
    held = []
    for seed in range(axes):
        axis, truth = swinging(seed, cycles)
        fit = run("auto", [axis.record], axis.bench, USUAL)
        assert claims(fit) == {"gravity", "ripple"}
        assert fit.laws is not None
        assert fit.laws.load is not None
        ripple = fit.laws.load.ripple
        assert ripple is not None
        assert ripple.cycles == cycles
        gravity = fit.laws.load.gravity
        assert gravity is not None
        for found, true in ((gravity.sine, truth["a"]), (gravity.cosine, truth["b"])):
            low, high = found.interval
            held.append(low <= true <= high)
    assert sum(held) >= least


def pulled(seed: int, stiffness: float, bench: Bench) -> MotionRecord:
    """Return the record of an axis with a spring [N m/rad | N/m] along given strokes."""
    draw = np.random.default_rng([seed, 6])
    time = np.arange(10_000) * 1e-3
    x = np.full(time.size, draw.uniform(-0.1, 0.1))
    for amplitude, f in ((0.2, 0.61), (0.1, 1.3), (0.05, 2.9)):
        x += amplitude * np.sin(2.0 * np.pi * f * time + draw.uniform(0.0, 6.0))
    v: Vector = np.gradient(x, time)
    effort: Vector = 5.0 * np.gradient(v, time) + 12.0 * v + 8.0 * np.sign(v) + stiffness * x
    effort += 0.05 * draw.standard_normal(time.size)
    return make_record("log", time, np.floor(x / COUNT) * COUNT, effort, COUNT, 0.0)


@pytest.mark.parametrize("seed", [0, *(pytest.param(k, marks=pytest.mark.accept) for k in (1, 2))])
def test_a_spring_of_negative_stiffness_is_reported_and_not_used(seed: int) -> None:
    """An axis that a controller holds at an unstable equilibrium needs less effort further out."""
    bench = linear_bench()
    stable, _ = search_explanations([pulled(seed, 20.0, bench)], bench, USUAL)
    assert stable is not None
    assert "spring" in stable.terms
    load, found = search_explanations([pulled(seed, -20.0, bench)], bench, USUAL)
    assert load is None or "spring" not in load.terms
    left = [one.what for one in found if one.state == "left"]
    assert left[0] == "a spring of negative stiffness"


@pytest.mark.parametrize(("sine", "doubt"), [(4.0, False), (-4.0, True)])
def test_gravity_that_makes_the_whole_log_unstable_is_a_warning(sine: float, doubt: bool) -> None:
    """Within 0.5 rad of the position 0, gravity falls with the position if its sine is negative."""
    bench = rotary_bench(None)
    log = pulled(1, 0.0, bench)
    log = replace(log, effort=log.effort + sine * np.sin(log.position))
    weight = Gravity(*(Estimate(value=one, unit="N m", source="identified") for one in (sine, 0.0)))
    fit = SlidingFit({}, {}, 0.0, None, 1.0, 1, laws=Laws(load=Load(gravity=weight)))
    warnings = unstable_load_warnings(fit, [log], bench)
    assert bool(warnings) == doubt
    if doubt:
        assert "the load falls by 3." in warnings[0]
        assert len(warnings[0]) < 190


@pytest.mark.parametrize(("number", "used"), [(0, "delay"), (2, "resonance")])
def test_the_interval_includes_a_spring_that_looks_like_another_effect(
    number: int, used: str, tmp_path: Path
) -> None:
    """Between equal moves through a coarse encoder, the spring predicts worse than the effect."""
    recording = record_machine(draw_violation("s14", "spring", number), str(number))
    path = tmp_path / "bench.yaml"
    path.write_text(recording.bench)
    found = identify([recording.log], load_document(path, Bench)).result
    assert [one.name for one in found.fit.explanations if one.state == "used"] == [used]
    inertia = found.identified["inertia"]
    assert inertia.low <= recording.truth["inertia"] <= inertia.high


def test_late_effort_is_a_delay() -> None:
    axis = loaded_axis(3, "", known=False)
    late = replace(axis.record, effort=np.roll(axis.record.effort, 8))
    fit = run("auto", [late], axis.bench, USUAL)
    assert used(fit) == ["delay"]
    assert fit.effects["delay"].value == pytest.approx(8e-3, rel=0.25)


@pytest.mark.parametrize("share", [0.2, -0.2])
def test_friction_under_the_inertial_load_only_adds_to_the_effort(share: float) -> None:
    """A load that presses the surfaces together cannot reduce their friction."""
    axis = loaded_axis(1, "", known=False)

    def pressed(t: Vector, x: Vector, v: Vector, s: Vector) -> Vector:
        acceleration = np.gradient(v, axis.record.period)
        return share * axis.truth["inertia"] * np.abs(acceleration) * s

    search = SearchedRecords.of([needing(axis, pressed)], axis.bench, USUAL)
    friction = next(one for one in search.hypotheses if one.term == "inertial_friction")
    assert search.rows(()).visible(friction, ()) is (share > 0.0)


@pytest.mark.parametrize(
    ("seed", "late"),
    [
        (1, 0),
        (3, 1),
        *(
            pytest.param(*one, marks=pytest.mark.accept)
            for one in ((0, 0), (0, 1), (1, 1), (2, 0), (2, 1), (3, 0))
        ),
    ],
)
def test_a_current_of_two_levels_is_not_explained_by_friction_under_the_inertial_load(
    tmp_path: Path, seed: int, late: int
) -> None:
    """With a constant current, the acceleration almost follows from direction and current."""
    draw = np.random.default_rng([seed, 34])
    arm = Arm(draw.uniform(0.02, 0.1), 0.05, 0.4, 0.45, counts=int(10.0 ** draw.uniform(4.0, 5.0)))
    hold = int(draw.uniform(100.0, 200.0))
    pairs = draw.choice((-1.0, 1.0), (6_000 // hold, 1)) * (1.0, -1.0)
    position, effort = play(arm, 0.8 * np.repeat(pairs.ravel(), hold))
    effort = np.roll(effort, late) + 0.02 * draw.standard_normal(effort.size)
    clock = np.arange(effort.size) * PERIOD
    log = make_record("steps", clock, position, effort, resolution=arm.step, lag=1.0)
    fit = run("auto", [log], load_document(write_bench(tmp_path, arm), Bench), USUAL)
    assert "inertial_friction" not in used(fit)
    for name in ("inertia", "coulomb"):
        assert fit.parameters[name].value == pytest.approx(getattr(arm, name), rel=0.05)


def test_hidden_acceleration_is_no_delay() -> None:
    """The encoder attenuates the inertia; a delay would predict unseen strokes 5 % better."""
    truth, bench = experiment(65)
    log = record(sines(65, truth), truth)
    assert search_explanations([log], bench, USUAL) == (None, ())


def test_harmonics_of_a_ripple_are_found_one_by_one() -> None:
    axis = loaded_axis(5, "", known=False)
    sizes = {6.0: 2.0, 12.0: 1.2, 18.0: 0.8}

    def cogging(t: Vector, x: Vector, v: Vector, s: Vector) -> Vector:
        return sum((size * np.sin(n * x) for n, size in sizes.items()), np.zeros(x.size))

    fit = run("auto", [needing(axis, cogging)], axis.bench, USUAL)
    assert fit.laws is not None
    assert fit.laws.load is not None
    found = {one.cycles: one for one in fit.laws.load.ripples}
    assert set(found) == set(sizes)
    for cycles, one in found.items():
        low, high = one.sine.interval
        assert low - 0.05 <= sizes[cycles] <= high + 0.05
    assert claims(fit) == {"ripple"}
    # the plant that simulate plays has the same load
    x = np.linspace(-1.0, 1.0, 5)
    played = load_law(fit.laws.load).at(x)
    expected = sum(
        (
            one.sine.value * np.sin(n * x) + one.cosine.value * np.cos(n * x)
            for n, one in found.items()
        ),
        np.zeros(x.size),
    )
    assert played == pytest.approx(expected)


@pytest.mark.parametrize(("axes", "most"), [(8, 1), pytest.param(30, 3, marks=pytest.mark.accept)])
def test_plain_axes_are_left_alone(axes: int, most: int) -> None:
    """A rate of 2 % has more false alarms than `most` once in 100 or 300 draws."""
    false = 0
    for seed in range(axes):
        axis = loaded_axis(seed, "", known=False)
        load, explanations = search_explanations([axis.record], axis.bench, USUAL)
        false += load is not None or any(one.state == "left" for one in explanations)
    assert false <= most


def test_what_a_declared_bench_leaves_is_named() -> None:
    axis = loaded_axis(4, "ripple", known=False)
    bench = rotary_bench(("offset", "spring"))
    load, explanations = search_explanations([axis.record], bench, USUAL)
    assert load is None
    (left,) = [one for one in explanations if one.state == "left"]
    assert left.name == "ripple"
    assert "ripple: {cycles: 7" in left.settle
    size = math.hypot(axis.truth["ripple_sine"], axis.truth["ripple_cosine"]) / math.sqrt(2.0)
    assert left.effort == pytest.approx(size, rel=0.3)


def test_a_declared_effect_is_removed_and_not_simulated() -> None:
    axis = loaded_axis(1, "", known=False)
    record = needing(axis, drift)
    bench = rotary_bench(("offset", "drift"))
    fit = run("least-squares", [record], bench, USUAL)
    assert set(fit.effects) == {f"drift_{k}" for k in range(1, 5)}
    assert fit.parameters["coulomb"].value == pytest.approx(axis.truth["coulomb"], rel=0.05)
    with pytest.raises(UnusableLogs, match="cannot simulate drift"):
        run("output-error", [record], bench, USUAL)


def test_declared_harmonics_are_fitted() -> None:
    axis = loaded_axis(2, "ripple", known=False)
    ripple = RipplePeriod(7.0, Quantity(2.0 * math.pi, unit="rad"), (14.0,))
    bench = msgspec.structs.replace(axis.bench, load=LoadTerms(("offset", "ripple"), ripple))
    laws = run("least-squares", [axis.record], bench, USUAL).laws
    assert isinstance(laws, Laws)
    assert laws.load is not None
    first, second = laws.load.ripples
    assert first.sine.value == pytest.approx(axis.truth["ripple_sine"], abs=0.1)
    low, high = second.sine.interval
    assert low - 0.05 < 0.0 < high + 0.05


def test_without_a_load_only_an_effect_without_a_rival_is_certain() -> None:
    def found(one: effects.Hypothesis, *rivals: str) -> Explanation:
        return Explanation(one.term, one.what, "used", 1.0, 1e-6, 0.8, "", rivals)

    named = {one.term: one for one in effects.EFFECTS}
    drift_, late, warm = (named[name] for name in ("drift", "delay", "warming"))
    texts = [found(drift_, "a spring"), found(late, "a resonance"), found(warm)]
    assert _certain([drift_, late, warm], texts) == ([late, warm], texts[1:])
    ripple = harmonic("ripple")
    with_load = [found(drift_, "a spring"), found(ripple)]
    assert _certain([drift_, ripple], with_load) == ([drift_, ripple], with_load)


def test_the_spectrum_finds_what_both_halves_have() -> None:
    draw = np.random.default_rng(7)
    position = draw.uniform(0.0, 20.0, 4000)
    half = draw.integers(0, 2, 4000)
    both = np.cos(9.0 * position + 0.3)
    one_half = np.where(half == 0, 3.0 * np.cos(23.0 * position), 0.0)
    peak = highest_peak(position, both + one_half, half, 0.1)
    assert peak is not None
    assert peak.number == pytest.approx(9.0, abs=0.1)
    assert peak.amplitude == pytest.approx(1.0, abs=0.2)
    assert highest_peak(position, both, half, 15.0) is None  # fewer than 1.5 periods


@pytest.mark.parametrize("count", [2, pytest.param(6, marks=pytest.mark.accept)])
def test_through_a_coarse_encoder_the_position_is_no_load_in_place_of_the_acceleration(
    count: int, tmp_path: Path
) -> None:
    """Between equal moves the position resembles the acceleration, without its noise.

    No load is claimed, and the interval of the inertia includes its decrease by rounding.
    """
    machines = (draw_machine(generator_of("coarse", number)) for number in range(100))
    moves = [one for one in machines if one.test == "steps"][:count]
    held = 0
    for number, machine in enumerate(moves):
        reach = machine.speed / machine.rate
        coarse = replace(machine, instruments=replace(machine.instruments, count=reach / 30.0))
        recording = record_machine(coarse, f"coarse/{number}")
        path = tmp_path / f"{number}.yaml"
        path.write_text(recording.bench)
        bench = load_document(path, Bench)
        log = record_of(match_bench(recording.log, bench), bench)
        found = identify_records([log], [], bench, "auto", USUAL)
        assert found.laws is None or found.laws.load is None
        inertia = found.identified["inertia"]
        held += inertia.low <= recording.truth["inertia"] <= inertia.high
    assert held >= len(moves) - 1


@pytest.mark.parametrize("gravity", [0.0, 0.2])
def test_a_belt_that_rings_in_every_step_is_no_load(tmp_path: Path, gravity: float) -> None:
    """Steps begin at the same positions, so that the ringing repeats over the position.

    Gravity of a fifth of Coulomb friction is found beside the ringing.
    """
    machine = draw_violation("f0d033de5dc11f86b7642d99be7c5e6a166c3d3f", "belt", 33)
    size = gravity * machine.physics.coulomb
    physics = machine.physics._replace(gravity=size, gravity_phase=0.3)
    recording = record_machine(replace(machine, physics=physics), "ringing")
    path = tmp_path / "bench.yaml"
    path.write_text(recording.bench)
    bench = load_document(path, Bench)
    fit = run("auto", [record_of(match_bench(recording.log, bench), bench)], bench, USUAL)
    if not gravity:
        assert not claims(fit)
        return
    assert claims(fit) == {"gravity"}
    assert fit.laws is not None
    assert fit.laws.load is not None
    found = fit.laws.load.gravity
    assert found is not None
    assert math.hypot(found.sine.value, found.cosine.value) == pytest.approx(size, rel=0.25)


def test_the_joint_test_keeps_its_level() -> None:
    draw = np.random.default_rng(11)
    below = 0
    for _ in range(300):
        cluster = np.repeat(np.arange(20), 10)
        columns = tuple(draw.standard_normal((4, 200)) + draw.standard_normal((4, 20))[:, cluster])
        noise = draw.standard_normal(200) + draw.standard_normal(20)[cluster]
        target = columns[0] + noise
        starts = np.arange(0, 200, 10)
        parts = triangles((*columns, target), np.ones(200), starts)
        below += joint_probability(parts, np.arange(20), (1, 2)) < 0.05
        assert joint_probability(parts, np.arange(20), (0,)) < 0.05
    assert below <= 27  # 15 expected; more than 27 once in 500 draws


@pytest.mark.parametrize(
    ("name", "state", "place"),
    [
        ("gravity", "used", "in the model"),
        ("drift", "used", "removed from the effort, and not in the model"),
        ("gravity", "left", "left in the residual"),
        ("drift", "left", "left in the residual"),
    ],
)
def test_the_text_says_where_an_effort_is_and_what_settles_it(
    name: str, state: str, place: str
) -> None:
    one = Explanation(name, "an effort", state, 0.25, 1e-6, 0.5, "turn the axis", ("a", "b"))
    line = explanation_line(one, "N m")
    assert explanation_place(one) == place
    assert line.startswith(f"{place}: an effort, 0.25 N m rms. ")
    assert "A and b predict these strokes equally well" in line
    assert line.endswith("To decide, turn the axis") == (place != "in the model")


def test_a_linear_axis_has_no_eccentric_encoder() -> None:
    with pytest.raises(ValueError, match="eccentricity belongs to the encoder of a rotary axis"):
        msgspec.structs.replace(linear_bench(), load=LoadTerms(("offset", "eccentricity")))


@pytest.mark.parametrize("of_encoder", [False, True])
def test_a_periodic_error_of_a_linear_encoder_is_no_ripple(of_encoder: bool) -> None:
    """The error of 40 um repeats each 20 mm, as a ripple of 0.5 N would."""
    time = np.arange(15_000) * 1e-3
    position = 0.1 * np.sin(5.0 * time) + 0.05 * np.sin(11.3 * time)
    velocity = 0.5 * np.cos(5.0 * time) + 0.565 * np.cos(11.3 * time)
    acceleration = -2.5 * np.sin(5.0 * time) - 6.3845 * np.sin(11.3 * time)
    effort = 5.0 * acceleration + 12.0 * velocity + 8.0 * np.sign(velocity)
    effort += np.random.default_rng(7).normal(0.0, 0.2, time.size)
    wave = np.sin(2.0 * np.pi * position / 0.02)
    effort += 0.0 if of_encoder else 0.5 * wave
    measured = position + (4e-5 * wave if of_encoder else 0.0)
    record = make_record("log", time, measured, effort, 1e-6, 1.0)
    load, explanations = search_explanations([record], linear_bench(), USUAL)
    terms = () if load is None else load.terms
    assert ("ripple" in terms) is not of_encoder
    assert any("periodic error of the encoder" in one.what for one in explanations) is of_encoder


@pytest.mark.parametrize("factor", [1.0, 1.5, 2.0, 3.0, 1e3])
def test_a_smoother_search_has_the_odd_windows_nearest_to_the_factor(factor: float) -> None:
    time = np.arange(6_000) * 1e-3
    logs = [
        make_record("log", time, np.floor(np.sin(rate * time) / step) * step, time, step, 0.0)
        for rate, step in ((5.0, 1e-3), (9.0, 1e-4))
    ]
    search = SearchedRecords.of(logs, rotary_bench(None), USUAL)
    longest = [0.25 * stroke_samples(log) for log in logs]
    for before, after, most in zip(
        search.windows, search.smoother(factor).windows, longest, strict=True
    ):
        assert after % 2 == 1
        assert abs(after - max(before, min(factor * before, most))) <= 1.0


def test_the_joint_test_does_not_reject_what_the_rows_do_not_determine() -> None:
    draw = np.random.default_rng(12)
    cluster = np.repeat(np.arange(8), 10)
    columns = draw.standard_normal((3, 80))
    target = 5.0 * columns[0] + draw.standard_normal(80)

    def probability(tested: tuple[int, ...], *used: Vector) -> float:
        parts = triangles((*used, target), np.ones(80), np.arange(0, 80, 10))
        return joint_probability(parts, np.arange(8), tested)

    assert probability((0,), *columns) < 1e-3
    assert probability((0,), columns[0], 2.0 * columns[0]) == 1.0  # two equal regressors
    alone = np.where(cluster == 3, columns[0], 0.0)
    assert probability((0,), alone, columns[1]) == 1.0  # one cluster determines the parameter
    many = draw.standard_normal((8, 80))
    assert probability(tuple(range(7)), *many) == 1.0  # as many tested as degrees of freedom


def late_log(late: float) -> MotionRecord:
    """Return a record with the effort `late` [s] earlier than the position, along fast moves."""
    time = np.arange(6000) * 2e-3
    position = minimum_jerk_moves(time)[0]
    velocity, acceleration = minimum_jerk_moves(time + late)[1:]
    effort = 1e-3 * acceleration + 0.01 * velocity + 0.1 * np.sign(velocity)
    effort += np.random.default_rng(1).normal(0.0, 1e-3, time.size)
    return make_record("log", time, position, effort, resolution=1e-4, lag=1.0)


def test_the_second_order_part_of_a_delay_is_no_resonance() -> None:
    fit = run("auto", [late_log(0.012)], rotary_bench(None), USUAL)
    assert used(fit) == ["delay"]
    assert fit.effects["delay"].value == pytest.approx(-0.012, rel=0.1)


def test_a_delay_is_no_lag_of_the_sensor() -> None:
    """The filter of a lag suppresses noise of the effort; its residual would be the smaller one."""
    result = identify_records([late_log(0.004)], [], rotary_bench(None), "auto", USUAL)
    assert not [one for one in result.warnings if "with a lag" in one]
    inertia = result.identified["inertia"]
    assert inertia.low <= 1e-3 <= inertia.high


def test_a_delay_is_no_friction_over_position() -> None:
    """Near reversals, the effort has the friction of the other direction for the delay's time."""
    time = np.arange(12_000) * 1e-3
    size, rate = np.array([4.0, 2.0]), np.array([4.0, 9.1])
    at, later = (np.multiply.outer(rate, one) for one in (time, time + 0.008))
    velocity, acceleration = (size * rate) @ np.cos(later), -(size * rate**2) @ np.sin(later)
    effort = 1e-3 * acceleration + 0.01 * velocity + 0.1 * np.sign(velocity)
    effort += np.random.default_rng(1).normal(0.0, 1e-3, time.size)
    log = make_record("log", time, size @ np.sin(at), effort, resolution=1e-5, lag=1.0)
    assert used(run("auto", [log], rotary_bench(None), USUAL)) == ["delay"]


def minimum_jerk_moves(time: Vector) -> tuple[Vector, Vector, Vector]:
    """Return position, velocity and acceleration (n,) of moves with a rest of 0.1 s after each."""
    draw = np.random.default_rng(1)
    position, velocity, acceleration = (np.zeros(time.size) for _ in range(3))
    start, reached = 0.1, 0.0
    while start < time[-1]:
        distance = draw.uniform(1.0, 6.0) * (1.0 if reached < 5.0 else -1.0)
        length = draw.uniform(0.25, 0.6)
        s = np.clip((time - start) / length, 0.0, 1.0)
        position += distance * s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
        velocity += distance / length * 30.0 * (s * (1.0 - s)) ** 2
        acceleration += distance / length**2 * 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s)
        start += length + 0.1
        reached += distance
    return position, velocity, acceleration
