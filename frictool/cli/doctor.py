"""`frictool doctor`: state of the installation, and removal of obsolete files."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from frictool.cli.common_options import json_option, output_option
from frictool.cli.console_output import print_json, say
from frictool.cli.output_files import save_text

if TYPE_CHECKING:
    from frictool.doctor.installation_finding import InstallationFinding

HELP = """\b
Example:
  frictool doctor

Report the state of this installation: versions, folder of the compiled kernels, solver, C compiler,
machine. The command compiles and runs a kernel, solves a matrix inequality and checks the answer,
and compiles and runs a C program.

`ok`: in order. `note`: works with a restriction, such as a log format whose library is not
installed. `wrong`: does not work. A line that is not `ok` shows a command to try; so does a line
about disk space that can be freed. For a bug report: frictool doctor -o doctor.txt.

--clean removes the compiled kernels of former versions, except those used within the last hour. The
kernels of this version are kept. An upgrade also removes kernels, but keeps the kernels of up to
eight versions that were used within a fortnight. --clean also removes unfinished outputs
(.NAME.xxxxxxxx.part) of killed processes from the current folder; so does the next command that
writes to this folder.

--compile compiles all kernels now instead of at their first use, for container images and build
servers. It takes some minutes and skips kernels that are compiled already. Keep or share the folder
of the kernels; the variable NUMBA_CACHE_DIR names it.

Exit code 1 if something is wrong.
"""


@click.command("doctor", help=HELP)
@click.option(
    "--clean",
    is_flag=True,
    help="Remove compiled kernels of former versions, and unfinished outputs.",
)
@click.option(
    "--compile", "compile_now", is_flag=True, help="Compile all kernels now, and keep them."
)
@output_option(
    required=False,
    help="Also write the text to this file; - is stdout.",
    writes=("text", "Markdown"),
)
@json_option
@click.pass_context
def command(
    ctx: click.Context, clean: bool, compile_now: bool, output: Path | None, as_json: bool
) -> None:
    from frictool import __version__
    from frictool.doctor.examination import examine, json_view, lines

    facts: dict[str, Any] = {
        "frictool": __version__,
        "installed_in": str(Path(__file__).parents[1]),
    }
    text = [f"frictool {__version__} in {facts['installed_in']}"]
    if clean:
        words, facts["clean"] = _cleaned()
        text += words
    is_failed = False
    if compile_now:
        words, facts["compile"] = _compiled()
        text += words
        is_failed = bool(facts["compile"]["failures"])
    checks = examine()
    text += [*lines(checks), _verdict(checks)]
    if output is not None:
        save_text(output, "\n".join(text) + "\n", [])
    if as_json:
        print_json(
            "doctor/1",
            {**facts, "is_in_order": not _wrong(checks), "checks": json_view(checks)},
            output,
        )
    elif output != Path("-"):
        say("\n".join(text), output)
    if _wrong(checks) or is_failed:
        ctx.exit(1)


def _wrong(checks: list[InstallationFinding]) -> list[InstallationFinding]:
    return [one for one in checks if one.state == "wrong"]


def _verdict(checks: list[InstallationFinding]) -> str:
    wrong = _wrong(checks)
    if wrong:
        return f"wrong: {', '.join(one.name for one in wrong)}"
    notes = [one.name for one in checks if one.state == "note"]
    return f"in order{'; with restrictions: ' + ', '.join(notes) if notes else ''}"


def _compiled() -> tuple[list[str], dict[str, Any]]:
    from frictool.cli.progress import progress

    try:
        from frictool.doctor.precompilation import compile_all
        from frictool.runtime import kernels
    except ImportError as error:  # the checks report what is broken
        return [f"compiled: no kernels ({error})"], {
            "kernels": 0,
            "compiled": 0,
            "failures": [str(error)],
        }
    if kernels.FOLDER is None:
        reason = "no folder for compiled kernels can be written; set NUMBA_CACHE_DIR"
        return [f"compiled: no kernels ({reason})"], {
            "kernels": 0,
            "compiled": 0,
            "failures": [reason],
        }
    with progress("compiling") as report:
        done = compile_all(report)
    lines = [
        f"compiled: {done.compiled} functions; {kernels.FOLDER} now contains "
        f"{done.prepared} kernels (functions in machine code)"
    ]
    lines += [f"not compiled: {failure}" for failure in done.failures]
    return lines, {"kernels": done.prepared, "compiled": done.compiled, "failures": done.failures}


def _cleaned() -> tuple[list[str], dict[str, Any]]:
    from frictool.runtime.part_files import remove_stale_parts

    parts = [str(path) for path in remove_stale_parts(Path.cwd())]
    lines = [
        f"removed: {len(parts)} unfinished output{'' if len(parts) == 1 else 's'} in this folder"
    ]
    try:
        from frictool.doctor.compiled_kernels import remove_old_kernels
    except ImportError as error:  # the checks report what is broken
        return [*lines, f"removed: no kernels ({error})"], {"removed": parts, "left": []}
    gone, left = remove_old_kernels()
    lines.append(
        f"removed: the kernels of {len(gone)} former version{'' if len(gone) == 1 else 's'}"
    )
    lines += [
        f"not removed: {one.folder.path} ({one.kept_by or 'cannot be removed'})" for one in left
    ]
    return lines, {
        "removed": [*parts, *(str(path) for path in gone)],
        "left": [str(one.folder.path) for one in left],
    }
