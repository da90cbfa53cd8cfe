"""`frictool export`: a controller as source code with golden vectors and a self-test."""

from __future__ import annotations

from pathlib import Path

import click

from frictool.cli.output import command_line, existing, json_option, output_option, print_json, say

HELP = """\b
Example:
  frictool export controller.yaml --lang c -o c/
  cc c/*.c -lm -o selftest && ./selftest

Write a controller as C99: NAME.h and NAME.c to run on the target, NAME_vectors.h and NAME_selftest.c to check it there.

The source allocates nothing and calls nothing but sqrt. The golden vectors come from the simulation's own controller; the self-test exits 0
when the compiled code gives every one of them bit by bit. Files of the same names in the folder are replaced, others are left alone.
With -o - the files are written to stdout as a tar archive.
"""


@click.command("export", help=HELP)
@click.argument("controller", type=existing)
@click.option("--lang", type=click.Choice(["c"]), default="c", show_default=True, help="Programming language.")
@click.option("-n", "--number", type=click.Choice(["double"]), default="double", show_default=True, help="Number format.")
@output_option(help="The folder to write into; - is a tar archive on stdout.")
@json_option
def command(controller: Path, lang: str, number: str, output: Path, as_json: bool) -> None:
    from frictool.cli.folder import save_folder
    from frictool.documents.controller import Controller
    from frictool.documents.provenance import digest
    from frictool.documents.registry import load

    document = load(controller, Controller)
    from frictool.export.c99 import c_sources
    from frictool.export.vectors import golden_vectors
    from frictool.verify.controller import recheck

    recheck(document)
    vectors = golden_vectors(document)
    sha256 = digest(controller)
    words = command_line("export", {"controller": controller, "--lang": lang, "--number": number})
    files = c_sources(document, vectors, sha256, words)
    save_folder(output, files, [controller], overwrite=True)
    if as_json:
        counts = {"run": vectors.run, "brake": vectors.brake, "rest": vectors.rest, "limited": vectors.limited}
        print_json(
            {
                "files": list(files),
                "language": lang,
                "number": number,
                "order": len(document.linear.discrete.a),
                "sample_period_s": document.sample_period_s,
                "sha256": sha256,
                "vectors": {"samples": vectors.samples, **counts},
            },
            output,
        )
        return
    say(f"{', '.join(files)}: C99, {number}", output)
    say(
        f"golden vectors: {vectors.samples} samples, {vectors.run} in RUN, {vectors.brake} in BRAKE, {vectors.rest} in REST, "
        f"{vectors.limited} with the drive limited",
        output,
    )
