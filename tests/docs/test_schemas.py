"""docs/schemas holds what `frictool schema` prints, of every document and of every object of
--json; `make schemas` writes them anew."""

from __future__ import annotations

import json
from collections.abc import Iterator

import click
import pytest

from frictool.cli.json_formats import format_names, json_formats, json_type
from frictool.cli.main import group
from frictool.cli.schema import schema_of
from frictool.documents.metric_table import HOLD_METRICS, STREAM_METRICS
from frictool.documents.registry import DOCUMENTS
from tests.support.documentation_pages import ROOT, text_of

FOLDER = ROOT / "docs" / "schemas"
NAMES = (*DOCUMENTS, *format_names())


@pytest.mark.parametrize("name", NAMES)
def test_the_schema_is_the_program_s(name: str) -> None:
    printed = json.dumps(schema_of(name), indent=2) + "\n"
    assert (FOLDER / f"{name}.schema.json").read_text() == printed, (
        "the documents or the formats have changed: make schemas"
    )


def test_no_other_schema_is_there_and_each_is_linked() -> None:
    files = {path.name for path in FOLDER.iterdir()}
    assert files == {f"{name}.schema.json" for name in NAMES}
    assert all(f"(schemas/{file})" in text_of(ROOT / "docs/formats.md") for file in files)


def commands(
    within: click.Group, above: tuple[str, ...] = ()
) -> Iterator[tuple[str, click.Command]]:
    """Yield the name of each command, "observe-run" for a command of a group, and the command."""
    with click.Context(within) as context:
        for name in within.list_commands(context):
            found = within.get_command(context, name)
            assert found is not None
            if isinstance(found, click.Group):
                yield from commands(found, (*above, name))
            else:
                yield "-".join((*above, name)), found


def test_every_command_with_json_has_a_format() -> None:
    found = {
        name
        for name, command in commands(group)
        if any(one.name == "as_json" for one in command.params)
    }
    assert found <= set(format_names())
    assert {name for name in format_names() if not any(map(name.startswith, found))} == {
        "observe-fleet"  # `observe run` of several logs
    }


def test_the_type_refuses_other_keys_and_the_schema_does_not() -> None:
    for form in json_formats():
        assert json_type(form).__struct_config__.forbid_unknown_fields
        assert 'additionalProperties": false' not in json.dumps(schema_of(form.partition("/")[0]))


def test_a_metric_is_no_required_key_so_that_older_reports_stay_valid() -> None:
    kinds = schema_of("report")["$defs"]
    for kind, metrics in (("Streams", STREAM_METRICS), ("StreamsHolds", HOLD_METRICS)):
        one = kinds[f"Report{kind}"]
        assert set(metrics) <= set(one["properties"])
        assert not set(metrics) & set(one["required"])
