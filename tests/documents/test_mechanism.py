"""`mechanism.yaml`: its golden text has every key of every element; the schema tells kinds apart;
what a text has wrong is refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any, get_args

import msgspec
import pytest

from frictool.adapters.mechanism.sources_and_sensors import controlled_indices
from frictool.cli.mechanism_file import load_mechanism
from frictool.documents.mechanism import Link, Mechanism
from frictool.documents.quantity import Quantity
from frictool.documents.registry import json_schema, load
from frictool.documents.writing import to_yaml
from tests.documents.edited_documents import refusal

GOLDEN = Path(__file__).parent / "golden" / "mechanism.yaml"


def test_the_golden_mechanism_is_read_and_written_byte_for_byte() -> None:
    mechanism = load(GOLDEN, Mechanism)
    assert to_yaml(mechanism) == GOLDEN.read_text()
    assert {type(link) for link in mechanism.links.values()} == set(get_args(Link))


def test_the_golden_mechanism_has_every_key() -> None:
    given: dict[type, set[str]] = {}

    def walk(value: Any) -> None:
        if isinstance(value, msgspec.Struct):
            keys = given.setdefault(type(value), set())
            defaults = {field.name: field.default for field in msgspec.structs.fields(type(value))}
            for name in value.__struct_fields__:
                item = getattr(value, name)
                if item != defaults[name]:
                    keys.add(name)
                walk(item)
        elif isinstance(value, dict):
            for item in value.values():
                walk(item)

    walk(load(GOLDEN, Mechanism))
    assert len(given) > 20
    for kind, keys in given.items():
        assert keys == set(kind.__struct_fields__), kind


def test_the_schema_tells_the_kinds_apart() -> None:
    described = json_schema("mechanism")["$defs"]
    assert described["Gear"]["properties"]["kind"] == {"enum": ["gear"]}
    assert {"radius", "lead_angle", "friction_form"} <= set(described["Screw"]["properties"])


def test_units_and_intervals_are_converted_once(tmp_path: Path) -> None:
    path = tmp_path / "mechanism.yaml"
    path.write_text(
        "format: mechanism/1\nname: one\nblocks: {cart: {mass: {value: 300, low: 280, high: 320, "
        "unit: g}}}\n"
    )
    mass = load(path, Mechanism).blocks["cart"].mass
    assert mass == Quantity(0.3, 0.28, 0.32, "kg")


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (
            "kind: gear",
            "kind: geer",
            ["links.reducer.kind: found 'geer', did you mean 'gear'?", "hydraulic"],
        ),
        ("    kind: gear\n", "", ["links.reducer.kind: missing; allowed: gear, belt"]),
        (
            "ratio: 0.25",
            "ration: 0.25",
            ["links.reducer.ration: unknown key, did you mean 'ratio'?"],
        ),
        (
            "efficiency: 0.95",
            "efficiency: 1.2",
            ["links.reducer.efficiency: found 1.2; allowed: a number > 0 and <= 1"],
        ),
        ("unit: kg m^2", "unit: kg", ["blocks.motor.inertia.unit", "allowed: kg m^2"]),
        (
            "start: {value: 0.5, unit: rad}",
            "start: {value: 0.5, unit: V}",
            ["blocks.motor.start.unit", "allowed: rad, m and their"],
        ),
        (
            "lead_angle: {value: 0.2, unit: rad}",
            "lead_angle: {value: 0.0, unit: rad}",
            ["links.thread.lead_angle.value", "allowed: > 0"],
        ),
        (
            "    lead_angle: {value: 0.2, unit: rad}\n",
            "",
            ["links.thread: give lead_angle or `lead`"],
        ),
        (
            "    friction_form: thesis",
            "    efficiency: 0.5",
            ["links.thread: give friction_coefficient or `efficiency`, not both"],
        ),
        (
            "      at: motor\n      restitution: 0.2",
            "      restitution: 1.2",
            ["links.reducer.backlash.restitution", "<= 0.95"],
        ),
        (
            "values: [0.0, 0.005, 0.013]",
            "values: [0.0, 0.013, 0.005]",
            ["links.clutch.force: position: allowed: at least 2 values, rising"],
        ),
        (
            "values: [0.0, 900.0, 1100.0]",
            "values: [0.0, 900.0]",
            ["links.clutch.force: found 3 positions and 2 values"],
        ),
        (
            "factor: [1.0, 1.2, 1.1]",
            "factor: [1.0, -1.2, 1.1]",
            ["links.brushes.level.factor[1]", ">= 0"],
        ),
        (
            "    low: {value: -0.001, unit: m}",
            "    low: {value: 0.1, unit: m}",
            ["links.ends: `low` is not below `high`"],
        ),
        (
            "    effort: {value: -4.0, unit: N}",
            "    constant: {value: 1, unit: N/A}",
            ["sources.weight: `constant` (effort per ampere or volt)"],
        ),
        (
            "measures: velocity",
            "measures: velocity, step: {value: 1, unit: rad}",
            ["sensors.tacho: counts_per_revolution and `step` belong to `measures: position`"],
        ),
    ],
)
def test_a_wrong_line_is_named(old: str, new: str, words: list[str], tmp_path: Path) -> None:
    message = str(refusal(GOLDEN, old, new, Mechanism, tmp_path))
    for word in words:
        assert word in message


def test_the_documentation_s_example_fits_together(tmp_path: Path) -> None:
    page = (Path(__file__).parents[2] / "docs" / "formats.md").read_text()
    section = page[page.index("### mechanism.yaml") : page.index("### Scenario")]
    path = tmp_path / "mechanism.yaml"
    path.write_text(section.partition("```yaml\n")[2].partition("```")[0])
    document, mechanism = load_mechanism(path)
    assert controlled_indices(document, mechanism) == (0, 0)
    assert mechanism.notes == ()
