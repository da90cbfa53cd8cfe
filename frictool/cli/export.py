"""`frictool export`: a controller as source code with golden vectors and a self-test."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import click

from frictool.cli.common_options import existing, json_option, output_option
from frictool.cli.console_output import note, note_changes, print_json, say
from frictool.cli.file_endings import check_folder
from frictool.cli.output_files import STDOUT, command_line

if TYPE_CHECKING:
    from frictool.documents.controller import Number
    from frictool.export.controller_export import Language

HELP = """\b
Example:
  frictool export controller.yaml --lang c --number float -o c/
  cc c/*.c -lm -o selftest && ./selftest
  frictool export controller.yaml --lang matlab -o simulink/

Write a controller for its target, or for another tool.

\b
  c       C99: NAME.h and NAME.c for the target; NAME_vectors.h and NAME_selftest.c to check it
  json    NAME.json: every coefficient as the number format stores it, with its conventions
  cmsis   NAME_cmsis.h: the linear controller as biquads for CMSIS-DSP, in float, q31 or q15
  matlab  NAME.mat: a, b, c, d, sos, Ts and the blocks' parameters, for MATLAB and Simulink

The C code allocates nothing and calls no function but sqrt. Its golden vectors come from the
simulation's controller in the same number format; the self-test exits with 0 if the compiled code
reproduces all of them bit by bit. q31 and q15 are fixed point, proved free of overflow.

The loop is verified again with the coefficients as the number format stores them. Exit code 4 if it
violates the modulus margin. Files of the same names in the folder are replaced. With -o - the files
are a tar archive on stdout.
"""


@click.command("export", help=HELP)
@click.argument("controller", type=existing, help="Controller to export (controller.yaml).")
@click.option(
    "--lang",
    type=click.Choice(["c", "json", "cmsis", "matlab"]),
    default="c",
    show_default=True,
    help="Kind of the files.",
)
@click.option(
    "--number",
    type=click.Choice(["double", "float", "q31", "q15"]),
    help="Number format. [default: double; of cmsis float]",
)
@output_option(help="Folder for the files; - is a tar archive on stdout.")
@json_option
def command(
    controller: Path, lang: Language, number: Number | None, output: Path, as_json: bool
) -> None:
    check_folder(output)
    from frictool.cli.output_folder import save_folder
    from frictool.documents.controller import Controller
    from frictool.documents.provenance import digest
    from frictool.documents.registry import load

    document = load(controller, Controller)
    from frictool.export.controller_export import default_number, export
    from frictool.export.export_origin import ExportOrigin

    number = number or default_number(lang)
    if (lang, number) == ("cmsis", "double"):
        raise click.UsageError("--lang cmsis has no --number double; allowed: float, q31, q15.")
    words = command_line("export", {"controller": controller, "--lang": lang, "--number": number})
    result = export(document, lang, number, ExportOrigin(digest(controller), words))
    save_folder(output, result.files, [controller], overwrite=True)
    note_changes(controller, document)
    if lang == "c" and output != STDOUT:
        _warn_of_others(output, result.files)
    if as_json:
        print_json("export/1", result.summary(), output)
    else:
        for line in result.lines():
            say(line, output)


def _warn_of_others(folder: Path, files: Mapping[str, str | bytes]) -> None:
    """Warn of other self-tests in the folder.

    Each has a main, so that `cc DIR/*.c` does not link.
    """
    others = sorted(path.name for path in folder.glob("*_selftest.c") if path.name not in files)
    if others:
        note(
            f"warning: {folder} also contains {', '.join(others)}, and each has a main "
            "function; write every controller to its own folder"
        )
