"""A model with presliding in the sampled loop: the same motion as a mechanism with the law, what
the log and the verdict say of it, and what is refused."""

from __future__ import annotations

from typing import get_args

import msgspec
import numpy as np
import pytest

from frictool.adapters.axis_dynamic_law import dynamic_law_of
from frictool.adapters.axis_model import axis_of
from frictool.campaign.draws.factor_space import space_of
from frictool.campaign.draws.spread_factors import spread_factors
from frictool.campaign.trials.campaign_warnings import remarks_of
from frictool.campaign.trials.trial_player import TrialPlayer
from frictool.documents.conditions import (
    ControllerCommand,
    Disturbance,
    DriftPoint,
    Drifts,
    SensorFault,
)
from frictool.documents.laws import Dwell, FrictionOverPosition, Laws, Polynomial
from frictool.documents.model import Model
from frictool.documents.presliding import Contact, ContactLaw, MaxwellSlip, Presliding
from frictool.documents.quantity import Estimate, Quantity, Span
from frictool.documents.spread import FactorBand, Spread
from frictool.errors import DocumentError
from frictool.friction.law_registry import LAWS
from frictool.report.verdict import judge
from frictool.simulate.axis_variants import parameters_of
from frictool.simulate.closed_loop import simulate_closed_loop
from studies.rigs.campaign_rig import trial
from studies.rigs.clutch_model import clutch_model
from studies.rigs.step_logs import clutch_spec
from studies.rigs.step_scenario import controller, scenario
from tests.support.provenance import HERE
from tests.support.simulated_mechanisms import ONE_BLOCK, one_axis, plant_of

Z_MAX = 0.02  # rad
# difference from another integrator over z_max; a law with a memory updates it once in a step
CLOSE = {"dahl": 1e-4, "lugre": 1e-4, "elasto_plastic": 1e-4}


def estimate(value: float, unit: str) -> Estimate:
    return Estimate(value=value, unit=unit, source="bench")


def presliding(law: ContactLaw, **fields: object) -> Presliding:
    """Return a contact that yields within 0.02 rad."""
    made = Presliding(
        law,
        estimate(Z_MAX, "rad"),
        estimate(0.1089 / Z_MAX, "N m/rad"),
        estimate(0.1089, "N m"),
    )
    return msgspec.structs.replace(made, **fields)


def with_presliding(law: ContactLaw, **fields: object) -> Model:
    """Return the clutch without backlash, with a Stribeck velocity of 2 rad/s."""
    model = one_axis()
    parameters = msgspec.structs.replace(model.parameters, stribeck_velocity=estimate(2.0, "rad/s"))
    return msgspec.structs.replace(
        model, law="stribeck", parameters=parameters, presliding=presliding(law, **fields)
    )


def block_with(model: Model) -> str:
    """Return the mechanism of one block with the law of the model."""
    dynamic = dynamic_law_of(model, axis_of(model))
    assert dynamic is not None
    units = [parameter.unit("rotary") for parameter in dynamic.law.parameters]
    parameters = ", ".join(
        f"{parameter.name}: {{value: {float(value)!r}, unit: {unit or repr('1')}}}"
        for parameter, value, unit in zip(dynamic.law.parameters, dynamic.p, units, strict=False)
    )
    head, tail = ONE_BLOCK.split("    law: svc\n")
    links = tail[tail.index("  ends:") :]
    return f"{head}    law: {dynamic.law.name}\n    parameters: {{{parameters}}}\n{links}"


def test_the_laws_of_the_document_are_the_dynamic_laws() -> None:
    dynamic = {name for name, law in LAWS.items() if law.kind == "dynamic"}
    assert set(get_args(ContactLaw)) == dynamic


@pytest.mark.parametrize("law", get_args(ContactLaw))
def test_an_axis_moves_as_a_mechanism_with_the_law(law: ContactLaw) -> None:
    """Another integrator, explicit and with other error control, under disturbance, drift and
    fault."""
    # the memory of leuven_masing holds forces, which a drift of the friction leaves unchanged
    friction = () if law == "leuven_masing" else (DriftPoint(0.0, 1.0), DriftPoint(1.0, 1.4))
    played = scenario(
        disturbances=(Disturbance("pulse", Quantity(value=-0.3, unit="N m"), 0.3, 0.02),),
        drifts=Drifts(friction=friction, viscous=(DriftPoint(0.0, 0.9),)),
        sensor_faults=(SensorFault("lost_counts", 0.7, counts=3),),
    )
    model = with_presliding(law)
    theirs = simulate_closed_loop(plant_of(block_with(model)), controller(), played, HERE)
    ours = simulate_closed_loop(model, controller(), played, HERE)
    np.testing.assert_array_equal(ours.main.signals["position"], theirs.main.signals["position"])
    np.testing.assert_allclose(
        ours.main.signals["position_true"],
        theirs.main.signals["position_true"],
        rtol=0.0,
        atol=CLOSE.get(law, 1e-3) * Z_MAX,
    )
    assert np.ptp(ours.main.signals["position_true"]) > 20.0


def test_a_campaign_plays_the_contact_of_each_draw() -> None:
    """A trial is judged as the log of its scenario is; the remark says what no margin covers."""
    model = with_presliding("lugre")
    wear = Spread(wear=FactorBand(0.8, 1.5))
    setting = trial(wear).setting._replace(plant=model)
    space = space_of(spread_factors(setting.scenario))
    player = TrialPlayer(setting, space, 3)
    unit = np.array([0.9])
    trialled = player.played(unit, 0)
    log = simulate_closed_loop(model, setting.controller, player.scenario(unit, 0), HERE)
    judged = judge(setting.spec, [log], setting.controller).requirements
    assert trialled.failed == ""
    for value, requirement in zip(trialled.metric_values, judged, strict=True):
        if requirement.value is not None and requirement.key != "modulus_margin":
            assert value == requirement.value
    assert any("presliding friction by lugre" in text for text in remarks_of(setting, space))


def test_the_interpreter_and_the_machine_code_move_the_contact_alike() -> None:
    """A supervisor's commands run the loop sample by sample, in Python."""
    model, still = with_presliding("lugre"), scenario()
    late = msgspec.structs.replace(still, commands=(ControllerCommand("enable", 1.19),))
    coded, sampled = (
        simulate_closed_loop(model, controller(), one, HERE).main.signals["position_true"]
        for one in (still, late)
    )
    np.testing.assert_array_equal(coded[:1190], sampled[:1190])


def test_a_vertex_keeps_the_deflections_of_its_contact() -> None:
    """Coulomb friction scales stiffness and breakaway alike: z_max and z_ba stay."""
    model = with_presliding("elasto_plastic")
    nominal = dynamic_law_of(model, axis_of(model))
    weak = dynamic_law_of(model, axis_of(model, coulomb=0.018))
    assert nominal is not None
    assert weak is not None
    share = 0.018 / 0.099
    law = nominal.law
    for name in ("coulomb", "breakaway", "stiffness"):
        index = law.index(name)
        assert weak.p[index] == pytest.approx(share * nominal.p[index], rel=1e-12)
    assert weak.p[law.index("elastic_limit")] == pytest.approx(0.9 * Z_MAX, rel=1e-12)
    assert weak.length_scale == pytest.approx(Z_MAX, rel=1e-12)


def test_identified_contacts_are_played() -> None:
    """The stiffness, the damping and the elastic limit of a fitted law, and a fitted bank."""
    contact = Contact(
        estimate(8.0, "N m/rad"), estimate(0.01, "N m s/rad"), 0.01, 0.01, estimate(5e-3, "rad")
    )
    model = with_presliding("elasto_plastic", elasto_plastic=contact)
    dynamic = dynamic_law_of(model, axis_of(model))
    assert dynamic is not None
    found = {p.name: v for p, v in zip(dynamic.law.parameters, dynamic.p, strict=True)}
    assert (found["stiffness"], found["damping"], found["elastic_limit"]) == (8.0, 0.01, 5e-3)
    displacement, force = (0.004, 0.008, 0.012), (0.04, 0.07, 0.09)
    bank = MaxwellSlip(estimate(10.0, "N m/rad"), displacement, force, force, force, 0.01, 0.01)
    model = with_presliding("maxwell_slip", maxwell_slip=bank)
    dynamic = dynamic_law_of(model, axis_of(model))
    assert dynamic is not None
    law, p = dynamic.law, dynamic.p
    count = (p.size - len(law.parameters)) // 2
    limit = p[law.index("presliding_limit")]
    yields, weights = p[-2 * count : -count] * limit, p[-count:] * 0.1089
    assert limit == Z_MAX
    for place, level in zip((*displacement, Z_MAX), (*force, 0.1089), strict=True):
        assert np.sum(weights * np.minimum(place / yields, 1.0)) == pytest.approx(level, rel=1e-12)


def test_the_verdict_says_that_nothing_certifies_the_contact() -> None:
    model = with_presliding("lugre")
    log = simulate_closed_loop(model, controller(), scenario(), HERE)
    words = "presliding friction by lugre, which is simulated only"
    assert any(words in warning for warning in log.warnings)
    verdict = judge(clutch_spec(), [log], controller())
    assert sum(words in remark for remark in verdict.remarks) == 1
    quiet = simulate_closed_loop(one_axis(), controller(), scenario(), HERE)
    assert not any("presliding" in text for text in quiet.warnings)


def test_a_fall_without_a_stribeck_velocity_is_stated() -> None:
    model = msgspec.structs.replace(one_axis(), presliding=presliding("lugre"))
    log = simulate_closed_loop(model, controller(), scenario(variants="vertices"), HERE)
    assumed = [text for text in log.warnings if "without stribeck_velocity" in text]
    assert len(assumed) == 1
    speed = 0.1089 / np.sqrt(0.1089 / Z_MAX * 1.32e-5)
    assert f"a Stribeck velocity of {speed:.3g} rad/s" in assumed[0]


@pytest.mark.parametrize(
    ("model", "words"),
    [
        (
            msgspec.structs.replace(clutch_model(), presliding=presliding("lugre")),
            "a presliding law does not work with a backlash",
        ),
        (
            msgspec.structs.replace(with_presliding("lugre"), laws=Laws(dwell=Dwell(0.95, 1.0))),
            "never rests",
        ),
        (
            msgspec.structs.replace(
                with_presliding("lugre"),
                laws=Laws(
                    position=FrictionOverPosition(
                        Span(0.0, 60.0, "rad"), Polynomial((1.0,)), Polynomial((1.0, 1e-4))
                    )
                ),
            ),
            "position.breakaway differs from position.coulomb",
        ),
    ],
)
def test_a_law_that_the_axis_cannot_have_is_refused(model: Model, words: str) -> None:
    with pytest.raises(DocumentError, match=f"presliding: cannot be simulated: .*{words}"):
        simulate_closed_loop(model, controller(), scenario(), HERE)


def test_the_breakaway_of_a_contact_keeps_its_ratio_to_the_coulomb_friction() -> None:
    """The contact was fitted with one ratio."""
    model = with_presliding("lugre")
    one = parameters_of(model)["breakaway"]
    assert one.low == one.high == one.nominal
    assert parameters_of(msgspec.structs.replace(model, presliding=None))["breakaway"].ratio
