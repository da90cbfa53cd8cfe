"""Temperature of a scenario: its friction in runs, margins, certificate and verdicts."""

from __future__ import annotations

import math
from pathlib import Path

import msgspec
import numpy as np
import pytest

from frictool.adapters.temperature_factors import reference_words
from frictool.campaign.draws.factor_space import space_of
from frictool.campaign.draws.spread_factors import spread_factors
from frictool.campaign.trials.campaign_warnings import remarks_of
from frictool.campaign.trials.trial_player import TrialPlayer
from frictool.documents.conditions import Disturbance, DriftPoint, Drifts
from frictool.documents.laws import (
    Backward,
    FrictionOverTemperature,
    Laws,
    Regime,
    TemperatureChange,
)
from frictool.documents.model import Model
from frictool.documents.quantity import Estimate, Quantity, Span
from frictool.documents.registry import load
from frictool.documents.scenario import Scenario, Step
from frictool.documents.spread import FactorBand, Spread, Temperature, Warmth
from frictool.documents.writing import to_yaml
from frictool.errors import DocumentError
from frictool.identify.validate import validate
from frictool.logs.log import Log
from frictool.report.verdict import judge
from frictool.simulate.closed_loop import simulate_closed_loop
from frictool.verify.certified_intervals import parameters_outside
from frictool.verify.logged_plant import INTERVALS, RECORD, intervals_of_text
from studies.command_line import run
from studies.rigs.campaign_rig import trial
from studies.rigs.clutch_model import clutch_model
from studies.rigs.step_logs import clutch_spec
from studies.rigs.step_scenario import controller, scenario, write_rig
from tests.support.command_line import refused
from tests.support.provenance import HERE
from tests.support.simulated_mechanisms import ONE_BLOCK, one_axis, plant_of

REFERENCE, SLOPE, CURVATURE, DRY = 25.0, -0.02, 1e-4, -0.005  # degC, 1/K, 1/K^2, 1/K
WARM = 45.0  # degC
LAW = FrictionOverTemperature(
    Quantity(value=REFERENCE, unit="degC"),
    Span(15.0, 50.0, "degC"),
    TemperatureChange(
        Estimate(value=SLOPE, unit="1/K", source="identified"),
        Estimate(value=CURVATURE, unit="1/K^2", source="identified"),
    ),
    TemperatureChange(Estimate(value=DRY, unit="1/K", source="identified")),
)


def factors(temperature: float) -> tuple[float, float]:
    """Return the factors of viscous and dry friction by the law's equation."""
    h = temperature - REFERENCE
    return math.exp(SLOPE * h + CURVATURE * h**2), math.exp(DRY * h)


def times(estimate: Estimate, factor: float) -> Estimate:
    low, high = (None if end is None else factor * end for end in (estimate.low, estimate.high))
    return msgspec.structs.replace(estimate, value=factor * estimate.value, low=low, high=high)


def level(value: float, unit: str) -> Estimate:
    return Estimate(value=value, unit=unit, source="bench")


def model(viscous: float = 1.0, dry: float = 1.0) -> Model:
    """Return the clutch with friction by direction and a knee, multiplied by two factors."""
    made = clutch_model()
    parameters = msgspec.structs.replace(
        made.parameters,
        viscous=times(made.parameters.viscous, viscous),
        coulomb=times(made.parameters.coulomb, dry),
        breakaway=times(made.parameters.breakaway, dry),
    )
    laws = Laws(
        backward=Backward(
            times(level(4.2e-4, "N m s/rad"), viscous),
            times(level(0.09, "N m"), dry),
            times(level(0.12, "N m"), dry),
        ),
        regimes=(
            Regime(Quantity(value=60.0, unit="rad/s"), times(level(2.5e-4, "N m s/rad"), viscous)),
        ),
        temperature=LAW,
    )
    loose = made.bench.mechanics.backlash_coulomb
    assert loose is not None
    mechanics = msgspec.structs.replace(
        made.bench.mechanics,
        backlash_coulomb=msgspec.structs.replace(loose, value=dry * loose.value),
    )
    bench = msgspec.structs.replace(made.bench, mechanics=mechanics)
    return msgspec.structs.replace(made, bench=bench, parameters=parameters, laws=laws)


def degrees(value: float) -> Quantity:
    return Quantity(value=value, unit="degC")


def test_a_law_without_an_effect_is_not_mentioned() -> None:
    assert "viscous friction is" in reference_words(LAW)
    assert reference_words(msgspec.structs.replace(LAW, viscous=None, coulomb=None)) == ""


def played(plant: Model, test: Scenario) -> Log:
    return simulate_closed_loop(plant, controller(), test, HERE)


def test_at_the_reference_nothing_changes() -> None:
    still, warm = (
        played(model(), scenario(variants="vertices", drive_noise=0.05, temperature=one))
        for one in (None, degrees(REFERENCE))
    )
    assert len(still.axes) > 4
    for before, after in zip(still.axes, warm.axes, strict=True):
        assert np.all(after.signals["temperature"] == REFERENCE)
        assert after.units["temperature"] == "degC"
        for name, signal in before.signals.items():
            np.testing.assert_array_equal(after.signals[name], signal)
    assert {**still.metadata, "log": {}, "provenance": {}} == {
        **warm.metadata,
        "log": {},
        "provenance": {},
    }
    assert still.warnings == warm.warnings


def test_a_run_is_that_of_a_model_with_multiplied_friction() -> None:
    """Directions, knee, breakaway and backlash included; a drift multiplies the factor."""
    drifts = Drifts(friction=(DriftPoint(0.0, 1.0), DriftPoint(1.0, 1.3)))
    push = (Disturbance("pulse", Quantity(value=-0.3, unit="N m"), 0.3, 0.02),)
    test = scenario(drifts=drifts, disturbances=push)
    warm = played(model(), msgspec.structs.replace(test, temperature=degrees(WARM)))
    twin = played(model(*factors(WARM)), test)
    cold = played(model(), test)
    for name in ("position_true", "velocity", "current_true"):
        ours, theirs = warm.main.signals[name], twin.main.signals[name]
        np.testing.assert_allclose(ours, theirs, rtol=1e-9, atol=1e-9 * np.ptp(theirs))
    far = cold.main.signals["position_true"] - warm.main.signals["position_true"]
    assert np.max(np.abs(far)) > 0.1
    assert factors(WARM)[0] == pytest.approx(0.698, abs=1e-3)


def test_the_steady_speed_under_a_constant_drive_follows_the_closed_form() -> None:
    """K limit = coulomb exp(q h) + viscous exp(r h + k h^2) v in saturation."""
    clutch = clutch_model()
    limit = Quantity(value=10.0, unit="A")
    actuator = msgspec.structs.replace(clutch.bench.actuator, limit=limit)
    wide = Span(-1e4, 1e4, "rad")
    mechanics = msgspec.structs.replace(clutch.bench.mechanics, travel=wide)
    bench = msgspec.structs.replace(clutch.bench, actuator=actuator, mechanics=mechanics)
    plant = msgspec.structs.replace(clutch, bench=bench, laws=Laws(temperature=LAW))
    loop = controller()
    loop = msgspec.structs.replace(
        loop, bench=msgspec.structs.replace(loop.bench, actuator=actuator)
    )
    far = (Step(Quantity(value=1000.0, unit="rad"), 1.0),)
    for temperature in (REFERENCE, WARM):
        test = scenario(steps=far, temperature=degrees(temperature))
        log = simulate_closed_loop(plant, loop, test, HERE)
        viscous, dry = factors(temperature)
        drive = log.main.signals["current_true"][-1]
        steady = (13.4e-3 * drive - dry * 0.099) / (viscous * 3.81e-4)
        assert abs(drive) > 0.0
        assert log.main.signals["velocity"][-1] == pytest.approx(steady, rel=1e-6)


def test_margins_and_certificate_are_those_of_a_model_with_multiplied_friction() -> None:
    """A model outside the verified intervals at a temperature is named as any other difference."""
    cold = -10.0
    warm = played(model(), scenario(temperature=degrees(cold)))
    twin = played(model(*factors(cold)), scenario())
    for record in (RECORD, INTERVALS):
        for name, text in warm.metadata[record].items():
            ours, theirs = (
                msgspec.json.decode(text),
                msgspec.json.decode(twin.metadata[record][name]),
            )
            if record == INTERVALS:
                assert ours == pytest.approx(theirs, rel=1e-12)
            else:
                assert sorted(ours["slopes"]) == pytest.approx(sorted(theirs["slopes"]), rel=1e-12)
    *extrapolated, outside = warm.warnings
    assert [outside] == list(twin.warnings)
    viscous, dry = factors(cold)
    assert f"viscous 0 to {viscous * 7.62e-4:.6g} N m s/rad, verified 0 to 0.000762" in outside
    known = intervals_of_text(warm.metadata[INTERVALS])
    assert parameters_outside(controller(), known)[1] == (
        f"coulomb 0.018 to {dry * 0.18:.6g} N m, verified 0.018 to 0.18"
    )
    assert extrapolated == [
        f"model is simulated at -10 degC (extrapolated beyond 15 to 50 degC): viscous friction "
        f"{viscous:.4g} and dry friction {dry:.4g} times that at 25 degC"
    ]
    assert played(model(), scenario()).warnings == ()
    verdict = judge(clutch_spec(), [warm], controller())
    assert sum("simulated at -10 degC (extrapolated" in one for one in verdict.remarks) == 1
    phrases = outside.split(": ")[1]
    assert any(phrases in one for one in verdict.remarks)


def test_a_verdict_states_a_temperature_within_the_logs() -> None:
    log = played(model(), scenario(temperature=degrees(WARM)))
    words = "is simulated at 45 degC: viscous friction 0.6977 and dry friction 0.9048 times that at"
    assert words in " ".join(judge(clutch_spec(), [log], controller()).remarks)
    assert not any("45 degC" in one for one in log.warnings)


def test_a_campaign_plays_the_temperature_in_each_trial() -> None:
    """A trial is judged as the log of its scenario is, and differs from one at the reference."""
    wear = Spread(wear=FactorBand(0.8, 1.5))
    unit = np.array([0.9])
    values = []
    for temperature in (None, degrees(WARM)):
        setting = trial(wear, temperature=temperature).setting._replace(plant=model())
        space = space_of(spread_factors(setting.scenario))
        player = TrialPlayer(setting, space, 3)
        trialled = player.played(unit, 0)
        test = player.scenario(unit, 0)
        assert test.temperature == temperature
        log = simulate_closed_loop(model(), setting.controller, test, HERE)
        judged = judge(setting.spec, [log], setting.controller).requirements
        assert trialled.failed == ""
        for value, requirement in zip(trialled.metric_values, judged, strict=True):
            if requirement.value is not None and requirement.key != "modulus_margin":
                assert value == requirement.value
        stated = any("simulated at 45 degC" in one for one in remarks_of(setting, space))
        assert stated == (temperature is not None)
        values.append(trialled.metric_values)
    assert values[0] != values[1]


def test_validate_plays_the_temperature_of_the_log() -> None:
    """The measured effort of a warm axis moves the model at that temperature as the axis moved."""
    plain = one_axis()
    plant = msgspec.structs.replace(plain, laws=Laws(temperature=LAW))
    log = played(plant, scenario(temperature=degrees(WARM)))
    step = plain.bench.encoder.resolution
    assert validate(plant, log).position_rmse < 0.5 * step
    assert validate(plain, log).position_rmse > 10.0 * step
    still = played(plain, scenario())
    np.testing.assert_array_equal(
        validate(plant, still).simulated["position"], validate(plain, still).simulated["position"]
    )


def test_a_temperature_without_a_law_is_refused(tmp_path: Path) -> None:
    paths = write_rig(tmp_path)
    paths["scenario"].write_text(to_yaml(scenario(temperature=degrees(WARM))))
    result = run(
        "simulate",
        paths["model"],
        "--controller",
        paths["controller"],
        "--scenario",
        paths["scenario"],
        "-o",
        tmp_path / "run.mcap",
    )
    refused(result, 3, "temperature", "found 45 degC", "has no laws.temperature", "drifts")
    assert "scenario.yaml:" in result.stderr
    with pytest.raises(DocumentError, match=r"has no laws\.temperature"):
        simulate_closed_loop(
            plant_of(ONE_BLOCK), controller(), scenario(temperature=degrees(WARM)), HERE
        )


def test_two_temperatures_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "scenario.yaml"
    spread = Spread(temperature=Temperature(Warmth(viscous=1.3), Warmth(viscous=0.7)))
    path.write_text(to_yaml(scenario(spread=spread)) + "temperature: {value: 113, unit: degF}\n")
    with pytest.raises(DocumentError, match=r"`temperature` and `spread\.temperature`"):
        load(path, Scenario)
    path.write_text(to_yaml(scenario()) + "temperature: {value: 113, unit: degF}\n")
    read = load(path, Scenario).temperature
    assert read is not None
    assert read.value == pytest.approx(45.0)


def test_an_export_names_its_temperature_and_the_range_of_friction(tmp_path: Path) -> None:
    plain, warm = tmp_path / "plain.yaml", tmp_path / "warm.yaml"
    plain.write_text(to_yaml(clutch_model()))
    warm.write_text(to_yaml(msgspec.structs.replace(clutch_model(), laws=Laws(temperature=LAW))))
    said = []
    for path in (plain, warm):
        result = run(
            "export", path, "--lang", "mjcf", "--without", "backlash", "-o", tmp_path / path.stem
        )
        assert result.code == 0
        said.append(result.stderr)
    assert "degC" not in said[0]
    ends = [factors(one) for one in (15.0, 50.0)]
    viscous, dry = zip(*ends, strict=True)
    assert "the friction at 25 degC is used; from 15 to 50 degC" in said[1]
    assert f"viscous friction is {min(viscous):.3g} to {max(viscous):.3g}" in said[1]
    assert f"dry friction {min(dry):.3g} to {max(dry):.3g} times this value" in said[1]
