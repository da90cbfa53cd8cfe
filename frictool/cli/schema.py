"""`frictool schema`: JSON Schema of a document, or of a command's --json output."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import click

from frictool.cli.common_options import output_option
from frictool.cli.json_formats import format_names, json_format_schema
from frictool.cli.output_files import STDOUT, save_text
from frictool.documents.mechanism import Mechanism
from frictool.documents.registry import DOCUMENTS, json_schema

HELP = f"""\b
Example:
  frictool schema bench -o bench.schema.json
  frictool schema report

Print the JSON Schema of a document, for the YAML support of an editor, or of the object that a
command prints with --json.

Documents: {", ".join(DOCUMENTS)}.

Objects: {", ".join(format_names())}.
"""


def schema_of(name: str) -> dict[str, Any]:
    """Return the JSON Schema of a document, or of a --json format.

    `name`: name of the document, or of the format without its version. The schema of a mechanism
    lists the friction laws, including laws that other packages register.
    """
    if name not in DOCUMENTS:
        return json_format_schema(format_names()[name])
    if DOCUMENTS[name] is not Mechanism:
        return json_schema(name)
    from frictool.friction.law_registry import LAWS

    return json_schema(name, {"FrictionOf.law": LAWS})


@click.command("schema", help=HELP)
@click.argument(
    "name",
    metavar="NAME",
    type=click.Choice([*DOCUMENTS, *format_names()]),
    help="Document or object whose schema is printed.",
)
@output_option(required=False, writes=("JSON",))
@click.option(
    "--json",
    is_flag=True,
    expose_value=False,
    help="No effect, because a schema is always JSON.",
)
def command(name: str, output: Path | None) -> None:
    save_text(output or STDOUT, json.dumps(schema_of(name), indent=2) + "\n", [])
