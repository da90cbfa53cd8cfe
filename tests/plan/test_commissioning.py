"""`plan`: from an empty bench to a controller, and every branch of its decision."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from msgspec import structs

from frictool.adapters.temperature_factors import reference_words
from frictool.cli.excite_test import save_test
from frictool.cli.plan import shown
from frictool.documents.bench import Bench
from frictool.documents.laws import FrictionOverPosition, Laws, Load, Polynomial, Ripple, TotalLoad
from frictool.documents.load_terms import LoadTerms
from frictool.documents.model import Model
from frictool.documents.quantity import Estimate, Quantity, Span
from frictool.documents.registry import load
from frictool.documents.writing import to_yaml
from frictool.errors import EXIT_NO, EXIT_NO_SOLUTION, NoSolutionError
from frictool.identify.axis_logs import SLIDING_LOG
from frictool.identify.excite.bench_limits import limits_of
from frictool.identify.excite.breakaway_ramps import breakaway_range
from frictool.identify.excite.excitation_kinds import ExcitationSettings, excite
from frictool.identify.excite.precise_strokes import PreciseTest, PrecisionRequest
from frictool.identify.excite.stroke_candidates import stroke_candidates
from frictool.identify.fit_result import Interval
from frictool.identify.from_logs import IdentifiedModel
from frictool.identify.from_logs import identify as identify_logs
from frictool.identify.model_document import LARGEST_BREAKAWAY_RATIO, model_of
from frictool.logs.canonical.mcap_format import write_mcap
from frictool.logs.log import Log
from frictool.plan import commissioning, rehearsed_test
from frictool.plan.commissioning import FINER, FIRST_STROKES, SLIDING, PlanStep, next_step
from frictool.plan.controller_search import SearchAnswer
from frictool.plan.narrowed_model import bench_for_test, exact_model, narrowed_bench
from frictool.plan.rehearsal import HalfWidthSample
from frictool.simulate import play
from frictool.simulate.as_bench import read_test
from frictool.simulate.default_servo import FEEDFORWARD, default_servo, feedforward
from studies.command_line import run, run_checked
from studies.promises.rigs import benches, truth

# tests/plan/test_rehearsal.py rehearses, and docs/tutorial_plan.md in `make accept`
pytestmark = pytest.mark.usefixtures("no_rehearsals")

SPEC = """\
format: spec/1
name: belt
axis: linear
drive: current
response_time_95_s: 0.6
overshoot_percent: 10
static_error: {value: 0.002, unit: m}
"""
BELT: Bench = next(bench for bench in benches() if bench.name == "belt")


PASSED, TOO_SLOW = (
    SearchAnswer("", "steps of 1 to 5 m; shorter steps: met"),
    SearchAnswer("too slow"),
)


def passing(model: Model) -> SearchAnswer:
    return PASSED


def refusing(model: Model) -> SearchAnswer:
    return TOO_SLOW


def played(step: PlanStep, number: int) -> Log:
    """Return the log of the step's test on the drawn axis."""
    assert step.test is not None
    test = step.test.sequence.as_log("test")
    log = play(
        truth(BELT, 3),
        test,
        servo=default_servo(BELT),
        drive_noise=0.02,
        seed=number,
        forward=feedforward(BELT, test),
    )
    return replace(log, source=f"log_{number}.mcap")


@pytest.fixture(scope="module", autouse=True)
def identified_once() -> Iterator[None]:
    """Identify the same logs once for all tests."""
    known: list[tuple[tuple[Log, ...], Bench, IdentifiedModel]] = []

    def once(logs: Sequence[Log], bench: Bench, **options: Any) -> IdentifiedModel:
        for others, other, outcome in known:
            if other is bench and [*map(id, others)] == [*map(id, logs)]:
                return outcome
        outcome = identify_logs(logs, bench, **options)
        known.append((tuple(logs), bench, outcome))
        return outcome

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(commissioning, "identify", once)
        yield


def identify(logs: Sequence[Log], bench: Bench) -> IdentifiedModel:
    outcome: IdentifiedModel = commissioning.identify(logs, bench)
    return outcome


@pytest.fixture(scope="module")
def steps(no_rehearsals: None) -> tuple[tuple[PlanStep, Log], tuple[PlanStep, Log]]:
    """The first two steps, each with the log of its test."""
    first = next_step(BELT, [], refusing)
    ramps = played(first, 1)
    second = next_step(BELT, [ramps], refusing)
    return (first, ramps), (second, played(second, 2))


@pytest.fixture(scope="module")
def logs(steps: tuple[tuple[PlanStep, Log], tuple[PlanStep, Log]]) -> tuple[Log, Log]:
    return steps[0][1], steps[1][1]


def test_an_empty_bench_begins_with_ramps_and_continues_with_strokes(
    steps: tuple[tuple[PlanStep, Log], tuple[PlanStep, Log]],
) -> None:
    first, second = (step for step, _ in steps)
    assert first.name == "breakaway"
    assert first.test is not None
    assert set(first.test.half_widths) == {"breakaway"}
    assert second.name == "friction and inertia"
    assert second.test is not None
    assert set(second.test.half_widths) == {"inertia", "viscous", "coulomb"}
    assert [one.parameter for one in second.reached] == ["breakaway"]


def test_a_weight_above_the_breakaway_leaves_out_the_ramps(logs: tuple[Log, Log]) -> None:
    """Ramps return the drive to 0, and would drop the weight."""
    weight = 1.2 * breakaway_range(BELT)[2]
    mechanics = structs.replace(BELT.mechanics, offset=Quantity(weight, unit="N"))
    bench = structs.replace(BELT, mechanics=mechanics)
    first = next_step(bench, [], refusing)
    assert first.name == "friction and inertia"
    assert first.test is not None
    assert first.test.sequence.columns[FEEDFORWARD][0] > weight
    assert next_step(BELT, logs[1:], refusing).name == "breakaway"
    assert next_step(BELT, [weighed(logs[1], weight)], refusing).name != "breakaway"


def test_a_load_that_may_exceed_the_breakaway_comes_before_the_ramps(logs: tuple[Log, Log]) -> None:
    """An arm falls; the ramps follow if strokes show that the load is smaller than the friction."""
    bench = structs.replace(BELT, load=LoadTerms(("offset", "spring")))
    assert next_step(bench, [], refusing).name == "friction and inertia"
    model = identify(logs, BELT).model
    least = breakaway_range(narrowed_bench(BELT, model))[0]
    for size, rests in ((0.9 * least, True), (1.1 * least, False)):
        total = TotalLoad(
            Estimate(-size, -size, -size, "N", source="identified"),
            Estimate(0.0, 0.0, 0.0, "N", source="identified"),
            Quantity(0.0, unit="N"),
        )
        stiffness = Estimate(1.0, 1.0, 1.0, "N/m", source="identified")
        laws = Laws(load=Load(stiffness=stiffness, total=total))
        assert commissioning._rests(BELT, structs.replace(model, laws=laws)) is rests


def weighed(log: Log, weight: float) -> Log:
    """Return the log of an axis whose drive also holds a `weight` [N]."""
    main = log.main
    current = weight / BELT.actuator.constant.value
    signals = {
        name: values + {"current": current, "effort": weight}.get(name, 0.0)
        for name, values in main.signals.items()
    }
    return replace(log, streams=(replace(main, signals=signals),))


def test_no_log_leaves_the_limits(logs: tuple[Log, Log]) -> None:
    limits = limits_of(BELT)
    for log in logs:
        position = log.main.signals["position"]
        assert 0.0 <= position.min() <= position.max() <= 0.8
        assert np.abs(np.diff(position)).max() <= limits.speed * BELT.sample_period_s + 2e-5


def test_enough_and_its_validation(logs: tuple[Log, Log]) -> None:
    far = PASSED._replace(extrapolated="the steps range far")
    step = next_step(BELT, logs, lambda _: far)
    assert step.enough
    assert step.name == "validation"
    met = "for every possible plant, with steps of 1 to 5 m; shorter steps: met; validate"
    assert met in step.why
    assert step.warnings[-1] == "the steps range far"
    assert step.test is not None
    assert step.test.sequence.kind == "steps"
    assert {one.parameter for one in step.reached} >= {"inertia", "coulomb", "breakaway"}


def test_ranges_of_the_bench_that_prevent_a_controller(logs: tuple[Log, Log]) -> None:
    def over_the_logs_only(model: Model) -> SearchAnswer:
        low, high = model.bench.mechanics.coulomb.interval
        return PASSED if high - low < 2.5 else TOO_SLOW  # the test promises 2.25

    step = next_step(BELT, logs, over_the_logs_only)
    assert (step.name, step.exit_code, step.test) == ("ranges", EXIT_NO, None)
    assert next_step(BELT, logs, over_the_logs_only, narrow=True).enough


def test_the_range_that_prevents_a_controller_is_named_first(logs: tuple[Log, Log]) -> None:
    words = "breakaway: 1 to 2 N (range: 1 to 9 N)"
    wide = SearchAnswer("too slow", narrower=words)

    def narrower_only(model: Model) -> SearchAnswer:
        low, high = model.bench.mechanics.coulomb.interval
        return PASSED if high - low < 2.5 else wide

    step = next_step(BELT, logs, narrower_only)
    assert step.name == "ranges"
    assert f"in `mechanics` of the bench, first {words}, or use --narrow" in step.why

    def exact(model: Model) -> SearchAnswer:
        return PASSED if exact_only(model) == PASSED else wide

    step = next_step(BELT, logs, exact)
    assert step.name == "finer"
    assert f"such wide intervals (too slow); first narrow {words}; a controller" in step.why


def exact_only(model: Model) -> SearchAnswer:
    low, high = model.parameters.coulomb.interval
    return PASSED if low == high else TOO_SLOW


def test_intervals_that_are_too_wide_are_halved(logs: tuple[Log, Log]) -> None:
    step = next_step(BELT, logs, exact_only)
    assert step.name == "finer"
    assert step.test is not None
    reached = {one.parameter: one.half_width for one in step.reached}
    for name in ("inertia", "viscous", "coulomb"):
        assert step.test.half_widths[name] <= 0.5 * reached[name] * (1.0 + 1e-9)


def test_intervals_that_no_test_narrows_are_named(
    logs: tuple[Log, Log], monkeypatch: pytest.MonkeyPatch
) -> None:
    def vague(*arguments: Any) -> dict[str, HalfWidthSample]:
        return {name: HalfWidthSample((), ("too vague",)) for name in arguments[2]}

    monkeypatch.setattr(rehearsed_test, "rehearse", vague)
    monkeypatch.setattr(rehearsed_test, "ROUNDS", 1)
    monkeypatch.setattr(rehearsed_test, "remedies", lambda *_: [])
    step = next_step(BELT, logs, exact_only)
    assert (step.name, step.exit_code, step.test) == ("impossible", EXIT_NO_SOLUTION, None)
    assert "no test narrows them" in step.why


def as_wide(model: IdentifiedModel, factor: float) -> IdentifiedModel:
    """Return the identification with half widths that are `factor` times as large."""
    wider = {
        name: Interval.around(one.value, factor * one.half_width)
        for name, one in model.result.identified.items()
    }
    return replace(model, result=replace(model.result, identified=wider))


@pytest.mark.parametrize(("factor", "name"), [(1.1, "unexplained"), (2.0, "finer")])
def test_strokes_that_narrow_no_interval_are_not_repeated(
    logs: tuple[Log, Log], monkeypatch: pytest.MonkeyPatch, factor: float, name: str
) -> None:
    """`factor`: half widths without one of the two logs of strokes, relative to those with both."""
    ramps, strokes = logs
    others = [ramps, strokes, replace(strokes, source="more.mcap")]
    outcome = identify(logs, BELT)
    kinds = outcome.result.kinds | {"more.mcap": SLIDING_LOG}
    laws = Laws(position=FrictionOverPosition(Span(0.0, 0.8, "m"), Polynomial((1.0, 0.5))))
    both = replace(outcome, result=replace(outcome.result, kinds=kinds, laws=laws))
    requests = []

    def design(_: Bench, request: PrecisionRequest) -> PreciseTest:
        requests.append(request)
        return PreciseTest(excite("sines", BELT, ExcitationSettings()), {}, {})

    monkeypatch.setattr(
        commissioning,
        "identify",
        lambda some, _, **__: both if len(some) == len(others) else as_wide(both, factor),
    )
    monkeypatch.setattr(commissioning, "rehearsed_strokes", design)
    step = next_step(BELT, others, exact_only)
    assert step.name == name
    if name == "unexplained":
        assert (step.test, step.exit_code) == (None, EXIT_NO)
        assert "the logs show friction over position" in step.why
    else:
        (request,) = requests
        assert request.seed == 2  # other reversals than those of the first two tests
        assert request.laws == laws  # the next promise contains this friction
        for one in step.reached:
            if one.parameter in SLIDING:
                assert request.wanted[one.parameter] <= FINER * min(one.share, FIRST_STROKES)


def test_no_controller_even_for_exact_parameters(logs: tuple[Log, Log]) -> None:
    step = next_step(BELT, logs, refusing)
    assert (step.name, step.exit_code) == ("impossible", EXIT_NO_SOLUTION)
    assert "too slow" in step.why


def without(logs: tuple[Log, Log], *names: str) -> IdentifiedModel:
    """Return the identification of the logs as if they did not show the parameters `names`."""
    outcome = identify(logs, BELT)
    identified = {key: one for key, one in outcome.result.identified.items() if key not in names}
    refused = {**outcome.result.refused, **dict.fromkeys(names, "not shown")}
    result = replace(outcome.result, identified=identified, refused=refused)
    return replace(outcome, result=result, model=model_of(result, BELT, outcome.model.provenance))


def test_a_parameter_that_the_strokes_do_not_show_keeps_the_range_of_the_bench(
    logs: tuple[Log, Log], monkeypatch: pytest.MonkeyPatch
) -> None:
    outcome = without(logs, "inertia")
    monkeypatch.setattr(commissioning, "identify", lambda *_, **__: outcome)
    judged = []

    def inertia_of(model: Model) -> SearchAnswer:
        judged.append(model.bench.mechanics.inertia.interval)
        return PASSED

    step = next_step(BELT, logs, inertia_of)
    assert step.enough
    assert step.why.endswith("not identified, range of the bench: inertia")
    assert judged == [BELT.mechanics.inertia.interval]
    exact = exact_model(outcome.model)
    assert exact.bench.mechanics.inertia.interval == (BELT.mechanics.inertia.value,) * 2
    assert exact.bench.mechanics.coulomb.interval == (outcome.model.parameters.coulomb.value,) * 2


def test_a_breakaway_in_doubt_is_not_used(
    logs: tuple[Log, Log], monkeypatch: pytest.MonkeyPatch
) -> None:
    outcome = identify(logs, BELT)
    warned = replace(outcome.result, warnings=("a load?",), doubts={"breakaway": "a load?"})
    monkeypatch.setattr(commissioning, "identify", lambda *_, **__: replace(outcome, result=warned))
    judged = []

    def breakaway_of(model: Model) -> SearchAnswer:
        judged.append(model.parameters.breakaway)
        return PASSED

    step = next_step(BELT, logs, breakaway_of)
    assert (step.warnings, step.doubts) == (("a load?",), ("breakaway",))
    assert {one.parameter for one in step.reached} >= {"inertia", "coulomb"}
    assert "breakaway" not in {one.parameter for one in step.reached}
    coulomb = outcome.model.parameters.coulomb.interval
    assert judged[0].interval == (coulomb[0], LARGEST_BREAKAWAY_RATIO * coulomb[1])
    assert "breakaway         not used: its interval is in doubt" in shown(step, None, BELT)


def test_a_bench_on_which_no_strokes_are_safe_is_judged_by_its_ranges(
    logs: tuple[Log, Log], monkeypatch: pytest.MonkeyPatch
) -> None:
    def unsafe(*_: object) -> PreciseTest:
        raise NoSolutionError("travel: every stroke can reach an end")

    monkeypatch.setattr(commissioning, "rehearsed_strokes", unsafe)
    step = next_step(BELT, logs[:1], passing)
    assert step.enough
    assert step.why.endswith("not identified, range of the bench: inertia, viscous, coulomb")
    for judge, reason in ((refusing, "even for exact"), (ranged, "no test narrows them: travel")):
        step = next_step(BELT, logs[:1], judge)
        assert (step.name, step.exit_code, step.test) == ("impossible", EXIT_NO_SOLUTION, None)
        assert reason in step.why


def ranged(model: Model) -> SearchAnswer:
    low, high = model.bench.mechanics.coulomb.interval
    return PASSED if low == high else TOO_SLOW


def test_strokes_that_show_nothing_are_repeated_once_with_other_reversals(
    logs: tuple[Log, Log], monkeypatch: pytest.MonkeyPatch
) -> None:
    outcome = without(logs, "inertia", "viscous", "coulomb", "offset")
    monkeypatch.setattr(commissioning, "identify", lambda *_, **__: outcome)
    step = next_step(BELT, logs, refusing)
    assert step.name == "friction and inertia"
    assert step.test is not None
    reference = step.test.sequence.columns["reference"]
    assert not np.array_equal(reference, logs[1].main.signals["reference"])
    kinds = {**outcome.result.kinds, "log_3.mcap": SLIDING_LOG}
    outcome = replace(outcome, result=replace(outcome.result, kinds=kinds))
    step = next_step(BELT, logs, refusing)
    assert (step.name, step.exit_code, step.test) == ("unexplained", EXIT_NO, None)
    assert "not shown); 2 logs of motion did not change this" in step.why


def test_a_breakaway_bounds_the_coulomb_friction_of_the_next_test(logs: tuple[Log, Log]) -> None:
    model = identify(logs[:1], BELT).model
    breakaway = model.parameters.breakaway
    low, high = bench_for_test(BELT, model).mechanics.coulomb.interval
    assert low == pytest.approx(
        max(breakaway.interval[0] / LARGEST_BREAKAWAY_RATIO, BELT.mechanics.coulomb.interval[0])
    )
    assert high == pytest.approx(min(breakaway.interval[1], BELT.mechanics.coulomb.interval[1]))
    assert low <= truth(BELT, 3).parameters.coulomb.value <= high
    assert high - low < np.ptp(BELT.mechanics.coulomb.interval)
    both = identify(logs, BELT).model
    assert bench_for_test(BELT, both) == narrowed_bench(BELT, both)


def test_the_feedforward_of_a_test_is_that_of_the_narrowed_bench(
    steps: tuple[tuple[PlanStep, Log], tuple[PlanStep, Log]], tmp_path: Path
) -> None:
    (_, ramps), (second, _) = steps
    assert second.test is not None
    sequence = second.test.sequence
    test = sequence.as_log("test")
    narrowed = bench_for_test(BELT, identify([ramps], BELT).model)
    column = sequence.columns[FEEDFORWARD]
    bare = replace(
        sequence, columns={k: v for k, v in sequence.columns.items() if k != FEEDFORWARD}
    )
    np.testing.assert_array_equal(column, feedforward(narrowed, bare.as_log("test")))
    assert not np.array_equal(column, feedforward(BELT, bare.as_log("test")))
    for name in ("test.csv", "test.mcap"):
        path = tmp_path / name
        save_test(sequence, path, "frictool plan", [])
        played = feedforward(BELT, read_test(path, BELT))
        np.testing.assert_allclose(played, feedforward(BELT, test), rtol=1e-12)


def test_a_reversed_encoder_is_named(logs: tuple[Log, Log]) -> None:
    stream = logs[1].main
    position = 0.8 - stream.signals["position"]
    signals = {**stream.signals, "position": position}
    signals.pop("reference")
    reversed_log = replace(logs[1], streams=(replace(stream, signals=signals),))
    step = next_step(BELT, [reversed_log], passing)
    assert step.name == "direction"
    assert "set columns.position.scale: -1 in the bench" in step.why


def test_a_narrowed_bench_has_the_intervals_of_the_logs(logs: tuple[Log, Log]) -> None:
    model = identify(logs, BELT).model
    narrowed = narrowed_bench(BELT, model).mechanics
    assert narrowed.coulomb.interval == model.parameters.coulomb.interval
    assert narrowed.travel == BELT.mechanics.travel
    low, high = exact_model(model).parameters.inertia.interval
    assert low == high
    assert structs.asdict(narrowed_bench(BELT, model).encoder) == structs.asdict(BELT.encoder)


def test_an_exact_model_has_an_exact_load(logs: tuple[Log, Log]) -> None:
    """So that `plan` says "even for exact parameters" of exact loads, too."""

    def wide(value: float, unit: str) -> Estimate:
        return Estimate(value, 0.5 * value, 1.5 * value, unit, source="identified")

    ripple = Ripple(3.0, Quantity(1.0, unit="m"), wide(0.1, "N"), wide(0.2, "N"))
    load = Load(wide(2.0, "N/m"), None, ripple, (ripple,))
    model = structs.replace(identify(logs, BELT).model, laws=Laws(load=load))
    laws = exact_model(model).laws
    assert laws is not None
    assert laws.load is not None
    assert laws.load.stiffness is not None
    assert laws.load.stiffness.interval == (2.0, 2.0)
    for one in laws.load.ripples:
        assert (one.sine.interval, one.cosine.interval) == ((0.1, 0.1), (0.2, 0.2))


def test_commands_from_an_empty_bench_to_enough(tmp_path: Path) -> None:
    bench, spec, model = (tmp_path / name for name in ("bench.yaml", "spec.yaml", "truth.yaml"))
    bench.write_text(to_yaml(BELT))
    spec.write_text(SPEC)
    model.write_text(to_yaml(truth(BELT, 3)))
    recorded: list[Path] = []
    names = []
    for number in range(3):
        test, log = tmp_path / f"test{number}.mcap", tmp_path / f"log{number}.mcap"
        options = ("--spec", spec, *recorded, "-o", test, "--json")
        shown = json.loads(run_checked("plan", bench, *options))
        names.append(shown["step"])
        if shown["enough"]:
            break
        run_checked("simulate", "--as-bench", model, test, "-o", log, "--seed", number)
        recorded.append(log)
    assert names == ["breakaway", "friction and inertia", "validation"]
    text = run("plan", bench, "--spec", spec)
    assert text.code == 0
    assert "next test, breakaway: slow ramps" in text.stdout
    assert "-o FILE writes the test" in text.stdout


def warmed(log: Log, ends: tuple[float, float]) -> Log:
    """Return the log with a temperature [degC] that changes linearly between `ends`.

    The current decreases by 2 % per kelvin, as for a friction that decreases with temperature.
    """
    stream = log.main
    warm = np.linspace(*ends, stream.time.size)
    units = {**stream.units, "temperature": "degC"}
    current = stream.signals["current"] * np.exp(-0.02 * (warm - np.mean(warm)))
    signals = {**stream.signals, "temperature": warm, "current": current}
    return replace(log, streams=(replace(stream, signals=signals, units=units),))


@pytest.mark.accept
def test_a_plan_says_at_which_temperature_its_vertices_hold(
    logs: tuple[Log, Log], tmp_path: Path
) -> None:
    """Without a temperature in the logs nothing is said; `plan` and `synth` say the same."""
    bench, spec, model = (tmp_path / name for name in ("bench.yaml", "spec.yaml", "model.yaml"))
    spec.write_text(SPEC)
    said = []
    for name, ends in (("plain", None), ("warm", (20.0, 35.0))):
        load_terms = None if ends is None else LoadTerms(("offset", "temperature"))
        bench.write_text(to_yaml(structs.replace(BELT, load=load_terms)))
        paths = []
        for number, log in enumerate(logs):
            path = tmp_path / f"{name}{number}.mcap"
            with path.open("wb") as stream:
                write_mcap(log if ends is None else warmed(log, ends), stream)
            paths.append(path)
        result = run("plan", bench, "--spec", spec, *paths, "--model", model)
        assert result.code == 0, result.stderr
        said.append(result.stderr)
    assert "degC" not in said[0]
    law = load(model, Model).laws
    assert law is not None
    assert law.temperature is not None
    words = reference_words(law.temperature, vertices=True)
    assert f"the friction at {law.temperature.reference.value:.4g} degC is used, and the" in words
    assert f"warning: {bench}: {words}; let the ranges in bench.yaml include these" in said[1]
    designed = run("synth", model, "--spec", spec, "--vertices-only", "-o", tmp_path / "c.yaml")
    assert f"warning: {model}: {words}; let the ranges" in designed.stderr


def test_a_test_without_a_known_travel_is_warned_of(tmp_path: Path) -> None:
    mechanics = structs.replace(BELT.mechanics, travel=None)
    bench, spec = tmp_path / "bench.yaml", tmp_path / "spec.yaml"
    slow = structs.replace(BELT, mechanics=mechanics, sample_period_s=0.01)
    bench.write_text(to_yaml(slow))
    spec.write_text(SPEC)
    result = run("plan", bench, "--spec", spec, "-o", tmp_path / "test.mcap")
    assert result.code == 0, result.stderr
    assert "mechanics.travel is missing" in result.stderr
    assert "inf" not in result.stdout


def beginning(log: Log, share: float) -> Log:
    """Return the first part of a log, with too few breakaways for a log of ramps."""
    main = log.main
    count = int(share * main.time.size)
    signals = {name: values[:count] for name, values in main.signals.items()}
    part = replace(main, time=main.time[:count], signals=signals)
    return replace(log, streams=(part,), source=f"part_{share}.mcap")


def test_ramps_that_show_too_few_breakaways_are_not_repeated_for_ever(
    logs: tuple[Log, Log],
) -> None:
    """An axis with little friction coasts to the end of the travel after each breakaway."""
    ramps, strokes = logs
    first, second = beginning(ramps, 0.04), beginning(ramps, 0.05)
    assert next_step(BELT, [first, strokes], refusing).name == "breakaway"
    assert next_step(BELT, [first, strokes, second], refusing).name != "breakaway"


def test_strokes_need_a_sample_period_that_fits() -> None:
    hasty = structs.replace(BELT, sample_period_s=1e-8)
    with pytest.raises(NoSolutionError, match="time: no stroke on this bench has"):
        stroke_candidates(hasty, None)
