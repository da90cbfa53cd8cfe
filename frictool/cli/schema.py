"""`frictool schema`: JSON Schema of a document."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import click

from frictool.cli.output import STDOUT, output_option, save_text
from frictool.documents.mechanism import Mechanism
from frictool.documents.registry import DOCUMENTS, json_schema

HELP = (
    """\b
Example:
  frictool schema bench -o bench.schema.json

Print the JSON Schema of a document, for the YAML support of an editor. NAME is one of
"""
    + f"{', '.join(DOCUMENTS)}."
)


def schema_of(name: str) -> dict[str, Any]:
    """Return the JSON Schema of a document, with the names that other packages register."""
    if DOCUMENTS[name] is not Mechanism:
        return json_schema(name)
    from frictool.friction.law_registry import LAWS

    return json_schema(name, {"FrictionOf.law": LAWS})


@click.command("schema", help=HELP)
@click.argument(
    "name",
    metavar="NAME",
    type=click.Choice(list(DOCUMENTS)),
    help="Document whose schema is printed.",
)
@output_option(required=False, writes=("JSON",))
@click.option(
    "--json",
    is_flag=True,
    expose_value=False,
    help="Accepted as in every command; a schema is JSON anyway.",
)
def command(name: str, output: Path | None) -> None:
    text = json.dumps(schema_of(name), indent=2) + "\n"
    save_text(output or STDOUT, text, [])
