"""Files of the test signals of `frictool excite`, and their summary as text and JSON."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from frictool.cli.console_output import note
from frictool.cli.output_files import STDOUT, replacing, save_text

if TYPE_CHECKING:
    from frictool.documents.bench import Bench
    from frictool.identify.excite.excitation_sequence import ExcitationSequence

# names, or beginnings of names, of the numbers in a test's summary, grouped by their unit
PARAMETER_FIGURES = ("promised_", "least_deviation_")
SPEED_FIGURES = ("speed_", "top_speed")
DRIVE_FIGURES = {"rate": "/s", "step": "", "top": ""}
FIGURES = {
    "amplitude": "position",
    "advance_on": "position",
    "turn_low": "position",
    "turn_high": "position",
    "top_acceleration": "acceleration",
}


def bench_of(path: Path) -> Bench:
    """Load the bench at `path`; warn if the bench has a load but its key `load.most` is missing."""
    from frictool.documents.bench import Bench
    from frictool.documents.registry import load
    from frictool.identify.excite.bench_limits import missing_load_limit

    document = load(path, Bench)
    no_limit = missing_load_limit(document)
    if no_limit is not None:
        note(f"warning: {no_limit}")
    return document


def note_returning_ramps(sequence: ExcitationSequence, bench: Bench) -> None:
    """Warn if a load may move the axis back between the ramps of a test."""
    from frictool.identify.excite.breakaway_ramps import returning_ramps

    warning = returning_ramps(bench) if sequence.kind == "breakaway" else None
    if warning is not None:
        note(f"warning: {warning}")


def save_plot(sequence: ExcitationSequence, plot: Path, bench: Path) -> None:
    """Write a figure of the test signals as SVG."""
    from frictool.identify.excite.picture import picture

    save_text(plot, picture(sequence) + "\n", [bench])


def save_test(sequence: ExcitationSequence, output: Path, words: str, inputs: list[Path]) -> None:
    """Write test signals as CSV or MCAP, according to the ending of `output`.

    A test longer than LONGEST is announced first.

    - words: text of the command, for the provenance
    """
    from frictool.documents.provenance import provenance_of_command
    from frictool.identify.excite.excitation_sequence import LONGEST
    from frictool.logs.provenance import with_provenance

    if sequence.duration > LONGEST:
        note(f"writing a test of {sequence.duration:.4g} s, {sequence.samples} rows")
    log = with_provenance(sequence.as_log(output.name), provenance_of_command(words, inputs))
    with replacing(output, inputs) as stream:
        if output.suffix.lower() == ".mcap":
            from frictool.logs.canonical.mcap_format import write_mcap

            write_mcap(log, stream)
        else:
            from frictool.logs.conversion import convert
            from frictool.logs.formats import WRITTEN

            convert(output.name, [sequence.outgoing()], {}, WRITTEN["csv"], stream)


def summary(sequence: ExcitationSequence) -> dict[str, Any]:
    """Return a summary of the test signals as JSON values."""
    return {
        "kind": sequence.kind,
        "duration_s": sequence.duration,
        "samples": sequence.samples,
        "columns": sequence.units,
        "rule": sequence.rule,
        "figures": sequence.figures,
    }


def text(sequence: ExcitationSequence, output: Path, bench: Bench) -> str:
    """Return a summary of the test signals as text."""
    where = "stdout" if output == STDOUT else output.name
    lines = [
        f"{where}: {sequence.kind}, {sequence.duration:.4g} s, {sequence.samples} "
        f"samples, {', '.join(sequence.columns)}"
    ]
    lines += [
        f"  {name.removesuffix('_hz').replace('_', ' '):<28}{value:.5g} "
        f"{unit_of_figure(name, bench)}".rstrip()
        for name, value in sequence.figures.items()
    ]
    return "\n".join([*lines, f"to play it: {sequence.rule}"])


def unit_of_figure(name: str, bench: Bench) -> str:
    """Return the SI unit of the number `name` in the summary; "" if it has no unit."""
    from frictool.documents.quantity import drive_dimension, si_unit
    from frictool.identify.model_document import unit_of

    for prefix in PARAMETER_FIGURES:
        if name.startswith(prefix):
            return unit_of(name.removeprefix(prefix), bench)
    drive = si_unit(drive_dimension(bench.actuator.drive, constant=False), bench.axis)
    if name.endswith("_hz"):
        return "Hz"
    if name in DRIVE_FIGURES:
        return drive + DRIVE_FIGURES[name]
    if name.startswith(SPEED_FIGURES):
        return si_unit("velocity", bench.axis)
    return si_unit(FIGURES[name], bench.axis) if name in FIGURES else ""
