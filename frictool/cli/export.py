"""`frictool export`: a controller as source code with golden vectors and a self-test."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from frictool.cli.output import command_line, existing, json_option, output_option, print_json, say

if TYPE_CHECKING:
    from frictool.documents.controller import Number

HELP = """\b
Example:
  frictool export controller.yaml --lang c --number float -o c/
  cc c/*.c -lm -o selftest && ./selftest

Write a controller as C99: NAME.h and NAME.c to run on the target, NAME_vectors.h and NAME_selftest.c to check it there.

The source allocates nothing and calls nothing but sqrt. The golden vectors come from the simulation's own controller in the same number
format; the self-test exits 0 when the compiled code gives every one of them bit by bit. The loop is verified again with the coefficients
as the format keeps them: exit 4 where that breaks the margin. Files of the same names in the folder are replaced, others are left alone.
With -o - the files are written to stdout as a tar archive.
"""


@click.command("export", help=HELP)
@click.argument("controller", type=existing)
@click.option("--lang", type=click.Choice(["c"]), default="c", show_default=True, help="Programming language.")
@click.option(
    "-n", "--number", type=click.Choice(["double", "float", "q31", "q15"]), default="double", show_default=True, help="Number format."
)
@output_option(help="The folder to write into; - is a tar archive on stdout.")
@json_option
def command(controller: Path, lang: str, number: Number, output: Path, as_json: bool) -> None:
    from frictool.cli.folder import save_folder
    from frictool.documents.controller import Controller
    from frictool.documents.provenance import digest
    from frictool.documents.registry import load

    document = load(controller, Controller)
    from frictool.export.exported import exported
    from frictool.export.origin import Origin

    words = command_line("export", {"controller": controller, "--lang": lang, "--number": number})
    found = exported(document, lang, number, Origin(digest(controller), words))
    save_folder(output, found.files, [controller], overwrite=True)
    if as_json:
        print_json(found.summary(), output)
    else:
        for line in found.told():
            say(line, output)
