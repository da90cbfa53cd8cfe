"""`frictool observe run` on several logs: one row each, verdicts and trend."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from frictool.cli.file_endings import is_page
from frictool.cli.observe_request import ObserveRequest, commissioning_of
from frictool.cli.output import STDOUT, check_targets, note, print_json, replacing, save_text, say
from frictool.cli.progress import progress
from frictool.errors import EXIT_DONE, EXIT_INPUT, EXIT_NO

if TYPE_CHECKING:
    from frictool.documents.provenance import Provenance
    from frictool.observe.fleet_table import FleetRow


def observe_fleet(given: ObserveRequest, logs: Sequence[Path]) -> int:
    """Observe all logs and return the exit code.

    It is EXIT_NO if the limit is exceeded or undecided, else EXIT_INPUT if a log was lost in part
    or whole, else EXIT_DONE.
    """
    from frictool.cli.standard_input import stdin_as_file
    from frictool.documents.provenance import provenance_of_command
    from frictool.logs.fleet import members
    from frictool.logs.formats import format_for, require
    from frictool.logs.origin import unmatched_patterns
    from frictool.observe.fleet import observe_logs
    from frictool.observe.fleet_table import counts, rows

    if given.output is not None and given.output != STDOUT:
        require(format_for(given.output), given.output)
    reference = commissioning_of(given)
    with stdin_as_file(logs) as paths:
        fleet = members(paths)
        inputs = [*given.inputs, *(member.path for member in fleet if member.path.is_file())]
        check_targets({"-o": given.output, "--plot": given.plot}, inputs)
        for told in unmatched_patterns(given.settings.patterns, [member.name for member in fleet]):
            note(f"warning: {told}")
        with progress("observe") as tick:
            found = observe_logs(
                fleet,
                given.document,
                given.settings,
                cores=given.cores,
                cluster=given.cluster,
                tick=tick,
            )
        provenance = provenance_of_command(given.words, inputs)
    table = rows(found, given.wear_limit, reference)
    _save(given, table, inputs, provenance)
    if given.as_json:
        print_json(
            "observe-fleet/1",
            {
                "logs": [row.as_json() for row in table],
                "wear_limit": given.wear_limit,
                **counts(table),
            },
            given.stdout,
        )
    else:
        _tell(table, given)
    if any(row.verdict is not None and given.answer_is_no(row.verdict.exceeded) for row in table):
        return EXIT_NO
    return EXIT_INPUT if any(one.lost for one in found) else EXIT_DONE


def _tell(table: list[FleetRow], given: ObserveRequest) -> None:
    """Print a headline; if the table is in a file, also print the rows that need attention."""
    from frictool.observe.fleet_table import headline, text_table

    odd = [row for row in table if row.alarm or row.outcome is None]
    if given.output is None or given.stdout is not None:
        note(headline(table, given.wear_limit))
        return
    say(headline(table, given.wear_limit))
    if odd:
        say("\n".join(text_table(odd).lines()))


def _save(
    given: ObserveRequest, table: list[FleetRow], inputs: list[Path], provenance: Provenance
) -> None:
    """Write the table, to stdout if nothing else is written there, and the trend."""
    from frictool.logs.formats import WRITTEN, format_for
    from frictool.logs.provenance import provenance_record
    from frictool.observe.fleet_table import as_csv, write_parquet
    from frictool.observe.page import page_of_fleet
    from frictool.observe.wear_trend import trend

    if given.output is not None and format_for(given.output) is WRITTEN["parquet"]:
        made = io.BytesIO()
        write_parquet(table, made, provenance_record(provenance))
        with replacing(given.output, inputs) as stream:
            stream.write(made.getvalue())
    elif given.output is not None or not given.as_json:
        save_text(given.output or STDOUT, as_csv(table), inputs)
    if given.plot is not None:
        drawn = trend(table, given.wear_limit)
        save_text(
            given.plot,
            page_of_fleet(table, given.wear_limit, drawn, provenance)
            if is_page(given.plot)
            else drawn + "\n",
            inputs,
        )
