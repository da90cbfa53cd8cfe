"""`frictool excite`: test signals for the bench."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from frictool.cli.common_options import FiniteRange, NamedPath, existing, json_option, output_option
from frictool.cli.console_output import note, print_json, say
from frictool.cli.output_files import STDOUT, check_targets, command_line, replacing, save_text

if TYPE_CHECKING:
    from frictool.identify.excite.excitation_sequence import ExcitationSequence

# kind -> (purpose, settings)
KINDS: dict[str, tuple[str, tuple[str, ...]]] = {
    "sine": (
        "inertia, viscous, Coulomb: best conditioned",
        ("amplitude", "frequency", "speed", "duration", "repetitions"),
    ),
    "sines": (
        "viscous, Coulomb and regimes: sines at several speeds",
        ("amplitude", "speeds", "duration", "seed"),
    ),
    "breakaway": (
        "breakaway: ramps in both directions over the travel",
        ("amplitude", "rate", "repetitions", "open_loop"),
    ),
    "steps": ("validation: moves over the travel with rests", ("amplitude", "repetitions")),
    "multisine": (
        "inertia, viscous: low crest factor of the speed",
        ("amplitude", "frequency", "harmonics", "repetitions"),
    ),
}
HELP = f"""\b
Example:
  frictool excite --bench bench.yaml --kind sines -o sines.csv --plot sines.svg

Write a test to play on the bench, as CSV or MCAP with one row per sample: the reference, or for
`breakaway` the command of the drive.

\b
Kinds, with the parameters that each can identify:
{chr(10).join(f"  {name:<10} {what}" for name, (what, _) in KINDS.items())}

Absent options are chosen so that the worst axis of the bench (heaviest, most friction, weakest
actuator) can follow. A reference is checked against travel, speed and drive; ramps are simulated on
the lightest, the nominal and the heaviest axis. Numbers are in SI.

Exit code 4 if the test exceeds a limit; the message names it.
"""
positive = FiniteRange(0.0, min_open=True)


@click.command("excite", help=HELP)
@click.option("--bench", type=existing, required=True, help="Rig (bench.yaml).")
@click.option("--kind", type=click.Choice(list(KINDS)), required=True, help="Kind of the test.")
@click.option(
    "--amplitude",
    type=positive,
    help=("Half of the peak-to-peak distance [rad | m]; of breakaway: top of the ramps [A | V]."),
)
@click.option(
    "--frequency",
    type=positive,
    help="Frequency of a sine, or of the first harmonic of a multisine [Hz].",
)
@click.option("--speed", type=positive, help="Top speed of a sine [rad/s | m/s].")
@click.option("--rate", type=positive, help="Slope of the breakaway ramps [A/s | V/s].")
@click.option(
    "--duration",
    type=positive,
    help="Approximate duration of sine or sines [s].  [default: 10, 30]",
)
@click.option(
    "--repetitions",
    type=click.IntRange(1, 100_000),
    help=("Number of periods of a sine or multisine, or of rounds of steps or ramps."),
)
@click.option(
    "--speeds", type=click.IntRange(2, 100), help="Number of speeds of sines.  [default: 6]"
)
@click.option(
    "--harmonics",
    type=click.IntRange(2, 500),
    help="Number of harmonics of a multisine.  [default: 10]",
)
@click.option(
    "--seed", type=click.IntRange(0), help="Seed of the turning points of sines.  [default: 0]"
)
@click.option(
    "--open-loop",
    is_flag=True,
    default=None,
    help="Ramps of breakaway whose rows do not depend on the motion of the axis.",
)
@click.option("--plot", type=NamedPath(writes=("SVG",)), help="Write a picture of the test (SVG).")
@output_option(
    help="Test (.csv or .mcap); - is CSV on stdout.", writes=("CSV", "MCAP"), chooses=True
)
@json_option
def command(
    bench: Path, kind: str, plot: Path | None, output: Path, as_json: bool, **options: Any
) -> None:
    _check_options(kind, options)
    check_targets({"-o": output, "--plot": plot}, [bench])
    from frictool.documents.bench import Bench
    from frictool.documents.registry import load
    from frictool.identify.excite.bench_limits import unsaid_load
    from frictool.identify.excite.excitation_kinds import ExcitationSettings, excite

    document = load(bench, Bench)
    unsaid = unsaid_load(document)
    if unsaid is not None:
        note(f"warning: {unsaid}")
    sequence = excite(kind, document, ExcitationSettings(**options))
    words = {
        "--bench": bench,
        "--kind": kind,
        **{f"--{name.replace('_', '-')}": value for name, value in options.items()},
    }
    _save(sequence, output, command_line("excite", words), [bench])
    if plot is not None:
        from frictool.identify.excite.picture import picture

        save_text(plot, picture(sequence) + "\n", [bench])
    if as_json:
        print_json("excite/1", summary(sequence), output)
    else:
        say(text(sequence, output), output)


def _check_options(kind: str, options: dict[str, Any]) -> None:
    """Raise UsageError if an option belongs to another kind, or if options are contradictory."""
    for name, value in options.items():
        if value is not None and name not in KINDS[kind][1]:
            kinds = ", ".join(one for one, (_, settings) in KINDS.items() if name in settings)
            raise click.UsageError(
                f"--{name.replace('_', '-')} belongs to --kind {kinds}, not to {kind}."
            )
    if all(options[name] is not None for name in ("amplitude", "frequency", "speed")):
        raise click.UsageError(
            "speed = 2 pi frequency amplitude: give at most two of --amplitude, "
            "--frequency and --speed."
        )
    if kind == "sine" and options["duration"] is not None and options["repetitions"] is not None:
        raise click.UsageError("give --duration or --repetitions, not both.")


def _save(sequence: ExcitationSequence, output: Path, words: str, inputs: list[Path]) -> None:
    from frictool.documents.provenance import provenance_of_command
    from frictool.logs.provenance import with_provenance

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
    """Return a test as JSON values."""
    return {
        "kind": sequence.kind,
        "duration_s": sequence.duration,
        "samples": sequence.time.size,
        "columns": sequence.units,
        "rule": sequence.rule,
        "figures": sequence.figures,
    }


def text(sequence: ExcitationSequence, output: Path) -> str:
    """Return a test as text."""
    where = "stdout" if output == STDOUT else output.name
    lines = [
        f"{where}: {sequence.kind}, {sequence.duration:.4g} s, {sequence.time.size} "
        f"samples, {', '.join(sequence.columns)}"
    ]
    lines += [
        f"  {name.replace('_', ' '):<28}{value:.5g}" for name, value in sequence.figures.items()
    ]
    return "\n".join([*lines, f"to play it: {sequence.rule}"])
