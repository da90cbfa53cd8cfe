"""Chapters 2 and 3: friction laws in the four tests of 3.7, and speed of their simulation.

The tables are 2.1 and 3.2, the figures 3.11 to 3.25.
"""

from __future__ import annotations

import time
from pathlib import Path

from frictool.compare import input_protocol
from frictool.compare.comparison import Comparison, compare
from frictool.compare.comparison_setting import ComparisonSetting, from_friction
from frictool.compare.law_simulator import LawSimulator
from frictool.compare.thesis_figures import pictures
from frictool.compare.thesis_tables import TABLE_2_1, TABLE_3_2
from frictool.documents.friction import Friction
from frictool.documents.registry import load
from studies.thesis.results import ComputedValue, Part

RIG = Path(__file__).parents[3] / "configs/mass"
REPEATS = 3  # timed simulations of a law, of which the fastest counts
REAL_TIME = 10.0  # factor on real time from which on the stick-slip test counts as "+"
WITHOUT_PRINT = ("stribeck",)  # reference law, which the printed tables do not contain


def laws() -> Part:
    """Return the part with tables 2.1 and 3.2 and their figures."""
    setting = from_friction(load(RIG / "friction.yaml", Friction))
    simulator = LawSimulator(setting)
    asked = {*TABLE_2_1, *TABLE_3_2, *WITHOUT_PRINT}
    found = compare(setting, simulator, tuple(law for law in simulator.names() if law in asked))
    part = Part()
    part.add(
        "table_2_1",
        {
            f"{law}.{row}": found.laws[law].properties[row]
            for law in TABLE_2_1
            for row in found.laws[law].properties
        },
    )
    part.add(
        "table_3_2",
        {
            f"{law}.{row}": cell
            for law in TABLE_3_2
            for row, cell in found.laws[law].verdicts.items()
        },
    )
    part.add("table_2_1", _speeds(simulator, setting))
    part.say(
        "table_2_1",
        f"Speed of simulation: + where the stick-slip test of 60 s runs at least {REAL_TIME:g} "
        "times faster than real time.",
    )
    for picture in pictures(found):
        if picture.title:  # the number of the figure in the thesis
            part.draw(picture.title, _caption(found, picture.title), picture.svg)
    return part


def _speeds(
    simulator: LawSimulator, setting: ComparisonSetting
) -> dict[str, float | str | ComputedValue]:
    """Return the last row of table 2.1 as + or -, since times would differ between two runs."""
    segments, cells = input_protocol.stick_slip(setting.scales), {}
    end = segments[-1][0]
    for law in TABLE_2_1:
        took = []
        for _ in range(REPEATS):
            start = time.perf_counter()
            simulator.run(law, segments, 1001)
            took.append(time.perf_counter() - start)
        cells[f"{law}.speed"] = "+" if end > REAL_TIME * min(took) else "-"
    return {**cells}


def _caption(found: Comparison, number: str) -> str:
    """Return the caption of figure `number`: the results of the laws that the figure shows."""
    reference = found.reference
    known = f"event-exact Stribeck: {reference.sticks} sticks, period {reference.period_s:.4f} s"
    cycle = found.reference_cycle
    chosen = {
        "3.11": ("stick_slip", ("lugre",)),
        "3.12": ("stick_slip", ("elasto_plastic",)),
        "3.13": ("stick_slip", ("hybrid_a", "lugre")),
        "3.14": ("stick_slip", ("hybrid_b", "lugre")),
        "3.15": ("limit_cycle", ("hybrid_a", "lugre")),
        "3.16": ("limit_cycle", ("elasto_plastic",)),
        "3.18": ("presliding", ("lugre",)),
        "3.19": ("presliding", ("elasto_plastic",)),
        "3.20": ("presliding", ("hybrid_b",)),
        "3.21": ("presliding", ("hybrid_c",)),
        "3.23": ("drift", ("lugre", "elasto_plastic")),
        "3.24": ("drift", ("hybrid_a", "hybrid_b", "hybrid_c")),
        "3.25": ("drift", ("hybrid_a", "hybrid_b", "hybrid_c")),
    }.get(number)
    if chosen is None:
        return "Input of the test, with the parameters of table 3.1."
    test, names = chosen
    text = "; ".join(_law_caption(found, test, law) for law in names)
    if test == "stick_slip":
        return f"{text} ({known})."
    if test == "limit_cycle":
        return f"{text} (event-exact Stribeck: ±{cycle.amplitude:.4f} m, {cycle.period_s:.2f} s)."
    return f"{text}."


def _law_caption(found: Comparison, test: str, law: str) -> str:
    tested = found.laws[law]
    if test == "stick_slip":
        period = (
            "none" if tested.stick_slip.period_s is None else f"{tested.stick_slip.period_s:.4f} s"
        )
        return (
            f"{tested.title}: {tested.stick_slip.sticks} "
            f"stick{'s' if tested.stick_slip.sticks != 1 else ''}, period {period}"
        )
    if test == "limit_cycle":
        cycle = tested.limit_cycle
        if cycle.period_s is None:
            return f"{tested.title}: dies out"
        return f"{tested.title}: ±{cycle.amplitude:.4f} m, {cycle.period_s:.2f} s"
    if test == "presliding":
        contact = tested.presliding
        return (
            f"{tested.title}: points of return {contact.closure:.3f} F_s apart, loop area "
            f"{contact.area:.3f} F_s z_max"
        )
    return f"{tested.title}: moves by {tested.drift.z_max_units:.3g} z_max over 194 cycles"
