"""`frictool identify --each`: a model for each log or folder, and one table."""

from __future__ import annotations

import io
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from frictool.cli.file_endings import TABLES, says_file
from frictool.cli.output import (
    STDOUT,
    check_output,
    command_line,
    note,
    print_json,
    refuse_inputs,
    replacing,
    require_folder,
    save_text,
    say,
)
from frictool.cli.progress import progress
from frictool.errors import EXIT_DONE, EXIT_INPUT, EXIT_NO, EXIT_NO_SOLUTION, OutputError

if TYPE_CHECKING:
    from frictool.documents.bench import Bench
    from frictool.identify.batch import BatchResult, LogGroup
    from frictool.identify.methods import IdentificationSettings
    from frictool.logs.origin import NamePatterns

TABLE = "parameters.csv"  # in the folder of the models


@dataclass(frozen=True)
class IdentifyEachRequest:
    """Command line with its bench loaded.

    `shown`: option -> value of the options that affect one model.
    """

    each: str
    bench: Path
    document: Bench
    method: str
    settings: IdentificationSettings
    measure: bool
    patterns: NamePatterns
    shown: dict[str, Any]
    output: Path | None
    as_json: bool
    cores: int | None
    cluster: str | None

    @property
    def folder(self) -> Path | None:
        """Return the folder of the models; None if only the table is requested."""
        is_table = (
            self.output is None or self.output == STDOUT or self.output.suffix.lower() in TABLES
        )
        return None if is_table else self.output

    @property
    def table(self) -> Path | None:
        """Return the file of the table; None if stdout carries JSON."""
        if self.folder is not None:
            return self.folder / TABLE
        return self.output if self.output is not None or self.as_json else STDOUT


def identify_each(asked: IdentifyEachRequest, logs: Sequence[Path]) -> int:
    """Identify each log or folder and return the exit code.

    It is the first of 4, 1 and 3 (`frictool.errors`) that occurred, else 0.
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
    if asked.folder is not None and says_file(asked.folder):
        message = (
            f"-o {asked.folder.name}: with --each the models go into a folder, and the "
            "table alone into a file that ends in"
        )
        raise click.UsageError(f"{message} {', '.join(TABLES)}.")
    if asked.table is not None and asked.table != STDOUT:
        require(format_for(asked.table), asked.table)
    found = _members(asked, logs)
    for told in unmatched_patterns(asked.patterns, [member.name for member in found]):
        note(f"warning: {told}")
    shown = {"logs": (), "--bench": asked.bench, **asked.shown}
    jobs = [
        replace(
            one,
            words=command_line(
                "identify", {**shown, "logs": [member.path for member in one.members]}
            ),
        )
        for one in groups(found, asked.each)
    ]
    inputs = [asked.bench, *(member.path for member in found if member.path.is_file())]
    _check_outputs(asked, jobs, inputs)
    bench_input = Input(asked.bench.name, digest(asked.bench))
    work = IdentifyJob(
        to_yaml(asked.document),
        bench_input,
        asked.method,
        asked.settings,
        asked.measure,
        asked.patterns,
    )
    batch: dict[int, BatchResult] = {}
    with progress("identify") as tick:
        for place, one in identify_groups(
            work, jobs, cores=asked.cores, cluster=asked.cluster, tick=tick
        ):
            batch[place] = one
            _save_model(
                asked, one, inputs
            )  # saved immediately, so that an interrupt loses no completed model
    _tell(asked, ordered([batch[place] for place in range(len(jobs))]), inputs)
    codes = {one.code for one in batch.values()}
    return next(
        (code for code in (EXIT_NO_SOLUTION, EXIT_NO, EXIT_INPUT) if code in codes), EXIT_DONE
    )


def _members(asked: IdentifyEachRequest, logs: Sequence[Path]) -> list[Any]:
    """Return the logs, without files that an earlier run wrote into the output folder."""
    from frictool.logs.fleet import members

    found = members(logs)
    if asked.folder is None or any(asked.folder.resolve() == log.resolve() for log in logs):
        return found
    return [one for one in found if asked.folder.resolve() not in one.path.resolve().parents]


def _check_outputs(
    asked: IdentifyEachRequest, jobs: Sequence[LogGroup], inputs: list[Path]
) -> None:
    """Raise OutputError before the first log is read."""
    if asked.folder is None:
        if asked.table is not None:
            check_output(asked.table, inputs)
        return
    if asked.folder.exists() and not asked.folder.is_dir():
        raise OutputError(
            f"{asked.folder}: is a file; name a folder for the models, or a table that "
            f"ends in {', '.join(TABLES)}"
        )
    for target in (asked.folder / TABLE, *(asked.folder / f"{one.name}.yaml" for one in jobs)):
        refuse_inputs(target, inputs)
    require_folder(asked.folder)
    try:
        asked.folder.mkdir(exist_ok=True)
    except OSError as error:
        raise OutputError(f"{asked.folder}: cannot be written: {error.strerror or error}") from None


def _save_model(asked: IdentifyEachRequest, one: BatchResult, inputs: list[Path]) -> None:
    from frictool.identify.batch_table import model_file

    name = model_file(one)
    if asked.folder is not None and one.found is not None and name is not None:
        target = asked.folder / name
        target.parent.mkdir(parents=True, exist_ok=True)  # below the requested folder
        save_text(target, one.found.text, inputs)


def _tell(asked: IdentifyEachRequest, batch: list[BatchResult], inputs: list[Path]) -> None:
    """Write the table and the conclusions on all logs."""
    from frictool.identify.batch_table import (
        as_csv,
        as_json,
        batch_populations,
        headline,
        population_lines,
        reasons,
    )

    found = batch_populations(batch, asked.settings.confidence)
    if asked.table is not None and asked.table.suffix.lower() in TABLES[1:]:
        _save_parquet(asked, asked.table, batch, inputs)
    elif asked.table is not None:
        save_text(asked.table, as_csv(batch), inputs)
    if asked.as_json:
        print_json(
            as_json(batch, found, asked.document), asked.table if asked.table == STDOUT else None
        )
    tell: Callable[[str], None] = note if asked.as_json or asked.table == STDOUT else say
    for line in [
        *reasons(batch),
        *([] if asked.as_json else [headline(batch), *population_lines(found, asked.document)]),
    ]:
        tell(line)


def _save_parquet(
    asked: IdentifyEachRequest, target: Path, batch: list[BatchResult], inputs: list[Path]
) -> None:
    from frictool.documents.provenance import provenance_of_command
    from frictool.identify.batch_table import write_parquet
    from frictool.logs.provenance import provenance_record

    words = command_line("identify", {"--each": asked.each, "--bench": asked.bench, **asked.shown})
    made = io.BytesIO()
    write_parquet(
        batch, asked.document, made, provenance_record(provenance_of_command(words, inputs))
    )
    with replacing(target, inputs) as stream:
        stream.write(made.getvalue())
