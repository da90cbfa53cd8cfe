"""`frictool compare`: the four tests of thesis 3.7 on every friction law."""

from __future__ import annotations

import difflib
import os
from pathlib import Path
from typing import TYPE_CHECKING

import click

from frictool.cli.common_options import existing, json_option, output_option
from frictool.cli.console_output import note, print_json, say
from frictool.cli.file_endings import check_folder, is_page
from frictool.cli.output_files import (
    STDOUT,
    check_output,
    command_line,
    refuse_inputs,
    require_folder,
    save_text,
)
from frictool.cli.progress import note_compiling, show_count
from frictool.errors import OutputError

if TYPE_CHECKING:
    from frictool.compare.comparison import Comparison
    from frictool.compare.comparison_setting import ComparisonSetting

WORTH_SHARING = 4
HELP = """\b
Example:
  frictool compare -o laws.html
  frictool compare configs/mass/friction.yaml --law lugre --law hybrid_a --json

Run four tests on every friction law and judge each result: stick-slip, limit cycle, presliding and
drift.

PARAMETERS is a friction.yaml, or the model.yaml of an actuator. Parameters that a model lacks are
scaled from the built-in set, and so are the tests. Parameters that violate a stability condition of
the hybrid laws are an error; with --allow, the tests run nevertheless.

-o NAME.html (or -, stdout) writes one page. Any other name is a folder for the page and the figures
as JSON.
"""


class LawOption(click.Option):
    """Option whose help lists the friction laws; they are imported only when the help is shown."""

    def get_help_record(self, ctx: click.Context) -> tuple[str, str] | None:
        from frictool.friction.law_registry import LAWS

        record = super().get_help_record(ctx)
        return record and (record[0], f"{record[1]} NAME is one of {', '.join(LAWS)}.")


@click.command("compare", help=HELP)
@click.argument(
    "parameters",
    type=existing,
    required=False,
    help="Parameters (friction.yaml) or an actuator's model (model.yaml). Default: built-in set.",
)
@click.option(
    "--law",
    "laws",
    multiple=True,
    metavar="NAME",
    cls=LawOption,
    help="Run this law only; repeatable.",
)
@click.option(
    "--allow",
    is_flag=True,
    help=("Only warn of parameters that violate a stability condition of the hybrid laws."),
)
@click.option(
    "--explain", is_flag=True, help="List the results that differ from the tables of the thesis."
)
@output_option(required=False, help="Page (.html or -), or folder for the page and the figures.")
@json_option
def command(
    parameters: Path | None,
    laws: tuple[str, ...],
    allow: bool,
    explain: bool,
    output: Path | None,
    as_json: bool,
) -> None:
    inputs = [parameters] if parameters is not None else []
    if output is not None and output != STDOUT:
        if _is_page(output):
            check_output(output, inputs)
        else:
            check_folder(output, ", or a page (.html)")
            require_folder(output)
            refuse_inputs(output, inputs)
        if output.is_file() and not _is_page(output):
            raise OutputError(f"{output}: is a file; name an HTML page (.html) or a folder")
    setting = _setting(parameters)
    from frictool.compare.comparison import compare
    from frictool.compare.law_simulator import LawSimulator

    chosen = _chosen(laws, LawSimulator(setting).names())
    chosen = _supporting(setting, chosen, bool(laws), parameters)
    _check(setting, chosen, parameters, allow)
    comparison = compare(
        setting, LawSimulator(setting), chosen, _progress, workers=_workers(chosen)
    )
    if output is not None:
        arguments = {
            "parameters": parameters,
            "--law": list(chosen) if laws else None,
            "--allow": allow,
            "--explain": explain,
        }
        _save(comparison, output, command_line("compare", arguments), inputs, explain)
    _show(comparison, output, as_json, explain)


def _is_page(output: Path) -> bool:
    return output == STDOUT or is_page(output)


def _setting(path: Path | None) -> ComparisonSetting:
    from yaml import MappingNode

    from frictool.compare.actuator_setting import from_model
    from frictool.compare.comparison_setting import from_friction, table_3_1
    from frictool.documents.document_text import compose, read_text
    from frictool.documents.friction import Friction
    from frictool.documents.model import Model
    from frictool.documents.registry import load
    from frictool.errors import InputFileError

    if path is None:
        return table_3_1()
    root = compose(read_text(path), path)
    keys = (
        {key.value: value.value for key, value in root.value}
        if isinstance(root, MappingNode)
        else {}
    )
    kind = str(keys.get("format", "friction/1")).split("/")[0]
    if kind not in ("model", "friction"):
        raise InputFileError(path, f"format: found {keys['format']}; allowed: friction/1, model/1")
    try:
        return (
            from_model(load(path, Model))
            if kind == "model"
            else from_friction(load(path, Friction))
        )
    except ValueError as error:
        raise InputFileError(path, str(error)) from None


def _chosen(laws: tuple[str, ...], known: tuple[str, ...]) -> tuple[str, ...]:
    for law in laws:
        if law not in known:
            near = difflib.get_close_matches(law, known, 1)
            hint = f" Did you mean {near[0]!r}?" if near else ""
            raise click.UsageError(f"No such law: {law!r}.{hint} Known: {', '.join(known)}.")
    return tuple(law for law in known if not laws or law in laws)


def _supporting(
    setting: ComparisonSetting, laws: tuple[str, ...], requested: bool, path: Path | None
) -> tuple[str, ...]:
    """Return the laws that support the extensions in the friction document (backward, dwell, ...).

    A law without this support is left out with a warning. If --law names such a law (`requested`),
    InputFileError is raised instead.
    """
    from frictool.compare.comparison import REFERENCE
    from frictool.compare.law_simulator import LawSimulator
    from frictool.errors import InputFileError

    if setting.extension.plain:
        return laws
    refused = LawSimulator(setting).refusals((REFERENCE, *laws))
    for law, reason in refused.items():
        if requested or law == REFERENCE:
            raise InputFileError(
                path or setting.name, f"{reason}; change the key, or choose other laws by --law"
            )
        note(f"warning: {law} is left out: {reason}")
    return tuple(law for law in laws if law not in refused)


def _check(
    setting: ComparisonSetting, laws: tuple[str, ...], path: Path | None, allow: bool
) -> None:
    """Raise InputFileError if a parameter is outside a law's range or violates a condition.

    The conditions are the inequalities of friction/hybrid_time_step.py. If `allow` is True
    (--allow), a violated condition is only a warning. For each parameter whose default is used, a
    note is printed.
    """
    from frictool.compare.law_simulator import LawSimulator, setting_violations
    from frictool.errors import InputFileError

    where = path or setting.name
    try:
        LawSimulator(setting).check(laws)
        broken, advice = setting_violations(setting, laws)
    except ValueError as error:
        raise InputFileError(where, str(error)) from None
    for line in LawSimulator(setting).defaults(laws):
        note(f"note: {line}, its default")
    message = "; ".join([*broken, *advice])
    if not message:
        return
    if allow or not broken:
        note(f"warning: {message}")
        return
    raise InputFileError(where, f"{message}; change the parameters, or accept this with --allow")


def _progress(done: int, total: int) -> None:
    from frictool.engine.stick_slip import run
    from frictool.runtime.kernels import is_compiled

    if done == 0 and not is_compiled(run):
        note_compiling(everywhere=True)
    show_count("compared", done, total)


def _workers(laws: tuple[str, ...]) -> int:
    return (os.cpu_count() or 1) if len(laws) > WORTH_SHARING else 1


def _save(
    comparison: Comparison, output: Path, words: str, inputs: list[Path], explain: bool
) -> None:
    from frictool.cli.output_folder import save_folder
    from frictool.compare.json_view import as_json
    from frictool.compare.page import page
    from frictool.documents.provenance import provenance_of_command
    from frictool.presentation.json_text import json_text

    html = page(comparison, provenance_of_command(words, inputs), explain)
    if _is_page(output):
        save_text(output, html, inputs)
        return
    figures = json_text("compare/1", as_json(comparison)) + "\n"
    save_folder(output, {"index.html": html, "compare.json": figures}, inputs, overwrite=True)


def _show(comparison: Comparison, output: Path | None, as_json: bool, explain: bool) -> None:
    if as_json:
        from frictool.compare.json_view import as_json as machine_view

        print_json("compare/1", machine_view(comparison), output)
        return
    from frictool.compare.text_view import lines

    for line in lines(comparison, explain):
        say(line, output)
