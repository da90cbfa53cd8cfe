"""Arrays that the assembly makes of a document: ratios with their signs, losses, play at the second
end, offsets, levels, speeds; all in SI."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from frictool.friction.law_registry import LAWS, ROWS
from frictool.plant.mechanism.packed_mechanism import FRAME
from tests.support.mechanism_documents import TRAIN, assembled


def test_the_train(tmp_path: Path) -> None:
    train = assembled(TRAIN, tmp_path)
    packed = train.packed
    assert (train.blocks, train.kinds) == (
        ("motor", "shaft", "cart"),
        ("rotary", "rotary", "linear"),
    )
    assert packed.inertia == pytest.approx([2e-5, 3e-4, 0.5])
    joints = packed.joints
    assert train.joints == ("reducer", "rack")
    assert (joints.a.tolist(), joints.b.tolist()) == ([0, 1], [1, 2])
    assert joints.ratio == pytest.approx([-0.25, 0.01])
    assert joints.gap == pytest.approx([0.0, 1e-4])  # half of the width, at the cart
    assert joints.drive_loss == pytest.approx([0.25 * (1 / 0.9 - 1), 0.0])
    assert joints.back_loss == pytest.approx(
        [0.25 * (1 / 0.9 - 1), 0.0]
    )  # the same friction both ways
    couplings = packed.couplings
    assert train.couplings == ("spring",)
    assert (couplings.a.tolist(), couplings.b.tolist()) == ([FRAME], [2])
    assert couplings.stiffness == pytest.approx([2000.0])
    assert couplings.offset == pytest.approx(
        [-10.0 / 2000.0]
    )  # at the start it opposes with its preload
    assert packed.frictions.law.tolist() == [ROWS.index(LAWS["coulomb"])]
    assert packed.frictions.law_values == pytest.approx([0.005])
    assert (packed.stops.low[0], packed.stops.high[0]) == pytest.approx((-0.005, 0.04))
    assert packed.sources.limit == pytest.approx([10.0])
    assert [group.blocks for group in train.groups] == [(0, 1), (2,)]
    assert train.groups[0].inertia == pytest.approx(2e-5 + 3e-4 / 16)
    # one speed over the ratios
    assert packed.scale[1:] / packed.scale[:-1] == pytest.approx([0.25, 0.01])


def test_a_known_top_speed_is_the_scale(tmp_path: Path) -> None:
    train = assembled(
        TRAIN + "top_speed: {value: 3000, unit: rpm}\ntravel: {low: 0, high: 300, unit: rad}\n",
        tmp_path,
    )
    assert train.packed.scale[0] == pytest.approx(3000 * 2 * math.pi / 60)


TWO = """\
format: mechanism/1
name: two
blocks: {{a: {{{a}}}, b: {{{b}}}}}
links: {{link: {{{link}}}}}
sources: {{push: {{on: a, drive: effort}}}}
"""
TURNS, SLIDES = "inertia: {value: 1, unit: kg m^2}", "mass: {value: 1, unit: kg}"


@pytest.mark.parametrize(
    ("blocks", "link", "ratio", "gap"),
    [
        ("tt", "kind: gear, ratio: 3, internal: true", 3.0, 0.0),
        ("tt", "kind: gear, ratio: 3, backlash: {width: {value: 0.1, unit: rad}}", -3.0, 0.05),
        ("tt", "kind: gear, ratio: 3, backlash: {width: {value: 0.1, unit: rad}, at: a}", -3.0,
        0.15),
        ("tt", "kind: belt, radius_a: {value: 2, unit: cm}, radius_b: {value: 8, unit: cm}, "
               "crossed: true", -0.25, 0.0),
        ("ts", "kind: screw, radius: {value: 4, unit: mm}, lead: {value: 5, unit: mm}",
        5e-3 / (2 * math.pi), 0.0),
        ("ts", "kind: screw, radius: {value: 4, unit: mm}, lead_angle: {value: 10, unit: deg}, "
               "left_handed: true",
         -4e-3 * math.tan(math.radians(10)), 0.0),
        ("ts", "kind: rack, radius: {value: 2, unit: mm}, backlash: {width: {value: 3, unit: "
               "rad}}", 2e-3, 3e-3),
        ("ts", "kind: rack, radius: {value: 2, unit: mm}, backlash: {width: {value: 3, unit: "
               "mm}}, reversed: true", -2e-3, 1.5e-3),
        ("ss", "kind: hydraulic, area_a: {value: 3, unit: cm^2}, area_b: {value: 5, unit: cm^2}",
        0.6, 0.0),
        ("ss", "kind: coupling", 1.0, 0.0),
    ],
)  # fmt: skip
def test_ratios_and_play(blocks: str, link: str, ratio: float, gap: float, tmp_path: Path) -> None:
    a, b = (TURNS if kind == "t" else SLIDES for kind in blocks)
    joints = assembled(
        TWO.format(a=a, b=b, link=link + ", between: [a, b]"), tmp_path
    ).packed.joints
    assert joints.ratio == pytest.approx([ratio], rel=1e-12)
    assert joints.gap == pytest.approx([gap], rel=1e-12)


def test_a_belts_compliance_is_along_the_belt(tmp_path: Path) -> None:
    link = (
        "kind: belt, between: [a, b], radius_a: {value: 2, unit: cm}, radius_b: {value: 8, unit: "
        "cm}, "
        "compliance: {stiffness: {value: 500, unit: N/m}, damping: {value: 3, unit: N s/m}}"
    )
    couplings = assembled(TWO.format(a=TURNS, b=TURNS, link=link), tmp_path).packed.couplings
    assert couplings.stiffness == pytest.approx([500 * 0.08**2])
    assert couplings.damping == pytest.approx([3 * 0.08**2])


@pytest.mark.parametrize("mu", [0.05, 0.3])
def test_a_threads_losses(mu: float, tmp_path: Path) -> None:
    """Raising takes f r tan(alpha + phi), lowering gives back f r tan(alpha - phi), which turns its
    sign where mu > tan(alpha)."""
    steep = 5.0 / (2 * math.pi * 4.0)
    alpha, phi = math.atan(steep), math.atan(mu)
    link = (
        f"kind: screw, between: [a, b], radius: {{value: 4, unit: mm}}, lead: {{value: 5, "
        f"unit: mm}}, friction_coefficient: {mu}"
    )
    joints = assembled(TWO.format(a=TURNS, b=SLIDES, link=link), tmp_path).packed.joints
    assert joints.ratio[0] + joints.drive_loss[0] == pytest.approx(4e-3 * math.tan(alpha + phi))
    assert joints.ratio[0] - joints.back_loss[0] == pytest.approx(4e-3 * math.tan(alpha - phi))
    assert (joints.ratio[0] - joints.back_loss[0] < 0.0) == (mu > steep)
    printed = assembled(
        TWO.format(a=TURNS, b=SLIDES, link=link + ", friction_form: thesis"), tmp_path
    ).packed.joints
    assert (printed.thread[0], printed.thesis_screw[0]) == pytest.approx((mu * 4e-3, mu * steep))
    assert printed.drive_loss[0] == printed.back_loss[0] == 0.0


def test_positions_count_from_the_start(tmp_path: Path) -> None:
    """At the start every link fits, and no spring without `free` is strained."""
    a, b = f"{TURNS}, start: {{value: 10, unit: rad}}", f"{SLIDES}, start: {{value: 7, unit: mm}}"
    spring = "s: {kind: spring, between: [b, ground], stiffness: {value: 1, unit: N/m}"
    link = "kind: rack, between: [a, b], radius: {value: 2, unit: mm}}, " + spring
    two = assembled(TWO.format(a=a, b=b, link=link), tmp_path)
    assert two.start == pytest.approx([10.0, 7e-3])
    assert two.packed.joints.offset == pytest.approx([7e-3 - 20e-3])
    assert two.packed.couplings.offset == pytest.approx([7e-3])


@pytest.mark.parametrize(
    ("sides", "low", "high"), [("low: -1, high: 3", -1.0, 3.0), ("high: 3", -math.inf, 3.0)]
)
def test_compliant_stops_are_play_against_the_frame(
    sides: str, low: float, high: float, tmp_path: Path
) -> None:
    given = ", ".join(
        f"{side.split(': ')[0]}: {{value: {side.split(': ')[1]}, unit: mm}}"
        for side in sides.split(", ")
    )
    soft = "compliance: {stiffness: {value: 1, unit: N/m}, damping: {value: 0, unit: N s/m}}"
    link = f"kind: stop, on: b, {given}, {soft}}}, rod: {{kind: coupling, between: [a, b]"
    couplings = assembled(TWO.format(a=SLIDES, b=SLIDES, link=link), tmp_path).packed.couplings
    assert couplings.offset[0] + couplings.gap[0] == pytest.approx(1e-3 * high, abs=1e-12)
    if math.isfinite(low):
        assert couplings.offset[0] - couplings.gap[0] == pytest.approx(1e-3 * low, abs=1e-12)
    else:
        assert couplings.offset[0] - couplings.gap[0] < -500.0


@pytest.mark.parametrize("law", list(LAWS))
def test_every_law_is_taken_with_its_parameters_names_and_units(law: str, tmp_path: Path) -> None:
    """In the units of a block that turns, scaled; what the law needs of inertia is the group's
    where it is not given."""
    needed = [
        parameter
        for parameter in LAWS[law].parameters
        if parameter.name != "inertia" and parameter.default is None
    ]
    values = {
        parameter.name: 0.1 if parameter.name == "elastic_limit" else 2.0 + i
        for i, parameter in enumerate(needed)
    }
    given = ", ".join(
        f"{needs.name}: {{value: {values[needs.name] * 1e3}, unit: {_milli(needs.unit('rotary'))}}}"
        for needs in needed
    )
    link = (
        f"kind: friction, on: a, law: {law}, parameters: {{{given}}}}}, shaft: {{kind: "
        "coupling, between: [a, b]"
    )
    two = assembled(TWO.format(a=TURNS, b=TURNS, link=link), tmp_path)
    names = [parameter.name for parameter in LAWS[law].parameters]
    found = dict(zip(names, two.packed.frictions.law_values.tolist(), strict=False))
    assert {name: found[name] for name in values} == pytest.approx(values, rel=1e-12)
    assert found.get("inertia", 2.0) == 2.0  # of both blocks
    assert np.all(np.isfinite(two.packed.frictions.law_values))


def _milli(unit: str) -> str:
    return "1/ks" if unit == "1/s" else f"m{unit}"
