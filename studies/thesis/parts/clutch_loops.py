"""Section 5.4 on the SIMULATED clutch: table 5.3, specification 5.4.1, loops of 5.4 and annex C.

The figures are 5.18 to 5.33 and C.11 to C.13.
"""

from __future__ import annotations

from statistics import mean

import numpy as np
from scipy.signal import step
from scipy.stats import beta

from frictool.logs.log import MAIN_TOPIC, Log, Stream
from studies.clutch.requirement_counts import Counted, counted, spends_least
from studies.clutch.rig import controller, played, spec
from studies.thesis.drawing import Curve, Row, draw
from studies.thesis.results import ComputedValue, Part

DESIGNS = {
    "rst": "RST of order 5",
    "position": "position (5.4.3)",
    "speed": "speed and square root (5.4.4)",
}
PLANTS = (
    "counts/plants_1",
    "counts/plants_2",
)  # the 1000 random plants of `make -C configs/clutch counts`
WINDOW = 0.5  # s of the first step
ANNEX_WINDOW = 0.3  # s


def clutch_loops() -> Part:
    """Return the part with every loop of 5.4."""
    part, found = Part(), {}
    nominal: dict[str, Stream] = {}
    for design in (*DESIGNS, "annex"):
        nominal[design] = _first(played(design, "scenarios/vertices"))
        scenarios = ("scenarios/vertices", *(PLANTS if design in DESIGNS else ()))
        found[design] = counted(
            spec(), controller(design), (played(design, scenario) for scenario in scenarios)
        )
    _table_5_3(part, found)
    _specification(part, found)
    _annex(part, found["annex"])
    _draw(part, nominal)
    return part


def _table_5_3(part: Part, found: dict[str, Counted]) -> None:
    """Add table 5.3: energy of two steps of the nominal plant, and over all plants."""
    for design in DESIGNS:
        energies = [
            value
            for plant in (*found[design].vertices, *found[design].plants)
            for value in plant.energy
        ]
        part.add("table_5_3", {design: mean(found[design].nominal.energy)})
        part.say(
            "table_5_3",
            f"{DESIGNS[design]}: {min(energies):.0f} to {max(energies):.0f} A² over the vertices "
            "and random plants, "
            f"{mean(energies):.0f} in the mean.",
        )
    saved = 100.0 * (1.0 - mean(found["speed"].nominal.energy) / mean(found["rst"].nominal.energy))
    part.add(
        "table_5_3",
        {
            "saved": saved,
            "least": "speed" if spends_least([found[name] for name in DESIGNS]) else "another",
        },
    )
    part.say(
        "table_5_3",
        "On the SIMULATED clutch: the mean of the steps from 5 to 55 rad and back, nominal plant.",
    )


def _specification(part: Part, found: dict[str, Counted]) -> None:
    """Add 5.4.1: values of the nominal plant, and number of plants that meet it."""
    for design in ("position", "speed"):
        plant = found[design].nominal
        assert plant.response is not None
        every = [one.response for one in found[design].vertices if one.response is not None]
        response = ComputedValue(
            1e3 * plant.response, 1e3 * min(every), 1e3 * max(every), "over the vertices"
        )
        part.add("section_5_4", {f"{design}.response": response})
        part.add(
            "section_5_4", {f"{design}.overshoot": "met" if plant.met["overshoot"] else "missed"}
        )
        part.add(
            "section_5_4",
            {f"{design}.static_error": "met" if plant.met["static_error"] else "missed"},
        )
        part.add(
            "section_5_4",
            {f"{design}.rest": "no current" if plant.rest_drive == 0.0 else "current"},
        )
    part.add(
        "section_5_4",
        {"rst.rest": "no current" if found["rst"].nominal.rest_drive == 0.0 else "current"},
    )
    for design, title in DESIGNS.items():
        vertices, plants = (
            sum(one.all_met for one in group)
            for group in (found[design].vertices, found[design].plants)
        )
        low, high = _interval(plants, len(found[design].plants))
        part.say(
            "section_5_4",
            f"{title}: all of 5.4.1 at {vertices} of {len(found[design].vertices)} vertices and "
            f"on {plants} of {len(found[design].plants)} "
            f"random plants (95 %: {low:.1f} to {high:.1f} %); modulus margin "
            f"{found[design].margin:.2f} at the worst vertex.",
        )


def _interval(met: int, of: int) -> tuple[float, float]:
    """Return Clopper and Pearson's 95 % interval of a rate, in %."""
    low = 0.0 if met == 0 else float(beta.ppf(0.025, met, of - met + 1))
    high = 1.0 if met == of else float(beta.ppf(0.975, met + 1, of - met))
    return 100.0 * low, 100.0 * high


def _annex(part: Part, found: Counted) -> None:
    """Add C.5.3: the annex's form, designed at the bench's period."""
    plant = found.nominal
    assert plant.response is not None
    assert plant.error is not None
    part.add("annex_c_5_3", {"response": 1e3 * plant.response, "static_error": plant.error})
    prefilter = controller("annex").prefilter
    assert prefilter is not None
    slowest = _alone(prefilter.natural_frequency_rad_s, prefilter.damping)
    part.say("annex_c_5_3", f"The prefilter (5.69) alone takes {1e3 * slowest:.0f} ms to 95 %.")
    part.say(
        "annex_c_5_3", f"designs/annex.yaml: modulus margin {found.margin:.2f} at the worst vertex."
    )


def _alone(natural: float, damping: float) -> float:
    """Return the 95 % response time of a prefilter alone [s]."""
    time = np.linspace(0.0, 20.0 / natural, 20_001)
    _, output = step(([1.0], [1.0 / natural**2, 2.0 * damping / natural, 1.0]), T=time)
    return float(time[np.flatnonzero(np.abs(output - 1.0) > 0.05)[-1]])


def _first(log: Log) -> Stream:
    return next(stream for stream in log.streams if stream.topic == MAIN_TOPIC)


def _draw(part: Part, streams: dict[str, Stream]) -> None:
    for numbers, design in (
        (("5.18", "5.19", "5.20"), "position"),
        (("5.26", "5.27", "5.29"), "speed"),
    ):
        stream = streams[design]
        _signal(part, numbers[0], stream, "theta, rad", ("position",))
        _signal(part, numbers[1], stream, "u, N m", ("effort",))
        _signal(part, numbers[2], stream, "x behind the backlash, rad", ("load_position",))
    speed = streams["speed"]
    _signal(part, "5.28", speed, "omega, rad/s", ("velocity",))
    three = {title: streams[name] for name, title in DESIGNS.items()}
    _together(part, "5.32", three, ("position",), "theta, rad", WINDOW)
    _together(part, "5.33", three, ("current",), "i, A", WINDOW)
    annex = {"annex C, sampled": streams["annex"], "speed (5.4.4)": streams["speed"]}
    _together(part, "C.11", annex, ("position",), "theta, rad", 2.2)
    _together(part, "C.12", annex, ("current",), "i, A", 2.2)
    _together(part, "C.13", annex, ("position",), "theta, rad", ANNEX_WINDOW)


def _signal(part: Part, number: str, stream: Stream, label: str, names: tuple[str, ...]) -> None:
    shown = stream.time <= WINDOW
    name = next(one for one in names if one in stream.signals)
    values = stream.signals[name][shown]
    curves = [Curve(stream.time[shown], values, "")]
    if name in ("position", "load_position"):
        curves.append(
            Curve(stream.time[shown], stream.signals["reference"][shown], "reference", "reference")
        )
    unit = label.rpartition(", ")[2]
    part.draw(
        number,
        "The step from 5 to 55 rad on the nominal plant: "
        f"{values.min():.4g} to {values.max():.4g} {unit}; {values[-1]:.4g} {unit} at {WINDOW:g} "
        "s.",
        draw(f"figure {number}", "t, s", [(label, curves)]),
    )


def _together(
    part: Part,
    number: str,
    streams: dict[str, Stream],
    names: tuple[str, ...],
    label: str,
    window: float,
) -> None:
    rows: list[Row] = [(label, [])]
    captions = []
    for title, stream in streams.items():
        shown = stream.time <= window
        values = stream.signals[names[0]][shown]
        rows[0][1].append(Curve(stream.time[shown], values, title))
        captions.append(
            f"{title}: {values.min():.4g} to {values.max():.4g} {label.rpartition(', ')[2]}"
        )
    if names[0] == "position":
        stream = next(iter(streams.values()))
        shown = stream.time <= window
        rows[0][1].append(
            Curve(stream.time[shown], stream.signals["reference"][shown], "reference", "reference")
        )
    part.draw(number, f"{'; '.join(captions)}.", draw(f"figure {number}", "t, s", rows))
