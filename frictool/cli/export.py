"""`frictool export`: a controller as source code, and a model for simulators and drives."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, cast

import click

from frictool.cli.common_options import existing, json_option, output_option
from frictool.cli.console_output import note, note_changes, note_temperature, print_json, say
from frictool.cli.file_endings import check_folder
from frictool.cli.output_files import STDOUT, command_line, replacing
from frictool.errors import EXIT_NO, OutputError
from frictool.export.languages import LANGUAGE_NAMES, LANGUAGES, DocumentKind, ExportLanguage

if TYPE_CHECKING:
    from frictool.documents.controller import Number
    from frictool.export.controller_export import Language


def _rows(document: DocumentKind) -> str:
    return "\n".join(f"  {one.name:<7} {one.text}" for one in LANGUAGES if one.document == document)


HELP = f"""\b
Example:
  frictool export controller.yaml --lang c --number float -o c/
  cc c/*.c -lm -o selftest && ./selftest
  frictool export model.yaml --lang urdf --into robot.urdf --joint elbow --in-place

Write a controller for its target, or a model for a simulator or a drive.

\b
From controller.yaml:
{_rows("controller")}

\b
From model.yaml:
{_rows("model")}

The C code allocates nothing and calls no function but sqrt. Golden vectors are inputs and outputs
of the simulated controller in the same number format; the self-test exits with 0 if the compiled
code reproduces all outputs bit by bit. q31 is fixed point, proved free of overflow. q15 applies to
coefficients only (json, cmsis, matlab).

The loop is verified again with the coefficients as the number format stores them. Exit code 4 if
this loop violates the modulus margin, if the code exceeds the budget of the bench's target, or if
the exported format cannot represent a part of the model; --without omits that part. Files of the
same names in the folder are replaced. With -o - the files are a tar archive on stdout.
"""


@click.command("export", help=HELP)
@click.argument(
    "document", type=existing, help="Document to export (controller.yaml or model.yaml)."
)
@click.option(
    "--lang",
    type=click.Choice(LANGUAGE_NAMES),
    default="c",
    show_default=True,
    help="Kind of the files.",
)
@click.option(
    "--number",
    type=click.Choice(["double", "float", "q31", "q15"]),
    help="Number format of a controller. [default: double; with cmsis float]",
)
@click.option(
    "--into", type=existing, help="Robot description (URDF, xacro, SDF) whose joint is changed."
)
@click.option("--joint", help="Joint of --into. [default: the only joint of the model's kind]")
@click.option(
    "--in-place",
    is_flag=True,
    help="Change the file of --into itself, in place of a copy in the folder of --output.",
)
@click.option(
    "--without",
    multiple=True,
    metavar="FEATURE",
    help="Omit a feature of the model that the exported format cannot represent; repeatable.",
)
@click.option(
    "--check",
    type=existing,
    metavar="LOG",
    help="Play the effort of this log in MuJoCo and in frictool, and compare the motions.",
)
@click.option(
    "--report",
    is_flag=True,
    help="Print instructions per step, bytes of code and of state on the bench's target.",
)
@output_option(
    required=False, help="Folder for the files, required without --in-place; - is a tar archive."
)
@json_option
@click.pass_context
def command(
    context: click.Context,
    document: Path,
    lang: str,
    number: Number | None,
    into: Path | None,
    joint: str | None,
    in_place: bool,
    without: tuple[str, ...],
    check: Path | None,
    report: bool,
    output: Path | None,
    as_json: bool,
) -> None:
    if in_place and output is not None:
        raise click.UsageError("--in-place and --output exclude each other; give one of them.")
    if output is not None:
        check_folder(output)
    elif not in_place:
        raise click.UsageError("Missing option '-o' / '--output', the folder for the files.")
    language = _language(lang, document)
    for option in ("number", "into", "joint", "in_place", "without", "check", "report"):
        if context.params[option] not in (None, (), False) and option not in language.options:
            others = ", ".join(_label(one) for one in LANGUAGES if option in one.options)
            name = option.replace("_", "-")
            raise click.UsageError(
                f"--{name} does not work with --lang {_label(language)}; allowed: --lang {others}."
            )
    if language.document == "controller":
        assert output is not None  # no language of a controller reads --in-place
        _export_controller(document, cast("Language", lang), number, report, output, as_json)
        return
    if "into" in language.options and into is None:
        raise click.UsageError(f"--lang {lang} needs --into FILE, the robot description.")
    if output is not None and into is not None:
        _refuse_same(output, into)
    from frictool.cli.output_folder import save_folder
    from frictool.documents.model import Model
    from frictool.documents.provenance import digest
    from frictool.documents.registry import load
    from frictool.export.export_origin import ExportOrigin
    from frictool.export.model_export import ModelExportSettings, export_model
    from frictool.export.model_features import FEATURES
    from frictool.logs.channels.bench_match import match_bench
    from frictool.logs.log_reader import read_log

    unknown = [name for name in without if name not in FEATURES]
    if unknown:
        raise click.UsageError(f"--without: found {unknown[0]}; allowed: {', '.join(FEATURES)}.")
    model = load(document, Model)
    note_temperature(document, model)
    words = command_line(
        "export",
        {
            "model": document,
            "--lang": lang,
            "--into": into,
            "--joint": joint,
            "--in-place": in_place,
            "--without": without,
            "--check": check,
        },
    )
    log = None
    if check is not None:
        log = match_bench(read_log(check, model.bench), model.bench)
        for warning in log.warnings:
            note(f"warning: {check.name}: {warning}")
    settings = ModelExportSettings(frozenset(without), into, joint, log)
    result = export_model(model, lang, settings, ExportOrigin(digest(document), words))
    inputs = [document, *(path for path in (into, check) if path is not None)]
    if output is None:
        assert into is not None  # as --in-place requires it
        _change(into, result.files[into.name], [document])
    else:
        save_folder(output, result.files, inputs, overwrite=True)
    if as_json:
        print_json("export-model/1", result.summary(), output)
    else:
        for line in result.lines():
            say(line, output)


def _refuse_same(output: Path, into: Path) -> None:
    for target in (output, output / into.name):
        if into.exists() and target.exists() and target.samefile(into):
            raise OutputError(
                f"{target}: --output would overwrite the file given with --into; choose another "
                "folder, or use --in-place instead of --output to change the file itself"
            )


def _change(path: Path, content: str | bytes, inputs: list[Path]) -> None:
    assert isinstance(content, bytes)
    mode = path.stat().st_mode
    with replacing(path, inputs) as stream:
        stream.write(content)
    path.chmod(mode)


def _language(lang: str, document: Path) -> ExportLanguage:
    from frictool.documents.document_text import is_format

    *first, last = (one for one in LANGUAGES if one.name == lang)
    return next((one for one in first if is_format(document, one.document)), last)


def _label(language: ExportLanguage) -> str:
    several = [one.name for one in LANGUAGES].count(language.name) > 1
    return f"{language.name} (from a {language.document})" if several else language.name


def _export_controller(
    controller: Path,
    lang: Language,
    number: Number | None,
    report: bool,
    output: Path,
    as_json: bool,
) -> None:
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
    result = export(document, lang, number, ExportOrigin(digest(controller), words), report)
    save_folder(output, result.files, [controller], overwrite=True)
    note_changes(controller, document)
    if result.warning:
        note(f"warning: {controller}: {result.warning}")
    if lang == "c" and output != STDOUT:
        _warn_of_others(output, result.files)
    if as_json:
        print_json("export/1", result.summary(), output)
    else:
        for line in result.lines():
            say(line, output)
    if result.is_budget_unchecked:
        assert result.target is not None
        note(
            f"warning: {result.target.missing} is not on the PATH, so that the budget in the key "
            "`target` of the bench is not checked; install this program"
        )
        click.get_current_context().exit(EXIT_NO)


def _warn_of_others(folder: Path, files: Mapping[str, str | bytes]) -> None:
    """Warn of other self-tests in the folder: a program cannot contain two main functions."""
    others = sorted(path.name for path in folder.glob("*_selftest.c") if path.name not in files)
    if others:
        note(
            f"warning: {folder} also contains {', '.join(others)}, and each has a main "
            "function; write every controller to its own folder"
        )
