"""`frictool equations`: symbolic equations of motion of a mechanism."""

from __future__ import annotations

from pathlib import Path

import click

from frictool.cli.common_options import existing, json_option, output_option
from frictool.cli.console_output import print_json
from frictool.cli.output_files import STDOUT, save_text

HELP = """\b
Example:
  frictool equations mechanism.yaml

Print the equations of a mechanism, derived from its description.

The report contains the constraint and the loss of each link, the effort of each element, the free
body of every block, and one equation for each group of blocks that move together, without the
forces of rigid links. It also states when backlash is in contact and when blocks rest. Every term
is named after its element and has its unit; the dimensions of all sums are checked.
"""


@click.command("equations", help=HELP)
@click.argument("mechanism", type=existing, help="Mechanism (mechanism.yaml).")
@click.option("--latex", is_flag=True, help="Print a LaTeX fragment (amsmath) instead of text.")
@click.option("--explain", is_flag=True, help="Add the numbers of the equations in the thesis.")
@output_option(required=False, writes=("text", "Markdown", "LaTeX"))
@json_option
def command(
    mechanism: Path, latex: bool, explain: bool, output: Path | None, as_json: bool
) -> None:
    from frictool.documents.mechanism import Mechanism
    from frictool.documents.registry import load
    from frictool.equations import equations

    derived = equations(load(mechanism, Mechanism), name=str(mechanism), explain=explain)
    if output is not None or not as_json:
        save_text(output or STDOUT, derived.latex if latex else derived.text, [mechanism])
    if as_json:
        print_json("equations/1", derived.data, output)
