"""A mechanism whose sources follow signals: instants within a sample, impulses, what is logged."""

from __future__ import annotations

import math

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from frictool.adapters.mechanism.assembly import assemble
from frictool.documents.conditions import Disturbance, Signal
from frictool.documents.quantity import Quantity
from frictool.documents.scenario import Scenario
from frictool.errors import InputFileError
from frictool.logs.log import Log
from frictool.simulate.document_agreement import DocumentNames
from frictool.simulate.mechanism_channels import field_names
from frictool.simulate.mechanism_inputs import inputs_of, mean_over
from frictool.simulate.open_loop import simulate_open_loop
from tests.support.mechanism_text import mechanism
from tests.support.provenance import HERE
from tests.support.simulated_mechanisms import FREE_MASS, GEARED

NAMES = DocumentNames("mechanism.yaml", scenario="scenario.yaml")
MASS = 2.0


def signal(kind: str, level: float, unit: str = "N", **keys: float) -> Signal:
    return Signal(kind, Quantity(value=level, unit=unit), **keys)


def played(
    text: str,
    sources: dict[str, tuple[Signal, ...]],
    seconds: float = 0.1,
    axis: str = "linear",
    **keys: object,
) -> Log:
    made = Scenario(
        format="scenario/1", name="torques", axis=axis, sources=sources, duration_s=seconds
    )
    document = mechanism(text)
    return simulate_open_loop(
        document, assemble(document), msgspec.structs.replace(made, **keys), HERE, NAMES
    )


@given(at=st.floats(0.0, 0.0999), level=st.floats(-50.0, 50.0))
def test_a_step_within_a_sample_acts_from_its_instant(at: float, level: float) -> None:
    log = played(FREE_MASS, {"push": (signal("step", level, at_s=at),)})
    time, sled = log.main.time, log.streams[1].signals
    since = np.maximum(time - at, 0.0)
    np.testing.assert_allclose(
        sled["sled_position"], 0.5 * level / MASS * since**2, atol=1e-12, rtol=1e-9
    )
    np.testing.assert_allclose(sled["sled_velocity"], level / MASS * since, atol=1e-12, rtol=1e-9)


def test_ramp_pulse_and_sine_add_up() -> None:
    """The speed is the integral of the force, at every sample; the position's error is of second
    order in the period."""
    parts = (
        signal("ramp", 3.0, at_s=0.01, duration_s=0.0303),
        signal("pulse", -8.0, at_s=0.02, duration_s=0.0101),
        signal("sine", 5.0, at_s=0.0333, frequency_hz=40.0, phase_deg=30.0),
    )
    sled = played(FREE_MASS, {"push": parts}).streams[1]
    fine = np.linspace(0.0, 0.1, 1_000_001)
    ramp = 3.0 * np.clip((fine - 0.01) / 0.0303, 0.0, 1.0)
    pulse = np.where((fine >= 0.02) & (fine < 0.0301), -8.0, 0.0)
    sine = np.where(
        fine >= 0.0333,
        5.0 * np.sin(2.0 * math.pi * 40.0 * (fine - 0.0333) + math.radians(30.0)),
        0.0,
    )
    force = ramp + pulse + sine
    speed = np.concatenate([[0.0], np.cumsum(0.5 * (force[1:] + force[:-1]))]) * 1e-7 / MASS
    place = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]))]) * 1e-7
    np.testing.assert_allclose(sled.signals["sled_velocity"], speed[:-1:10000], atol=2e-6)
    np.testing.assert_allclose(sled.signals["sled_position"], place[:-1:10000], atol=1e-6)


@given(
    kind=st.sampled_from(["step", "pulse", "ramp", "sine"]),
    at=st.floats(0.0, 0.05),
    lasts=st.floats(1e-4, 0.05),
    frequency=st.floats(1.0, 400.0),
    phase=st.floats(0.0, 360.0),
)
def test_parts_keep_the_impulse_of_every_course(
    kind: str, at: float, lasts: float, frequency: float, phase: float
) -> None:
    """Wherever a course begins and ends: the sum over the parts is its integral."""
    keys = {"at_s": at}
    keys |= {"duration_s": lasts} if kind != "step" else {}
    keys |= {"frequency_hz": frequency, "phase_deg": phase} if kind == "sine" else {}
    course = signal(kind, 4.0, **keys)
    found = inputs_of({0: (course,)}, [], 1, 100, 1e-3)
    w, p, end = 2.0 * math.pi * frequency, math.radians(phase), min(at + lasts, 0.1)
    whole = {
        "step": 4.0 * (0.1 - at),
        "pulse": 4.0 * (end - at),
        "ramp": 4.0 * (0.5 * lasts + 0.1 - at - lasts),
        "sine": 4.0 / w * (math.cos(p) - math.cos(w * (end - at) + p)),
    }[kind]
    assert found.first[0] == 0
    assert found.first[-1] == found.durations.size
    assert float(np.sum(found.durations)) == pytest.approx(0.1)
    assert float(found.drives[:, 0] @ found.durations) == pytest.approx(whole, abs=1e-9)


def test_a_course_that_coincides_with_samples_cuts_none() -> None:
    found = inputs_of({0: (signal("pulse", 1.0, at_s=0.003, duration_s=0.007),)}, [], 1, 20, 1e-3)
    np.testing.assert_array_equal(found.first, np.arange(21))
    np.testing.assert_array_equal(found.drives[:, 0], np.r_[np.zeros(3), np.ones(7), np.zeros(10)])


def test_means_of_a_step_are_whole_on_either_side() -> None:
    edges = np.array([0.0, 0.3, 1.0])
    np.testing.assert_array_equal(mean_over(signal("step", 2.0, at_s=0.3), 2.0, edges), [0.0, 2.0])


def test_what_is_not_determined_is_not_logged_as_an_axis() -> None:
    """Two sources and no `control`: all blocks, and no /axis; what would need one is refused."""
    text = GEARED.replace("control: {source: motor, sensor: encoder}\n", "")
    sources = {
        "motor": (signal("step", 8.0, "A"),),
        "hand": (signal("pulse", -0.2, "N m", at_s=0.02, duration_s=0.01),),
    }
    log = played(text, sources, axis="rotary")
    assert [stream.topic for stream in log.streams] == ["/mechanism"]
    blocks = log.main.signals
    assert blocks["rotor_position"][-1] > 1.0
    assert blocks["hand_effort"][[19, 25, 31]] == pytest.approx([0.0, -0.2, 0.0])
    for keys, words in (
        (
            {"start": Quantity(value=1.0, unit="rad")},
            "start: belongs to the controlled axis, but mechanism.yaml does not state the source",
        ),
        (
            {"disturbances": (Disturbance("step", Quantity(value=0.1, unit="N m"), 0.0),)},
            r"disturbances\[0\]: names no block",
        ),
    ):
        with pytest.raises(InputFileError, match=words):
            played(text, sources, axis="rotary", **keys)


def test_a_held_effort_on_a_named_block_is_logged_there() -> None:
    push = Disturbance("step", Quantity(value=0.2, unit="N m"), 0.0305, on="Load")
    log = played(GEARED, {}, axis="rotary", disturbances=(push,))
    assert "disturbance" not in log.main.signals
    np.testing.assert_allclose(
        log.streams[1].signals["load_disturbance"][29:33], [0.0, 0.1, 0.2, 0.2]
    )
    assert log.streams[1].signals["load_position"][-1] > 0.1
    energy = {name: float(value) for name, value in log.metadata["energy/mechanism"].items()}
    assert energy["input"] > 0.0
    assert abs(energy["residual"]) < 1e-6 * energy["input"]


def test_names_of_signals_are_those_that_ros_takes() -> None:
    assert field_names(["M6", "a__b_", "m6"], ["a_b"]) == {
        "M6": "m6",
        "a__b_": "a_b_2",
        "m6": "m6_2",
    }


@pytest.mark.parametrize(
    ("sources", "keys", "words"),
    [
        (
            {"pull": (signal("step", 1.0),)},
            {},
            "sources.pull: mechanism.yaml has no such source; allowed: push",
        ),
        (
            {"push": (signal("step", 1.0, "A"),)},
            {},
            r"sources.push\[0\].level.unit: found a multiple of A; allowed: N",
        ),
        (
            {"push": (signal("sine", 1.0, frequency_hz=500.0),)},
            {},
            r"sources.push\[0\].frequency_hz: found 500; allowed: below half",
        ),
        (
            {"push": (signal("step", 1.0, at_s=0.2),)},
            {},
            r"sources.push\[0\].at_s: found 0.2, after the end",
        ),
        (
            {"push": (signal("pulse", 1.0, at_s=0.05, duration_s=0.1),)},
            {},
            r"sources.push\[0\].duration_s: ends at 0.15 s, after the end",
        ),
        ({}, {"duration_s": 1e-5}, "duration_s: found 1e-05; allowed: at least one sample"),
        ({}, {"duration_s": 1e9}, r"duration_s: requests 1e\+12 samples"),
        ({}, {"variants": "vertices"}, "variants: found vertices, which only a single axis has"),
        (
            {},
            {"axis": "rotary"},
            "axis: found rotary, but the sensor's block of mechanism.yaml is linear",
        ),
        (
            {},
            {"disturbances": (Disturbance("step", Quantity(value=1.0, unit="N m"), 0.0),)},
            "effort.unit: unit 'N m' is not a unit of effort for a linear axis",
        ),
        (
            {},
            {
                "disturbances": (
                    Disturbance("step", Quantity(value=1.0, unit="N"), 0.0, on="sledge"),
                )
            },
            "has no block 'sledge'",
        ),
        (
            {},
            {
                "disturbances": (
                    Disturbance("step", Quantity(value=1.0, unit="N m"), 0.0, on="sled"),
                )
            },
            "allowed: N and its multiples",
        ),
    ],
)
def test_what_does_not_fit_is_refused(
    sources: dict[str, tuple[Signal, ...]], keys: dict[str, object], words: str
) -> None:
    with pytest.raises(InputFileError, match=f"scenario.yaml: .*{words}"):
        played(FREE_MASS, sources, **keys)


def test_a_link_that_would_take_steps_without_end_is_refused() -> None:
    """A flank keeps its damping, because its rebound depends on it."""
    soft = "compliance: {stiffness: {value: 1.0e15, unit: N/m}, damping: {value: 0, unit: N s/m}}"
    ends = "low: {value: -1, unit: m}, high: {value: 1, unit: m}"
    text = with_link(f"  ends: {{kind: stop, on: sled, {ends}, {soft}}}\n")
    with pytest.raises(
        InputFileError,
        match=r"mechanism.yaml: links.ends: too stiff.*2.24e\+07 rad/s; allowed: at most "
        r"1e\+07 rad/s",
    ):
        played(text, {"push": (signal("step", 1.0),)})


def with_link(link: str) -> str:
    if "links:" in FREE_MASS:
        return FREE_MASS.replace("links:\n", "links:\n" + link)
    return FREE_MASS + "links:\n" + link


def test_the_oscillation_of_a_stiff_link_is_damped_and_estimated() -> None:
    """A step F on a mass m at a spring k deflects it by F/k; the oscillation about this has the
    amplitude F/k and the speed F/sqrt(k m)."""
    force, stiffness = 3.0, 1e13
    text = with_link(
        "  spring: {kind: spring, between: [sled, ground], stiffness: {value: 1.0e13, unit: N/m}}\n"
    )
    log = played(text, {"push": (signal("step", force),)})
    np.testing.assert_allclose(
        log.streams[1].signals["sled_position"][1:], force / stiffness, rtol=1e-6
    )
    speed = force / math.sqrt(stiffness * MASS)
    warnings = [line for line in log.warnings if "spring" in line]
    assert warnings[0].startswith("spring: the link's natural frequency of 2.24e+06 rad/s is ")
    assert f"about {force / stiffness:.2g} m and {speed:.2g} m/s" in warnings[1]
