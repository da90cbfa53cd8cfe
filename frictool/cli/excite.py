"""`frictool excite`: test signals for the bench."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from frictool.cli.common_options import FiniteRange, NamedPath, existing, json_option, output_option
from frictool.cli.console_output import print_json, say
from frictool.cli.excite_precise import PRECISE, PreciseRun, write_precise
from frictool.cli.excite_test import (
    bench_of,
    note_returning_ramps,
    save_plot,
    save_test,
    summary,
    text,
)
from frictool.cli.output_files import check_targets, command_line
from frictool.cli.precision_option import PrecisionParam

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
    "speeds": (
        "viscous, Coulomb and the Stribeck fall: runs at constant speeds",
        ("speeds", "duration"),
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
  frictool excite --bench bench.yaml --for coulomb=2% --for inertia=1% -o test.mcap \\
    --promise promise.yaml

Write a test to play on the bench, as CSV or MCAP with one row per sample: the reference, or for
`breakaway` the command of the drive.

\b
Kinds, with the parameters that each can identify:
{chr(10).join(f"  {name:<10} {what}" for name, (what, _) in KINDS.items())}

With the defaults, the worst axis of the bench (heaviest, most friction, weakest actuator) can
follow the test. A reference is checked against travel, speed and drive; ramps are simulated on
the lightest, the nominal and the heaviest axis. Numbers are in SI.

With --for instead of --kind, the test is the shortest test that reaches the wanted precisions; with
--duration, it is the most precise test of this duration. A precision is the half width of a 95 %
interval, relative to the bench's value. The test is designed for the worst axis of the bench's
intervals. It consists of strokes of several lengths, speeds and shapes, or of ramps for the
breakaway. --promise writes the expected intervals; `frictool identify --promise` compares the
identified intervals with them.

Exit code 1 if a test of --duration misses a wanted precision; 4 if the test exceeds a limit, or if
no test reaches the precision. The message names the limit and a remedy.
"""
positive = FiniteRange(0.0, min_open=True)


@click.command("excite", help=HELP)
@click.option("--bench", type=existing, required=True, help="Rig (bench.yaml).")
@click.option("--kind", type=click.Choice(list(KINDS)), help="Kind of the test.")
@click.option(
    "--for",
    "wanted",
    type=PrecisionParam(PRECISE, named=True),
    multiple=True,
    metavar="NAME=2%",
    help=f"Wanted precision of a parameter ({', '.join(PRECISE)}), instead of --kind.",
)
@click.option(
    "--amplitude",
    type=positive,
    help=("Half of the peak-to-peak distance [rad | m], or top of the breakaway ramps [A | V]."),
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
    help=(
        "Duration of a sine, sines or speeds test; with --for, of the most precise test [s].  "
        "[default: 10, 30, 60]"
    ),
)
@click.option(
    "--repetitions",
    type=click.IntRange(1, 100_000),
    help=("Number of periods of a sine or multisine, or of rounds of steps or ramps."),
)
@click.option(
    "--speeds",
    type=click.IntRange(2, 100),
    help="Number of speeds of kind sines or speeds.  [default: 6, 10]",
)
@click.option(
    "--harmonics",
    type=click.IntRange(2, 500),
    help="Number of harmonics of a multisine.  [default: 10]",
)
@click.option(
    "--seed",
    type=click.IntRange(0),
    help="Seed of the random turning points of kind sines, and of --for.  [default: 0]",
)
@click.option(
    "--open-loop",
    is_flag=True,
    default=None,
    help="For breakaway: play every ramp to its top, even if the axis already moves.",
)
@click.option(
    "--longest",
    type=positive,
    help="With --for: longest allowed test [s].  [default: 3600]",
)
@click.option(
    "--noise",
    type=positive,
    help=(
        "With --for: standard deviation of the measured drive [A | V].  "
        "[default: 0.2 % of the drive limit]"
    ),
)
@click.option(
    "--ramps",
    type=NamedPath(writes=("MCAP",)),
    help="With --for breakaway and other parameters: file of the ramps (.mcap).",
)
@click.option(
    "--promise", type=NamedPath(writes=("YAML",)), help="With --for: write the promise (YAML)."
)
@click.option("--plot", type=NamedPath(writes=("SVG",)), help="Write a picture of the test (SVG).")
@output_option(
    help="Test (.csv or .mcap); - is CSV on stdout.", writes=("CSV", "MCAP"), chooses=True
)
@json_option
def command(
    bench: Path,
    kind: str | None,
    wanted: tuple[tuple[str | None, float], ...],
    plot: Path | None,
    output: Path,
    as_json: bool,
    **options: Any,
) -> None:
    precise = {name: options.pop(name) for name in ("longest", "noise", "ramps", "promise")}
    if (kind is None) == (not wanted):
        raise click.UsageError("give --kind or --for.")
    if kind is None:
        named = {name: part for name, part in wanted if name is not None}
        write_precise(PreciseRun(bench, named, options, precise, plot, output, as_json))
        return
    for name, value in precise.items():
        if value is not None:
            raise click.UsageError(f"--{name} belongs to --for; add --for, or leave it out.")
    _check_options(kind, options)
    check_targets({"-o": output, "--plot": plot}, [bench])
    from frictool.identify.excite.excitation_kinds import ExcitationSettings, excite

    document = bench_of(bench)
    sequence = excite(kind, document, ExcitationSettings(**options))
    note_returning_ramps(sequence, document)
    words = {
        "--bench": bench,
        "--kind": kind,
        **{f"--{name.replace('_', '-')}": value for name, value in options.items()},
    }
    save_test(sequence, output, command_line("excite", words), [bench])
    if plot is not None:
        save_plot(sequence, plot, bench)
    if as_json:
        print_json("excite/1", summary(sequence), output)
    else:
        say(text(sequence, output, document), output)


def _check_options(kind: str, options: dict[str, Any]) -> None:
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
