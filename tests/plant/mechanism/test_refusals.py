"""A wrong mechanism is refused in one line: the file, the line and the key of the element, what was
found, what is allowed."""

from __future__ import annotations

from pathlib import Path

import pytest

from frictool.adapters.mechanism.sources_and_sensors import controlled_indices
from frictool.cli.mechanism_file import load_mechanism, mechanism_error
from frictool.errors import EXIT_INPUT, DocumentError
from frictool.plant.mechanism.element_error import ElementError
from tests.support.mechanism_documents import TRAIN

GEAR = "  reducer: {kind: gear, between: [motor, shaft], ratio: 0.25, efficiency: 0.9}\n"
RACK = (
    "  rack: {kind: rack, between: [shaft, cart], radius: {value: 10, unit: mm}, backlash: "
    "{width: {value: 0.2, unit: mm}}}\n"
)
SPRING = (
    "  spring: {kind: spring, between: [cart, ground], stiffness: {value: 2, unit: N/mm}, "
    "preload: {value: 10, unit: N}}\n"
)
BEARING = (
    "  bearing: {kind: friction, on: motor, law: coulomb, parameters: {coulomb: {value: 5, "
    "unit: mN m}}}\n"
)
STOPS = (
    "  ends: {kind: stop, on: cart, low: {value: -5, unit: mm}, high: {value: 40, unit: mm}, "
    "restitution: 0.3}\n"
)
DRIVE = (
    "  drive: {on: motor, drive: current, constant: {value: 20, unit: mN m/A}, limit: "
    "{value: 10, unit: A}}\n"
)
SENSOR = "  encoder: {on: motor, counts_per_revolution: 500}\n"
CART = "  cart: {mass: {value: 500, unit: g}}\n"
SHAFT = "  shaft: {inertia: {value: 3.0e-4, unit: kg m^2}}\n"

# what is replaced, by what, the key told, the words told
WRONG = [
    # names
    (RACK, RACK.replace("shaft, cart", "shaft, carts"), "links.rack.between",
     ["'carts', which is not a block, did you mean 'cart'?"]),
    (SPRING, SPRING.replace("ground", "grond"), "links.spring.between", ["did you mean 'ground'?"]),
    (GEAR, GEAR.replace("motor, shaft", "shaft, shaft"), "links.reducer.between",
     ["both ends on shaft", "two different ends"]),
    (CART, CART + "  ground: {mass: {value: 1, unit: kg}}\n", "blocks.ground",
     ["ground is the frame"]),
    (CART, CART + "  fly wheel: {mass: {value: 1, unit: kg}}\n", "blocks.fly wheel",
     ["'fly wheel'", "letters, digits"]),
    (DRIVE, DRIVE.replace("on: motor", "on: moter"), "sources.drive.on", ["did you mean 'motor'?"]),
    (SENSOR, SENSOR.replace("on: motor", "on: ground"), "sensors.encoder.on",
     ["ground, which does not move"]),
    # ends
    (SPRING, SPRING.replace("[cart, ground]", "[cart]"), "links.spring.between", ["found one end",
     "the frame is an end too: [cart, g"]),
    (SPRING, SPRING.replace("[cart, ground]", "[ground, cart]"), "links.spring.between",
     ["ground as the first end", "[cart, ground]"]),
    (GEAR, GEAR.replace("motor, shaft", "motor, ground"), "links.reducer.between",
     ["would fix motor", "leave the fixed block"]),
    (GEAR, GEAR.replace("motor, shaft", "motor, cart"), "links.reducer.between",
     ["cart, which slides", "allowed for a gear"]),
    (RACK, RACK.replace("shaft, cart", "motor, shaft"), "links.rack.between",
     ["shaft, which turns", "a block that turns and one"]),
    (RACK, RACK.replace("shaft, cart", "cart, shaft"), "links.rack.between",
     ["write [shaft, cart]"]),
    (RACK,
     "  rack: {kind: hydraulic, between: [shaft, cart], area_a: {value: 1, unit: cm^2}, area_b: "
     "{value: 2, unit: cm^2}}\n",
     "links.rack.between", ["shaft, which turns", "a hydraulic link"]),
    # numbers
    (GEAR, GEAR.replace("ratio: 0.25", "ratio: 0"), "links.reducer.ratio",
     ["found 0; allowed: > 0"]),
    (GEAR, GEAR.replace("ratio: 0.25", "ratio: -0.25"), "links.reducer.ratio", ["found -0.25",
     "internal: true"]),
    (RACK, RACK.replace("value: 10, unit: mm", "value: 0, unit: mm"), "links.rack.radius.value",
     ["found 0 mm; allowed: > 0"]),
    (SHAFT, SHAFT.replace("3.0e-4", "-1"), "blocks.shaft.inertia.value", ["allowed: >= 0"]),
    (CART, CART.replace("500", "0"), "blocks.cart",
     ["cart has no inertia; add an inertia, or a rigid link"]),
    (STOPS, STOPS.replace("-5", "5"), "links.ends",
     ["cart starts at 0 m; allowed: 0.005 to 0.04 m"]),
    (CART, CART.replace("500", "5.0e+40"), "blocks.cart.mass.value",
     ["found 5e+37 kg; allowed: 0, or 1e-30 to 1e+30"]),
    # units
    (SPRING, SPRING.replace("N/mm", "N m/rad"), "links.spring.stiffness.unit",
     ["N m/rad; allowed: N/m", "cart slides"]),
    (RACK, RACK.replace("{width: {value: 0.2, unit: mm}}", "{width: {value: 0.2, unit: s}}"),
     "links.rack.backlash.width.unit", ["'s'"]),
    (GEAR, GEAR.replace("efficiency: 0.9", "backlash: {width: {value: 1, unit: mm}}"),
     "links.reducer.backlash.width.unit",
     ["multiple of m, which is the unit of neither end", "motor's rad or shaft's rad"]),
    (RACK, RACK.replace("width: {value: 0.2, unit: mm}",
     "width: {value: 0.2, unit: mm}, at: shaft"), "links.rack.backlash.at",
     ["shaft, whose position is not measured in m; allowed: cart"]),
    (RACK, RACK.replace("radius",
     "compliance: {stiffness: {value: 1, unit: N m/rad}, damping: {value: 1, unit: N s/m}}, "
     "radius"),
     "links.rack.compliance.stiffness.unit", ["allowed: N/m", "is at cart, which slides"]),
    (DRIVE, DRIVE.replace("mN m/A", "N/A"), "sources.drive.constant.unit", ["N/A; allowed: N m/A",
     "motor turns"]),
    (DRIVE, DRIVE.replace("unit: A}", "unit: V}"), "sources.drive.limit.unit", ["V; allowed: A",
     "drive is current"]),
    (SENSOR, SENSOR.replace("on: motor", "on: cart"), "sensors.encoder.counts_per_revolution",
     ["cart slides, without revolutions", "step"]),
    (STOPS, STOPS.replace("-5, unit: mm", "-5, unit: deg"), "links.ends.low.unit",
     ["rad; allowed: m"]),
    (CART, CART.replace("}}", "}, start: {value: 1, unit: rad}}"), "blocks.cart.start.unit",
     ["rad; allowed: m"]),
    # friction
    (BEARING, BEARING.replace("law: coulomb", "law: colomb"), "links.bearing.law",
     ["'colomb', did you mean 'coulomb'?"]),
    (BEARING, BEARING.replace("{coulomb: {", "{colomb: {"), "links.bearing.parameters.colomb",
     ["did you mean coulomb?"]),
    (BEARING, BEARING.replace("law: coulomb", "law: stribeck"), "links.bearing.parameters",
     ["stribeck needs breakaway [N m]"]),
    (BEARING, BEARING.replace("value: 5", "value: -5"), "links.bearing.parameters.coulomb",
     ["coulomb is -0.005 N m; allowed", ">= 0"]),
    (BEARING, BEARING.replace("mN m", "N"), "links.bearing.parameters.coulomb.unit",
     ["'N'; allowed: N m"]),
    # loops
    (RACK,
     RACK + "  belt: {kind: belt, between: [motor, shaft], radius_a: {value: 1, unit: cm}, "
           "radius_b: {value: 4, unit: cm}}\n",
     "links.belt",
     ["moves shaft 0.25 times as far as motor, but the link reducer moves shaft -0.25 times as "
      "far; make the ratios equal"]),
    (SHAFT, SHAFT.replace("kg m^2", "kg"), "blocks.shaft.inertia.unit",
     ["unit 'kg' does not measure rotary inertia; allowed: kg m^2"]),
    (GEAR, GEAR.replace("motor, shaft", "motor, shaft, cart"), "links.reducer.between",
     ["found a list of 3; allowed: at most 2"]),
    # what has no part in anything
    (CART, CART + "  idle: {inertia: {value: 1, unit: kg m^2}}\n", "blocks.idle",
     ["connects idle to the rest", "stop on the ground"]),
]  # fmt: skip


@pytest.mark.parametrize(
    ("old", "new", "key", "words"),
    WRONG,
    ids=[f"{key}-{i}" for i, (_, _, key, _) in enumerate(WRONG)],
)
def test_a_wrong_element_is_named_with_its_line(
    old: str, new: str, key: str, words: list[str], tmp_path: Path
) -> None:
    assert old in TRAIN
    path = tmp_path / "train.yaml"
    path.write_text(TRAIN.replace(old, new, 1))
    with pytest.raises(DocumentError) as caught:
        load_mechanism(path)
    message = str(caught.value)
    line = 1 + next(
        i
        for i, (a, b) in enumerate(
            zip(TRAIN.splitlines(), path.read_text().splitlines(), strict=False)
        )
        if a != b
    )
    assert message.startswith(f"{path}:{line}: {key}: ")
    assert caught.value.exit_code == EXIT_INPUT
    assert "\n" not in message
    for word in words:
        assert word in message


def refusal(text: str, tmp_path: Path) -> str:
    path = tmp_path / "mechanism.yaml"
    path.write_text(text)
    with pytest.raises(DocumentError) as caught:
        load_mechanism(path)
    return str(caught.value)


TRIANGLE = """\
format: mechanism/1
name: triangle
blocks:
  a: {{inertia: {{value: 1, unit: kg m^2}}}}
  b: {{inertia: {{value: 1, unit: kg m^2}}}}
  c: {{inertia: {{value: 1, unit: kg m^2}}}}
links:
  first: {{kind: gear, between: [a, b], ratio: 0.5}}
  second: {{kind: gear, between: [b, c], ratio: 3}}
  closing: {{kind: gear, between: [c, a], {0}}}
sources: {{motor: {{on: a, drive: effort}}}}
"""


def test_a_loop_whose_ratios_disagree_is_told_whole(tmp_path: Path) -> None:
    """Three external gears in a ring lock: the product is negative whatever the ratios."""
    message = refusal(TRIANGLE.format("ratio: 0.66667"), tmp_path)
    assert (
        "mechanism.yaml:10: links.closing: closes the loop c - second - b - first - a - closing, "
        "whose ratios multiply to -0.999995; allowed: a product of 1" in message
    )
    assert "make a link compliant" in message


def test_two_links_that_say_the_same(tmp_path: Path) -> None:
    twin = "  twin: {kind: gear, between: [motor, shaft], ratio: 0.25}\n"
    path = tmp_path / "mechanism.yaml"
    path.write_text(TRAIN.replace(", efficiency: 0.9", "").replace(RACK, RACK + twin))
    _, mechanism = load_mechanism(path)
    assert mechanism.notes == (
        "twin is left out: it closes the loop motor - reducer - shaft - twin and "
        "adds no constraint",
    )
    assert "in which reducer has a loss" in refusal(TRAIN.replace(RACK, RACK + twin), tmp_path)


def test_ways_that_do_not_fit_each_other_are_noted(tmp_path: Path) -> None:
    """45 mm between the stops of the cart; the motor starts at 0."""
    path = tmp_path / "mechanism.yaml"
    for play, travel, words in (
        (
            "46",
            "-1",
            [
                "the backlash of rack, 0.046 m at cart, is wider than the travel of cart between "
                "the stops of ends, 0.045 m"
            ],
        ),
        ("44", "1", ["travel from 1 to 100 rad does not contain the start of motor, 0 rad"]),
        ("44", "0", []),
    ):
        text = TRAIN.replace("value: 0.2, unit: mm", f"value: {play}, unit: mm")
        path.write_text(text + f"travel: {{low: {travel}, high: 100, unit: rad}}\n")
        assert list(load_mechanism(path)[1].notes) == words


def test_a_loop_with_a_solution(tmp_path: Path) -> None:
    """Lossless: left out, and told. With loss or play it is not determined how the links share the
    force."""
    exact = f"ratio: {2 / 3!r}, internal: true"
    path = tmp_path / "mechanism.yaml"
    path.write_text(TRIANGLE.format(exact))
    _, mechanism = load_mechanism(path)
    assert mechanism.joints == ("first", "second")
    assert mechanism.notes == (
        "closing is left out: it closes the loop c - second - b - first - a - closing and adds "
        "no constraint",
    )
    assert "in which closing has a loss" in refusal(
        TRIANGLE.format(exact + ", efficiency: 0.9"), tmp_path
    )
    lossy_inside = TRIANGLE.replace("ratio: 3}}", "ratio: 3, efficiency: 0.9}}").format(exact)
    assert "in which second has a loss: the forces in the loop are not determined" in refusal(
        lossy_inside, tmp_path
    )
    play = "backlash: {width: {value: 1, unit: mrad}}"
    assert "closes the loop" in (message := refusal(TRIANGLE.format(f"{exact}, {play}"), tmp_path))
    assert "closing has backlash but no compliance" in message
    # play inside the ring: the loop is that link's own
    inside = TRIANGLE.replace(
        "ratio: 0.5}}", f"ratio: 0.5, {play.replace('{', '{{').replace('}', '}}')}}}}}"
    ).format(exact)
    assert "links.first: closes the loop" in refusal(inside, tmp_path)
    soft = (
        "compliance: {stiffness: {value: 9, unit: N m/rad}, damping: {value: 1, unit: N m s/rad}}"
    )
    path.write_text(TRIANGLE.format(f"ratio: 0.5, {soft}"))  # compliant: any ratio, any play
    assert load_mechanism(path)[1].couplings == ("closing",)


@pytest.mark.parametrize(
    ("screw", "key", "words"),
    [
        (
            "lead_angle: {value: 95, unit: deg}",
            "lead_angle",
            "found 95 deg; allowed: > 0 and < 90 deg",
        ),
        (
            "lead_angle: {value: 60, unit: deg}, friction_coefficient: 0.6",
            "friction_coefficient",
            "the screw jams with this friction; allowed: < 0.5774",
        ),
        (
            "lead_angle: {value: 60, unit: deg}, friction_coefficient: 0.6, friction_form: thesis",
            "friction_coefficient",
            "the screw jams with this friction; allowed: < 0.5774",
        ),
        (
            "lead: {value: 5, unit: mm}, friction_coefficient: 0.1, friction_form: thesis, "
            "compliance: {stiffness: {value: 1, unit: N/m}, damping: {value: 0, unit: N s/m}}",
            "friction_form",
            "allowed: angle",
        ),
    ],
)
def test_a_screw_that_cannot_be(screw: str, key: str, words: str, tmp_path: Path) -> None:
    text = f"""\
format: mechanism/1
name: screw
blocks: {{screw: {{inertia: {{value: 1, unit: kg m^2}}}}, nut: {{mass: {{value: 1, unit: kg}}}}}}
links:
  thread: {{kind: screw, between: [screw, nut], radius: {{value: 1, unit: cm}}, {screw}}}
sources: {{motor: {{on: screw, drive: effort}}}}
"""
    message = refusal(text, tmp_path)
    assert f"mechanism.yaml:5: links.thread.{key}: " in message
    assert words in message


def test_what_a_controller_has_must_be_clear(tmp_path: Path) -> None:
    second = TRAIN + "  scale: {on: cart, step: {value: 0.1, unit: mm}}\n"
    path = tmp_path / "mechanism.yaml"
    path.write_text(second)
    document, mechanism = load_mechanism(path)
    with pytest.raises(ElementError) as caught:
        controlled_indices(document, mechanism)
    message = str(mechanism_error(path, caught.value))
    assert (
        "mechanism.yaml:15: sensors: found encoder, scale; write the controller's sensor under "
        "`control`" in message
    )
    path.write_text(second + "control: {source: drive, sensor: scale}\n")
    document, mechanism = load_mechanism(path)
    assert controlled_indices(document, mechanism) == (0, 1)
    assert "control.sensor: found 'scales'; allowed: encoder, scale" in refusal(
        second + "control: {source: drive, sensor: scales}\n", tmp_path
    )
    none = TRAIN[: TRAIN.index("sensors:")]
    path.write_text(none)
    document, mechanism = load_mechanism(path)
    with pytest.raises(ElementError, match="found none; allowed: at least one sensor"):
        controlled_indices(document, mechanism)


def test_a_weight_beside_a_drive_leaves_the_drive_to_the_controller(tmp_path: Path) -> None:
    path = tmp_path / "mechanism.yaml"
    path.write_text(
        TRAIN.replace(
            DRIVE, "  weight: {on: cart, drive: effort, effort: {value: -5, unit: N}}\n" + DRIVE
        )
    )
    document, mechanism = load_mechanism(path)
    assert mechanism.sources == ("weight", "drive")
    assert controlled_indices(document, mechanism) == (1, 0)
    assert mechanism.pushes == ("weight",)


def test_a_curve_that_ends_before_the_stops_is_told(tmp_path: Path) -> None:
    curve = "force: {position: {values: [0, 20], unit: mm}, value: {values: [0, 9], unit: N}}"
    path = tmp_path / "mechanism.yaml"
    path.write_text(
        TRAIN.replace(SPRING, f"  spring: {{kind: spring, between: [cart, ground], {curve}}}\n")
    )
    assert load_mechanism(path)[1].notes == (
        "spring.force is defined from 0 to 0.02, but the stops of cart are farther apart; beyond "
        "its ends the curve is constant",
    )


def test_a_curve_of_what_moves_with_a_stopped_block_too(tmp_path: Path) -> None:
    """The slave moves 0.6 of the cart's way: 24 of its 40 mm."""
    path = tmp_path / "mechanism.yaml"
    rod = (
        "  rod: {kind: hydraulic, between: [cart, slave], area_a: {value: 3, unit: cm^2}, "
        "area_b: {value: 5, unit: cm^2}}\n"
    )
    for end, notes in ((24.0, 0), (23.0, 1)):
        curve = (
            f"force: {{position: {{values: [-3, {end}], unit: mm}}, value: {{values: [0, 9], "
            f"unit: N}}}}"
        )
        text = TRAIN.replace(
            SPRING, f"{rod}  spring: {{kind: spring, between: [slave, ground], {curve}}}\n"
        )
        path.write_text(text.replace(CART, CART + CART.replace("cart", "slave")))
        assert len(load_mechanism(path)[1].notes) == notes


def test_a_compliant_stop_of_one_side_tells_where_its_other_is(tmp_path: Path) -> None:
    path = tmp_path / "mechanism.yaml"
    soft = "compliance: {stiffness: {value: 1, unit: N/mm}, damping: {value: 1, unit: N s/m}}"
    path.write_text(
        TRAIN.replace(
            STOPS, f"  ends: {{kind: stop, on: cart, high: {{value: 40, unit: mm}}, {soft}}}\n"
        )
    )
    assert load_mechanism(path)[1].notes == (
        "ends has one stop; the opposite stop is assumed 1000 m away",
    )


def test_speeds_that_lie_too_far_apart(tmp_path: Path) -> None:
    assert "blocks.shaft: by the link ratios, its speed is 1e+20 times the speed of" in refusal(
        TRAIN.replace("ratio: 0.25", "ratio: 1.0e+20"), tmp_path
    )
    soft = (
        "ratio: 1.0e+20, compliance: {stiffness: {value: 1, unit: N m/rad}, damping: {value: "
        "1, unit: N m s/rad}}"
    )
    assert "allowed: 1e-12 to 1e+12 times" in refusal(
        TRAIN.replace("ratio: 0.25, efficiency: 0.9", soft), tmp_path
    )


def test_two_links_that_what_they_drive_cannot_drive(tmp_path: Path) -> None:
    """Each may drive the load alone; both are refused, directly or behind a rigid link, and taken
    where something yields between them."""
    worm = "  {name}: {{kind: gear, between: [{a}, {b}], ratio: 0.05, efficiency: 0.4}}\n"
    second = SHAFT + SHAFT.replace("shaft", "other") + SHAFT.replace("shaft", "wheel")
    gears = worm.format(name="reducer", a="motor", b="shaft") + worm.format(
        name="worm", a="other", b="wheel"
    )
    rod = "  rod: {kind: coupling, between: [shaft, wheel]}\n"
    text = TRAIN.replace(SHAFT, second).replace(GEAR, gears + rod)
    told = refusal(text, tmp_path)
    assert (
        "links.worm: worm and reducer are self-locking and both drive shaft and wheel, rigidly "
        "linked, so that nothing can move" in told
    )
    soft = (
        "[shaft, wheel], compliance: {stiffness: {value: 1, unit: N m/rad}, damping: {value: "
        "0, unit: N m s/rad}}"
    )
    path = tmp_path / "soft.yaml"
    path.write_text(text.replace("[shaft, wheel]", soft))
    assert load_mechanism(path)[1].joints == ("reducer", "worm", "rack")
