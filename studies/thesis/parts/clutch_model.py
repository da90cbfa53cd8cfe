"""Section 4.4 on the SIMULATED clutch of configs/clutch/nonlinear.yaml, with published friction.

The tables are 4.6 and 4.7, the figures 4.9 to 4.17.
"""

from __future__ import annotations

import math

import msgspec
import numpy as np

from frictool.adapters.mechanism.assembly import assemble
from frictool.documents.bench import Bench
from frictool.documents.mechanism import Mechanism
from frictool.documents.model import Model
from frictool.documents.registry import load
from frictool.documents.scenario import Scenario
from frictool.identify.assess.assessment import assess
from frictool.identify.assess.assessment_inputs import AssessmentRequest, facts_of
from frictool.identify.assess.quantisation import inertia_error, viscous_error
from frictool.identify.breakaway.breakaway import Breakaway
from frictool.identify.estimators.ordinary import ordinary
from frictool.identify.identification import Identification, identify_records
from frictool.identify.methods import IdentificationSettings
from frictool.identify.model_document import model_of
from frictool.identify.model_page.evidence import slip_samples
from frictool.identify.model_page.friction_panels import friction_panels
from frictool.identify.model_page.panel import picture
from frictool.identify.motion_record import MotionRecord, make_record
from frictool.identify.rows.difference_fit import differenced
from frictool.identify.rows.regression_samples import fit
from frictool.logs.log import MAIN_TOPIC, Log, Stream
from frictool.simulate.closed_loop import simulate_closed_loop
from frictool.simulate.mechanism_plant import MechanismPlant
from studies.clutch.rig import CLUTCH, FILTER, HERE, controller
from studies.clutch.torque_ramps import CENTRED, OFF, Ramps, ramps, yielding
from studies.rigs.curve_logs import nonlinear_clutch
from studies.rigs.identification_rigs import clutch, record
from studies.rigs.sample_logs import PERIOD, SECONDS_EACH, ramp, sines
from studies.thesis.drawing import Curve, Row, draw
from studies.thesis.results import ComputedValue, Part

RATE, SEED = 0.95, 1  # of the intervals; of the logs
FULL_EFFORT, TOP_SPEED = 1.0, 400.0  # N m, rad/s, table 4.5
DURATION = 30.0  # s, of the tests that `assess` plans with, its default
DETAIL, AFTER = 1.0, 20.0  # s of the first step; after which a step is over


def clutch_model() -> Part:
    """Return the part with the identification of the clutch."""
    part, truth, bench = Part(), nonlinear_clutch(), clutch()
    whole, ramped = record(sines(SEED, truth), truth), record(ramp(SEED, truth), truth, "ramp")
    _decision(part, bench)
    _table_4_6(part, whole, bench)
    found = identify_records([whole, ramped], [], bench, "sines", IdentificationSettings(RATE))
    _table_4_7(part, found)
    _friction(part, found, whole, ramped, bench)
    _validation(part)
    return part


def _decision(part: Part, bench: Bench) -> None:
    """Add 4.4.1: bounds of the constants of table 4.5, and result of figure 4.4."""
    facts = bench.mechanics.inertia
    assert facts is not None
    step = facts_of(bench, AssessmentRequest(duration=DURATION)).sensing.step
    inertia = inertia_error(facts.value, step, PERIOD, FULL_EFFORT)
    part.add(
        "section_4_4_1", {"inertia": 100.0 * inertia, "inertia_absolute": inertia * facts.value}
    )
    part.add("section_4_4_1", {"viscous": 100.0 * viscous_error(step, PERIOD, TOP_SPEED)})
    rows = {
        row.parameter: row.verdict
        for row in assess(bench, AssessmentRequest(duration=DURATION)).rows
    }
    part.add(
        "section_4_4_1",
        {
            "inertia_by": rows["inertia"].method or "none",
            "viscous_by": rows["viscous"].method or "none",
        },
    )


def _table_4_6(part: Part, whole: MotionRecord, bench: Bench) -> None:
    """Add table 4.6: least squares on filtered differences of the fastest sine.

    The values describe the filter and not the clutch (4.4.2.1).
    """
    last = slice(whole.time.size - round(SECONDS_EACH / PERIOD), None)
    fast = make_record(
        "350 rad/s",
        whole.time[last],
        whole.position[last],
        whole.effort[last],
        whole.resolution,
        whole.lag,
    )
    ordinary_fit = ordinary([fast], bench, IdentificationSettings(RATE, time_constant=FILTER))
    samples, memory = differenced([fast], FILTER)
    free = fit(samples, np.ones(samples.velocity.size), memory, RATE, {}).parameters
    inertia = free["inertia"].value
    part.add(
        "table_4_6",
        {
            "inertia": inertia,
            **{name: ordinary_fit.parameters[name].value for name in ("viscous", "coulomb")},
        },
    )
    part.add(
        "table_4_6",
        {
            "time_constant": inertia / ordinary_fit.parameters["viscous"].value,
            "believed": "yes" if "inertia" in ordinary_fit.parameters else "no",
        },
    )
    part.say(
        "table_4_6",
        "On the SIMULATED clutch; frictool refuses the inertia: "
        f"{ordinary_fit.refused.get('inertia', '')}.",
    )


def _table_4_7(part: Part, found: Identification) -> None:
    """Add table 4.7: coefficients with their 95 % intervals."""
    law = found.ramp.by_position if found.ramp is not None else None
    assert law is not None
    for side, unsure in zip(("plus", "minus"), law.coefficients, strict=True):
        part.add(
            "table_4_7",
            {
                f"b{k}_{side}": ComputedValue(one.value, one.low, one.high, "95 %")
                for k, one in enumerate(unsure)
            },
        )
    part.say(
        "table_4_7",
        "On the SIMULATED clutch, whose breakaway has the printed coefficients: the "
        "identification returns them.",
    )
    assert found.fit is not None
    assert found.laws is not None
    knee = found.laws.regimes[0].above
    part.add(
        "section_4_4_2",
        {
            "knee": ComputedValue(knee.value, knee.low, knee.high, "95 %"),
            "beta": float(found.fit.details["beta"]),
        },
    )
    below = found.identified["viscous"].value
    part.add(
        "section_4_4_2",
        {
            "viscous_below": "almost none"
            if below * knee.value < 0.05 * found.identified["coulomb"].value
            else "some"
        },
    )


def _friction(
    part: Part, found: Identification, whole: MotionRecord, ramped: MotionRecord, bench: Bench
) -> None:
    """Draw figures 4.9 to 4.13."""
    model = model_of(found, bench, HERE)
    panels = friction_panels(model, slip_samples(model, [whole]), found.ramp)
    svg = picture(panels, "friction of the clutch")
    knee = found.laws.regimes[0].above.value if found.laws is not None else math.nan
    part.draw(
        "4.10",
        f"Above: samples in slip and the law over speed (4.9, 4.10), its knee at {knee:.0f} "
        "rad/s; in the middle breakaways and "
        "their polynomials (4.12); below friction over both (4.13).",
        svg,
    )
    found_ramp: Breakaway | None = found.ramp
    assert found_ramp is not None
    curve = Curve(ramped.position, ramped.effort, "", "line")
    part.draw(
        "4.11",
        f"{found_ramp.onsets} breakaways both ways over the travel, seen "
        f"{1e3 * found_ramp.delay:.1f} mN m late in the mean.",
        draw("ramp torque", "theta, rad", [("u, N m", [curve])], thin=False),
    )


def _validation(part: Part) -> None:
    """Draw figures 4.14 to 4.17: the PID's limit cycle on the mechanism of chapter 2.

    The mechanism is simulated with rigid and with compliant flanks.
    """
    document = load(CLUTCH / "mechanism.yaml", Mechanism)
    scenario = load(CLUTCH / "scenarios/rebound.yaml", Scenario)
    logs = {
        name: _under_pid(one, scenario)
        for name, one in (("rigid", document), ("yielding", yielding(document)))
    }
    holds = {name: ramps(log) for name, log in logs.items()}
    aside = sum(one.asymmetry > OFF for one in holds["yielding"])
    part.add(
        "section_4_4_4",
        {
            "rigid": "around 0"
            if max(one.asymmetry for one in holds["rigid"]) <= CENTRED
            else "aside"
        },
    )
    part.add(
        "section_4_4_4",
        {"yielding": "aside" if 2 * aside >= len(holds["yielding"]) else "around 0"},
    )
    part.say(
        "section_4_4_4",
        f"Compliant flanks: the ramps are off centre on {aside} of {len(holds['yielding'])} holds.",
    )
    efforts = {
        name: Curve(_main(log).time, _main(log).signals["effort"]) for name, log in logs.items()
    }
    part.draw(
        "4.14",
        "The exhaustive mechanism with compliant flanks, on its second hold: it sticks, and "
        "slips past the reference.",
        draw("position", "t, s", [("theta, rad", _second_hold(logs["yielding"]))]),
    )
    offset = f"off centre on {aside} of {len(holds['yielding'])} holds, as on the bench"
    part.draw(
        "4.15",
        f"Its torque: ramps {_around(holds['yielding'])}, {offset}.",
        draw("torque, yielding", "t, s", [("u, N m", [efforts["yielding"]])]),
    )
    part.draw(
        "4.16",
        f"With rigid flanks, as the thesis's model has them: ramps {_around(holds['rigid'])}.",
        draw("torque, rigid", "t, s", [("u, N m", [efforts["rigid"]])]),
    )
    part.draw("4.17", *_detail(logs))


def _under_pid(document: Mechanism, scenario: Scenario) -> Log:
    return simulate_closed_loop(
        MechanismPlant(document, assemble(document)), controller("linear"), scenario, HERE
    )


def _main(log: Log) -> Stream:
    return next(one for one in log.streams if one.topic == MAIN_TOPIC)


def _around(holds: list[Ramps]) -> str:
    """Return middle and half range of the ramps of each hold as text."""
    return (
        ", ".join(f"{round(one.centre, 3) + 0.0:.3f} ± {one.half:.3f}" for one in holds)
        + " N m on the five holds"
    )


def _second_hold(log: Log) -> list[Curve]:
    """Return position and reference of the second hold after its step."""
    stream = _main(log)
    reference = stream.signals["reference"]
    starts = np.flatnonzero(np.diff(reference)) + 1
    shown = slice(int(starts[0]) + round(AFTER / PERIOD), int(starts[1]))
    return [
        Curve(stream.time[shown], stream.signals["position"][shown], "theta"),
        Curve(stream.time[shown], reference[shown], "reference", "reference"),
    ]


def _detail(logs: dict[str, Log]) -> tuple[str, str]:
    """Draw figure 4.17: the second step of both mechanisms, and of the one-inertia model."""
    one = simulate_closed_loop(
        load(CLUTCH / "nonlinear.yaml", Model), controller("linear"), _short(), HERE
    )
    everything = {
        "compliant flanks": logs["yielding"],
        "rigid flanks": logs["rigid"],
        "one inertia (4.45)": one,
    }
    rows: list[Row] = [("theta, rad", []), ("u, N m", [])]
    least = math.inf
    for name, log in everything.items():
        stream = _main(log)
        first = stream.time <= DETAIL
        rows[0][1].append(Curve(stream.time[first], stream.signals["position"][first], name))
        rows[1][1].append(Curve(stream.time[first], stream.signals["effort"][first]))
        least = min(least, int(first.sum()))
    count = int(least)
    apart = max(
        float(np.max(np.abs(curve.y[:count] - rows[0][1][0].y[:count]))) for curve in rows[0][1]
    )
    return (
        f"The first step in detail: the positions are at most {apart:.2f} rad apart, the backlash "
        "is 3 rad.",
        draw("detail", "t, s", rows),
    )


def _short() -> Scenario:
    scenario = load(CLUTCH / "scenarios/rebound.yaml", Scenario)
    first = msgspec.structs.replace(scenario.steps[0], duration_s=DETAIL)
    return msgspec.structs.replace(scenario, steps=(first,))
