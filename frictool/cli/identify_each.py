"""`frictool identify --each`: one model for each log or folder, and a table of all models."""

from __future__ import annotations

import io
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from frictool.cli.console_output import note, print_json, say
from frictool.cli.file_endings import TABLES, says_file
from frictool.cli.output_files import (
    STDOUT,
    check_output,
    command_line,
    refuse_inputs,
    replacing,
    require_folder,
    save_text,
)
from frictool.cli.progress import progress
from frictool.errors import EXIT_DONE, EXIT_INPUT, EXIT_NO, EXIT_NO_SOLUTION, OutputError

if TYPE_CHECKING:
    from frictool.documents.bench import Bench
    from frictool.identify.batch import BatchResult, LogGroup
    from frictool.identify.methods import IdentificationRequest
    from frictool.logs.origin import NamePatterns

TABLE = "parameters.csv"  # in the folder of the models


@dataclass(frozen=True)
class IdentifyEachCommand:
    """Arguments and options of `frictool identify --each`, and the loaded bench.

    `shown`: name and value of the options that affect a model, for the provenance.
    """

    each: str
    bench: Path
    document: Bench
    request: IdentificationRequest
    patterns: NamePatterns
    shown: dict[str, Any]
    output: Path | None
    as_json: bool
    cores: int | None
    cluster: str | None

    @property
    def folder(self) -> Path | None:
        """Return the folder for the models; None if only the table is written."""
        is_table = (
            self.output is None or self.output == STDOUT or self.output.suffix.lower() in TABLES
        )
        return None if is_table else self.output

    @property
    def table(self) -> Path | None:
        """Return the file for the table, by default stdout; None if only JSON is printed."""
        if self.folder is not None:
            return self.folder / TABLE
        return self.output if self.output is not None or self.as_json else STDOUT


def identify_each(line: IdentifyEachCommand, logs: Sequence[Path]) -> int:
    """Identify a model from each log or folder, and return the exit code.

    The exit code is the first of 4, 1, 3 and 0 that a log has (`frictool.errors`).
    """
    from frictool.cli.standard_input import STDIN
    from frictool.documents.provenance import Input, digest
    from frictool.documents.writing import to_yaml
    from frictool.identify.batch import IdentifyJob, groups, identify_groups
    from frictool.identify.batch_table import ordered
    from frictool.logs.formats import format_for, require
    from frictool.logs.origin import unmatched_patterns

    if STDIN in logs:
        raise click.UsageError("--each reads files and folders, not standard input.")
    if line.folder is not None and says_file(line.folder):
        message = (
            f"-o {line.folder.name}: with --each, name a folder for models and table; for the "
            "table alone, name a file that ends in"
        )
        raise click.UsageError(f"{message} {', '.join(TABLES)}.")
    if line.table is not None and line.table != STDOUT:
        require(format_for(line.table), line.table)
    fleet = _members(line, logs)
    for unmatched in unmatched_patterns(line.patterns, [member.name for member in fleet]):
        note(f"warning: {unmatched}")
    shown = {"logs": (), "--bench": line.bench, **line.shown}
    jobs = [
        replace(
            one,
            words=command_line(
                "identify", {**shown, "logs": [member.path for member in one.members]}
            ),
        )
        for one in groups(fleet, line.each)
    ]
    inputs = [line.bench, *(member.path for member in fleet if member.path.is_file())]
    _check_outputs(line, jobs, inputs)
    bench_input = Input(line.bench.name, digest(line.bench))
    work = IdentifyJob(to_yaml(line.document), bench_input, line.request, line.patterns)
    batch: dict[int, BatchResult] = {}
    with progress("identify") as tick:
        for index, one in identify_groups(
            work, jobs, cores=line.cores, cluster=line.cluster, tick=tick
        ):
            batch[index] = one
            _save_model(
                line, one, inputs
            )  # saved immediately, so that an interrupt loses no completed model
    _show(line, ordered([batch[index] for index in range(len(jobs))]), inputs)
    codes = {one.code for one in batch.values()}
    return next(
        (code for code in (EXIT_NO_SOLUTION, EXIT_NO, EXIT_INPUT) if code in codes), EXIT_DONE
    )


def _members(line: IdentifyEachCommand, logs: Sequence[Path]) -> list[Any]:
    """Return the logs, without files that an earlier call wrote into the output folder."""
    from frictool.logs.fleet import members

    fleet = members(logs)
    if line.folder is None or any(line.folder.resolve() == log.resolve() for log in logs):
        return fleet
    return [one for one in fleet if line.folder.resolve() not in one.path.resolve().parents]


def _check_outputs(line: IdentifyEachCommand, jobs: Sequence[LogGroup], inputs: list[Path]) -> None:
    if line.folder is None:
        if line.table is not None:
            check_output(line.table, inputs)
        return
    if line.folder.exists() and not line.folder.is_dir():
        raise OutputError(
            f"{line.folder}: is a file; name a folder for the models, or a table whose "
            f"name ends in {', '.join(TABLES)}"
        )
    for target in (line.folder / TABLE, *(line.folder / f"{one.name}.yaml" for one in jobs)):
        refuse_inputs(target, inputs)
    require_folder(line.folder)
    try:
        line.folder.mkdir(exist_ok=True)
    except OSError as error:
        raise OutputError(f"{line.folder}: cannot be written: {error.strerror or error}") from None


def _save_model(line: IdentifyEachCommand, one: BatchResult, inputs: list[Path]) -> None:
    from frictool.identify.batch_table import model_file

    name = model_file(one)
    if line.folder is not None and one.model is not None and name is not None:
        target = line.folder / name
        target.parent.mkdir(parents=True, exist_ok=True)  # below the requested folder
        save_text(target, one.model.text, inputs)


def _show(line: IdentifyEachCommand, batch: list[BatchResult], inputs: list[Path]) -> None:
    from frictool.identify.batch_table import (
        as_csv,
        as_json,
        batch_populations,
        headline,
        population_lines,
        reasons,
    )

    populations = batch_populations(batch, line.request.settings.confidence)
    if line.table is not None and line.table.suffix.lower() in TABLES[1:]:
        _save_parquet(line, line.table, batch, inputs)
    elif line.table is not None:
        save_text(line.table, as_csv(batch), inputs)
    if line.as_json:
        print_json(
            "identify-each/1",
            as_json(batch, populations, line.document),
            line.table if line.table == STDOUT else None,
        )
    tell: Callable[[str], None] = note if line.as_json or line.table == STDOUT else say
    for text in [
        *reasons(batch),
        *([] if line.as_json else [headline(batch), *population_lines(populations, line.document)]),
    ]:
        tell(text)


def _save_parquet(
    line: IdentifyEachCommand, target: Path, batch: list[BatchResult], inputs: list[Path]
) -> None:
    from frictool.documents.provenance import provenance_of_command
    from frictool.identify.batch_table import write_parquet
    from frictool.logs.provenance import provenance_record

    words = command_line("identify", {"--each": line.each, "--bench": line.bench, **line.shown})
    made = io.BytesIO()
    write_parquet(
        batch, line.document, made, provenance_record(provenance_of_command(words, inputs))
    )
    with replacing(target, inputs) as stream:
        stream.write(made.getvalue())
