"""Strict reading: each complaint names the file, the line, the key, what was found and what is
allowed."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import msgspec
import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from frictool.documents.bench import Bench
from frictool.documents.registry import DOCUMENTS, json_schema, load, same_axis
from frictool.documents.spec import Spec
from frictool.documents.writing import to_yaml
from frictool.errors import DocumentError, InputFileError

ROOT = Path(__file__).parents[2]
CLUTCH = ROOT / "configs/clutch/bench.yaml"
EVERY = sorted(
    (kind, path)
    for rig in (ROOT / "configs").iterdir()
    for kind, pattern in (
        ("bench", "bench.yaml"),
        ("model", "nonlinear.yaml"),
        ("spec", "spec.yaml"),
        ("design", "designs/*.yaml"),
        ("scenario", "scenarios/*.yaml"),
    )
    for path in rig.glob(pattern)
)


def _line_of(text: str, part: str) -> int:
    return next(number for number, line in enumerate(text.splitlines(), start=1) if part in line)


@pytest.mark.parametrize(
    ("kind", "path"), EVERY, ids=lambda item: str(item).rpartition("configs/")[2]
)
def test_shipped_documents_load_and_round_trip(kind: str, path: Path, tmp_path: Path) -> None:
    document = load(path, DOCUMENTS[kind])
    copy = tmp_path / "copy.yaml"
    copy.write_text(to_yaml(document))
    assert load(copy, DOCUMENTS[kind]) == document
    assert to_yaml(load(copy, DOCUMENTS[kind])) == to_yaml(document)


@pytest.mark.parametrize(
    ("old", "new", "key", "words"),
    [
        (
            "value: 50, unit: A",
            "value: 50, unit: V",
            "actuator.limit.unit",
            ["'V'", "current", "allowed: A"],
        ),
        (
            "value: 50, unit: A",
            "value: 50, unit: amps_",
            "actuator.limit.unit",
            ["unknown unit", "A"],
        ),
        (
            "  inertia:",
            "  inertai:",
            "mechanics.inertai",
            ["unknown key", "did you mean 'inertia'?"],
        ),
        (
            "drive: current",
            "drive: curent",
            "actuator.drive",
            ["'curent'", "current | voltage", "did you mean 'current'?"],
        ),
        ("  limit: {value: 50, unit: A}\n", "", "actuator.limit", ["missing", "required"]),
        ("0.003", "-1", "actuator.loop_time_constant_s", ["-1", ">= 0"]),
        (
            "counts_per_revolution: 56",
            "counts_per_revolution: many",
            "encoder.counts_per_revolution",
            ["'many'", "a number > 0"],
        ),
        (
            "low: 0, high: 7.62e-4",
            "low: 5, high: 7.62e-4",
            "mechanics.viscous.low",
            ["5", "3.81e-4", "low <= value <= high"],
        ),
        ("value: 1.32e-5", "value: 0", "mechanics.inertia.value", ["found 0", "> 0"]),
        ("value: 1.32e-5", "value: .nan", "mechanics.inertia.value", [".nan", "finite"]),
        ("value: 1.32e-5", "value: 1e999", "mechanics.inertia.value", ["1e999", "finite"]),
        ("name: clutch", "name: clutch\nname: again", "name", ["twice"]),
        ("delay_samples: 1", "delay_samples: 1.5", "delay_samples", ["1.5", "a whole number"]),
        (
            "delay_samples: 1",
            "delay_samples: 3",
            "delay_samples",
            ["found 3", "a whole number >= 0 and <= 2"],
        ),
        (
            "0.003",
            "1e300",
            "actuator.loop_time_constant_s",
            ["found 1e300", "a number >= 0 and <= 10"],
        ),
        (
            "0.003",
            "10.1",
            "actuator.loop_time_constant_s",
            ["found 10.1", "a number >= 0 and <= 10"],
        ),
        (
            "sample_period_s: 0.001",
            "sample_period_s: 1000",
            "sample_period_s",
            ["found 1000", "a number >= 1e-06 and <= 10"],
        ),
        (
            "sample_period_s: 0.001",
            "sample_period_s: 1e-9",
            "sample_period_s",
            ["found 1e-9", "a number >= 1e-06 and <= 10"],
        ),
        (
            "name: clutch",
            "name: " + "x" * 300,
            "name",
            ["found 'xxx", "...'; allowed: text of at least 1 character and at most 80 characters"],
        ),
        ("name: clutch", "name: ''", "name", ["found ''; allowed: text of at least 1 character"]),
        (
            "encoder:\n  counts_per_revolution: 56 ",
            "encoder: [56] ",
            "encoder",
            ["a list", "mapping"],
        ),
        (
            "{value: 50, unit: A}",
            "10",
            "actuator.limit",
            ["found 10", "write {value: 10, unit: A}"],
        ),
        (
            "{value: 50, unit: A}",
            "1200 mA",
            "actuator.limit",
            ["found '1200 mA'", "write {value: 1200, unit: mA}"],
        ),
        (
            "{value: 50, unit: A}",
            "12 V",
            "actuator.limit",
            ["found '12 V'", "write {value: 12, unit: A}"],
        ),
        (
            "{value: 50, unit: A}",
            "{value: 50}",
            "actuator.limit.unit",
            ["missing", "{value: 50, unit: A}"],
        ),
        (
            "{value: 50, unit: A}",
            "{unit: A}",
            "actuator.limit.value",
            ["missing", "{value: .., unit: A}"],
        ),
    ],
)
def test_a_wrong_line_is_named(
    old: str, new: str, key: str, words: list[str], tmp_path: Path
) -> None:
    text = CLUTCH.read_text()
    assert old in text
    path = tmp_path / "bench.yaml"
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(DocumentError) as caught:
        load(path, Bench)
    message = str(caught.value)
    assert caught.value.exit_code == 3
    assert caught.value.key == key
    assert message.startswith(f"{path}:{caught.value.line}: {key}")
    assert all(word in message for word in words), message
    assert "\n" not in message
    if new and "\n" not in new:
        assert caught.value.line == _line_of(path.read_text(), new.strip())


def _quantities(node: yaml.Node) -> Iterator[yaml.MappingNode]:
    """Every quantity, span and series of a document."""
    if isinstance(node, yaml.SequenceNode):
        for item in node.value:
            yield from _quantities(item)
    elif isinstance(node, yaml.MappingNode):
        if "unit" in (keys := {name.value for name, _ in node.value}) and keys & {
            "value",
            "values",
            "low",
        }:
            yield node
        for _, value in node.value:
            yield from _quantities(value)


@pytest.mark.parametrize(
    ("kind", "path"), [*EVERY, ("mechanism", ROOT / "configs/clutch/mechanism.yaml")], ids=str
)
def test_a_bare_number_in_place_of_any_quantity_shows_the_form_that_is_read(
    kind: str, path: Path, tmp_path: Path
) -> None:
    """The unit of the form measures the quantity: with `value` (or `low` and `high`) and that unit,
    the document is read again."""
    text, bare = path.read_text(), tmp_path / path.name
    for node in _quantities(yaml.compose(text)):
        start, end = node.start_mark.index, node.end_mark.index
        keys = {name.value for name, _ in node.value}
        bare.write_text(text[:start] + "1" + ("\n" if text[end - 1] == "\n" else "") + text[end:])
        with pytest.raises(
            DocumentError, match=r"found 1; allowed: a mapping with a unit; write \{.*unit: .*\}$"
        ) as caught:
            load(bare, DOCUMENTS[kind])
        form = str(caught.value).rpartition("write ")[2]
        if (
            kind == "mechanism" and "unit: .." in form
        ):  # a coefficient whose unit follows from its link
            continue
        shown = yaml.safe_load(form)
        assert set(shown) <= keys
        written = {name.value: value.value for name, value in node.value} | {"unit": shown["unit"]}
        inside = ", ".join(
            f"{name}: {value}" for name, value in written.items() if isinstance(value, str)
        )
        bare.write_text(
            text[:start] + "{" + inside + "}" + ("\n" if text[end - 1] == "\n" else "") + text[end:]
        )
        if all(isinstance(value, str) for value in written.values()):
            load(bare, DOCUMENTS[kind])


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"   \n",
        b"\x00\xff\xfe\x01",
        b"a: [1, 2",
        b"- 1\n- 2\n",
        b"just text",
        b"a: &a [*a]\n",
        b"{" * 5000,
    ],
)
def test_what_is_no_document_is_one_line(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "bench.yaml"
    path.write_bytes(content)
    with pytest.raises(InputFileError) as caught:
        load(path, Bench)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_document_of_another_kind_is_refused_for_its_format() -> None:
    with pytest.raises(
        DocumentError, match=r"bench.yaml:\d+: format: found 'bench/1'; allowed: model/1"
    ):
        load(CLUTCH, DOCUMENTS["model"])


def test_missing_file_and_directory(tmp_path: Path) -> None:
    with pytest.raises(InputFileError, match="no such file"):
        load(tmp_path / "none.yaml", Bench)
    with pytest.raises(InputFileError, match="directory"):
        load(tmp_path, Bench)


def test_units_are_converted_once(tmp_path: Path) -> None:
    path = tmp_path / "bench.yaml"
    path.write_text(
        CLUTCH.read_text().replace(
            "{value: 400, unit: rad/s}", "{value: 3819.718634205488, unit: rpm}"
        )
    )
    top_speed = load(path, Bench).mechanics.top_speed
    assert top_speed is not None
    assert top_speed.value == pytest.approx(400.0, rel=1e-12)
    assert top_speed.unit == "rad/s"


def test_a_linear_axis_wants_linear_units(tmp_path: Path) -> None:
    path = tmp_path / "bench.yaml"
    path.write_text(CLUTCH.read_text().replace("axis: rotary", "axis: linear"))
    with pytest.raises(DocumentError, match="linear axis"):
        load(path, Bench)


def test_the_order_of_the_keys_of_a_specification_does_not_matter(tmp_path: Path) -> None:
    """`rest.drive` is a number; the units of the keys after it are those of the drive above."""
    head = "format: spec/1\nname: a\naxis: rotary\ndrive: voltage\n"
    keys = ["rest: {after_s: 15, drive: 2}\n", "drive_peak: {value: 5000, unit: mV}\n"]
    one, other = tmp_path / "one.yaml", tmp_path / "other.yaml"
    one.write_text("".join([head, *keys]))
    other.write_text("".join([head, *reversed(keys)]))
    assert load(one, Spec) == load(other, Spec)
    assert load(one, Spec).drive_peak.value == 5.0


def test_documents_of_two_kinds_of_axis_do_not_mix() -> None:
    clutch, emps = ROOT / "configs/clutch", ROOT / "configs/emps"
    documents = {
        path: load(path, DOCUMENTS["spec"]) for path in (clutch / "spec.yaml", emps / "spec.yaml")
    }
    with pytest.raises(InputFileError, match="axis: found linear"):
        same_axis(documents)


def _refusal(path: Path) -> str | None:
    """Return the reader's message about the document, or None if it accepts it. Any other exception
    is a failure."""
    try:
        load(path, Bench)
    except InputFileError as error:
        return str(error)
    return None


@given(data=st.data())
def test_a_mutated_document_loads_or_is_refused_in_one_line(
    data: st.DataObject, tmp_path_factory: pytest.TempPathFactory
) -> None:
    text = CLUTCH.read_bytes()
    start = data.draw(st.integers(0, len(text) - 1))
    length = data.draw(st.integers(0, 12))
    path = tmp_path_factory.mktemp("fuzz") / "bench.yaml"
    path.write_bytes(text[:start] + data.draw(st.binary(max_size=12)) + text[start + length :])
    message = _refusal(path)
    assert message is None or "\n" not in message


@given(value=st.floats(1e-12, 1e12), text=st.text(min_size=1, max_size=20).filter(str.strip))
def test_numbers_and_names_survive_writing(
    value: float, text: str, tmp_path_factory: pytest.TempPathFactory
) -> None:
    bench = load(CLUTCH, Bench)
    encoder = msgspec.structs.replace(bench.encoder, counts_per_revolution=value)
    changed = msgspec.structs.replace(bench, encoder=encoder, name=text)
    path = tmp_path_factory.mktemp("write") / "bench.yaml"
    path.write_text(to_yaml(changed), encoding="utf-8")
    again = load(path, Bench)
    assert again.encoder.counts_per_revolution == value
    assert again.name == text


@pytest.mark.parametrize("name", list(DOCUMENTS))
def test_every_document_has_a_schema_that_names_its_keys(name: str) -> None:
    schema = json_schema(name)
    keys = {field.encode_name for field in msgspec.structs.fields(DOCUMENTS[name])}
    definition = schema["$defs"][schema["$ref"].rpartition("/")[2]]
    assert set(definition["properties"]) == keys
    assert definition["additionalProperties"] is False


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("name: x\nlaw: coulomb\n", ("x.yaml:1: format: missing; write format: bench/1;",)),
        ("format: bench/1\nname: x\n", ("x.yaml:1: axis: missing; write axis: rotary | linear;",)),
        (
            "format: bench/1\nname: x\n---\nname: y\n",
            ("x.yaml:3: not valid YAML: found a second document, after ---",),
        ),
        (
            "format: bench/1\n\tname: x\n",
            ("x.yaml:2: not valid YAML: found a tab; indent with spaces",),
        ),
    ],
)
def test_what_a_document_lacks_or_has_too_much_is_told_before_its_keys(
    tmp_path: Path, text: str, words: tuple[str, ...]
) -> None:
    path = tmp_path / "x.yaml"
    path.write_text(text)
    with pytest.raises(InputFileError) as caught:
        load(path, Bench)
    assert all(word in str(caught.value) for word in words)


def test_no_hint_where_one_value_alone_is_allowed(tmp_path: Path) -> None:
    path = tmp_path / "x.yaml"
    path.write_text("format: design/1\n")
    with pytest.raises(DocumentError, match=r"found 'design/1'; allowed: bench/1$"):
        load(path, Bench)


def test_numbers_of_numpy_are_written_as_numbers() -> None:
    bench = load(CLUTCH, Bench)
    period = bench.sample_period_s
    quantity = msgspec.structs.replace(bench.mechanics.inertia, value=np.float64(1e-3))
    mechanics = msgspec.structs.replace(bench.mechanics, inertia=quantity)
    changed = msgspec.structs.replace(
        bench, sample_period_s=np.float64(period), delay_samples=np.int64(1), mechanics=mechanics
    )
    tree = yaml.safe_load(to_yaml(changed))
    assert tree["sample_period_s"] == period
    assert tree["delay_samples"] == 1
    assert tree["mechanics"]["inertia"]["value"] == 1e-3
    with pytest.raises(TypeError, match="of type object"):
        to_yaml(msgspec.structs.replace(bench, name=object()))
