"""`frictool excite --for`: test signals that reach requested precisions of the parameters."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click

from frictool.cli.console_output import note, print_json, say
from frictool.cli.excite_test import (
    bench_of,
    note_returning_ramps,
    save_plot,
    save_test,
    summary,
    text,
)
from frictool.cli.output_files import check_targets, command_line, save_text
from frictool.cli.progress import note_step
from frictool.errors import EXIT_NO

STROKES = ("inertia", "viscous", "coulomb", "offset")
RAMPS = ("breakaway",)
PRECISE = (*STROKES, *RAMPS)
SETTINGS = ("duration", "seed")  # options of --kind that --for reads


@dataclass(frozen=True)
class PreciseRun:
    """Arguments and options of `frictool excite --for`.

    - wanted: requested relative precision of each parameter
    - options: values of the options that --for shares with --kind
    - precise: values of the options --longest, --noise, --ramps and --promise
    """

    bench: Path
    wanted: dict[str, float]
    options: dict[str, Any]
    precise: dict[str, Any]
    plot: Path | None
    output: Path
    as_json: bool


def write_precise(run: PreciseRun) -> None:
    """Design test signals for requested precisions, write them, and print the expected precisions.

    The exit code is 1 if the test misses a requested precision.
    """
    _check(run)
    ramps, promise = run.precise["ramps"], run.precise["promise"]
    targets = {"-o": run.output, "--plot": run.plot, "--ramps": ramps, "--promise": promise}
    check_targets(targets, [run.bench])
    from frictool.documents.provenance import provenance_of_command
    from frictool.documents.writing import to_yaml
    from frictool.identify.excite.precise_strokes import PrecisionRequest
    from frictool.identify.excite.promise_document import promise_of
    from frictool.plan.rehearsed_test import rehearsed_ramps, rehearsed_strokes

    bench = bench_of(run.bench)
    precise = {name: run.precise[name] for name in ("longest", "noise") if run.precise[name]}
    request = PrecisionRequest(
        run.wanted, duration=run.options["duration"], seed=run.options["seed"] or 0, **precise
    )
    tests = []
    if any(name in STROKES for name in run.wanted):
        tests.append(rehearsed_strokes(bench, request, note_step))
    if any(name in RAMPS for name in run.wanted):
        tests.append(rehearsed_ramps(bench, request, note_step))
    wanted = tuple(f"{name}={part:g}" for name, part in run.wanted.items())
    words = command_line(
        "excite",
        {
            "--bench": run.bench,
            "--for": wanted,
            **{f"--{name}": value for name, value in (run.options | precise).items()},
        },
    )
    for test, target in zip(tests, (run.output, ramps), strict=False):
        note_returning_ramps(test.sequence, bench)
        save_test(test.sequence, target, words, [run.bench])
    if promise is not None:
        provenance = provenance_of_command(words, [run.bench])
        document = promise_of(tests, bench, request.noise, provenance)
        save_text(promise, to_yaml(document), [run.bench])
    if run.plot is not None:
        save_plot(tests[0].sequence, run.plot, run.bench)
    if run.as_json:
        view = summary(tests[0].sequence)
        extra = {"ramps": summary(tests[1].sequence)} if len(tests) > 1 else {}
        print_json("excite/1", view | extra, run.output)
    else:
        for test, target in zip(tests, (run.output, ramps), strict=False):
            say(text(test.sequence, target, bench), run.output)
    missed = _missed(run.wanted, {k: v for one in tests for k, v in one.half_widths.items()}, bench)
    if missed:
        duration = run.options["duration"]
        note(f"a test of {duration:g} s is not precise enough: {', '.join(missed)}")
        click.get_current_context().exit(EXIT_NO)


def _missed(wanted: dict[str, float], promised: dict[str, float], bench: Any) -> list[str]:
    from frictool.identify.excite.breakaway_ramps import breakaway_range
    from frictool.identify.excite.precise_strokes import bench_value

    out = []
    for name, part in wanted.items():
        value = breakaway_range(bench)[1] if name in RAMPS else bench_value(bench, name)
        if name not in promised:
            out.append(f"{name}: `identify` cannot determine it from the simulated test")
            continue
        reached = promised[name] / value
        if reached > part * (1.0 + 1e-9):
            out.append(f"{name} {100 * reached:.3g} % (requested {100 * part:.3g} %)")
    return out


def _check(run: PreciseRun) -> None:
    for name, value in run.options.items():
        if value is not None and name not in SETTINGS:
            raise click.UsageError(f"--{name.replace('_', '-')} belongs to --kind, not to --for.")
    both = {name in RAMPS for name in run.wanted} == {True, False}
    if both and run.precise["ramps"] is None:
        raise click.UsageError(
            "--for with breakaway and other parameters makes two tests; name the file of the "
            "breakaway ramps with --ramps FILE."
        )
    if not both and run.precise["ramps"] is not None:
        raise click.UsageError(
            "--ramps is used only if --for names breakaway and other parameters; leave out --ramps."
        )
