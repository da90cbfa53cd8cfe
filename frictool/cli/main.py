"""Entry point of `frictool`: registers the commands, and turns errors into messages and exit codes.

Commands are imported on use, so that `frictool --help` costs little more than importing click.
"""

from __future__ import annotations

import atexit
import gc
import io
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import click

from frictool.cli.console_output import Verbosity, note
from frictool.cli.lazy_group import LazyGroup, abandon_stdout
from frictool.cli.terminal_escapes import printable
from frictool.documents.bench_values import bench_values_words
from frictool.documents.example_values import examples_words
from frictool.errors import EXIT_INPUT, FrictoolError
from frictool.runtime import notifications

GARBAGE = 200_000  # new objects after which garbage is collected
# command -> (module, one line for --help), in the order of the pipeline
COMMANDS: dict[str, tuple[str, str]] = {
    "init": ("frictool.cli.init", "Write commented documents for a new rig."),
    "ingest": ("frictool.cli.ingest", "Convert bench files to the canonical log (MCAP)."),
    "info": ("frictool.cli.info", "Show the contents and the quality of a log."),
    "convert": ("frictool.cli.convert", "Convert a log to the format of another tool."),
    "assess": (
        "frictool.cli.assess",
        "State which parameters a bench can identify, and how precisely.",
    ),
    "excite": (
        "frictool.cli.excite",
        "Write a test to play on the bench: sines, ramps, steps, multisines.",
    ),
    "plan": (
        "frictool.cli.plan",
        "Design the next test of a bench, until a controller meets the specification.",
    ),
    "identify": (
        "frictool.cli.identify",
        "Identify parameters with intervals from logs (model.yaml).",
    ),
    "validate": ("frictool.cli.validate", "Compare a model with a measured log."),
    "synth": ("frictool.cli.synth", "Synthesise and verify a controller (controller.yaml)."),
    "verify": (
        "frictool.cli.verify",
        "Prove the certificate of a controller again, without a solver.",
    ),
    "simulate": ("frictool.cli.simulate", "Simulate model and controller, and write a log."),
    "prove": (
        "frictool.cli.prove",
        "Prove a step test from every start in an encoder count (proof.yaml).",
    ),
    "report": ("frictool.cli.report", "Judge logs by the specification."),
    "campaign": (
        "frictool.cli.campaign",
        "Simulate many plants: pass rate, causes of failures, worst cases.",
    ),
    "reduce": (
        "frictool.cli.reduce",
        "Reduce a mechanism to a one-inertia model, with the error of each step.",
    ),
    "export": (
        "frictool.cli.export",
        "Export a controller to C99 with golden vectors, JSON or MATLAB.",
    ),
    "observe": ("frictool.cli.observe", "Estimate velocity, friction and wear; design observers."),
    "compare": ("frictool.cli.compare", "Compare friction laws in four tests."),
    "equations": ("frictool.cli.equations", "Print the equations of a mechanism."),
    "schema": ("frictool.cli.schema", "Print the JSON Schema of a document."),
    "doctor": ("frictool.cli.doctor", "Check this installation, and remove obsolete files."),
    "completion": ("frictool.cli.completion", "Print the completion script for bash, zsh or fish."),
}

EXIT_CODES = """\
  0    done
  1    done, and the answer is no or undecided
  2    wrong command line
  3    an input is wrong, or part of its data could not be read
  4    no solution, or not verified
  130  interrupted (SIGINT, SIGTERM)"""
EXAMPLE = f"""\b
Example, the whole chain:
  frictool ingest sines.csv --bench bench.yaml -o sines.mcap
  frictool identify sines.mcap ramp.mcap --bench bench.yaml -o model.yaml
  frictool synth model.yaml --spec spec.yaml --design design.yaml -o controller.yaml
  frictool simulate model.yaml --controller controller.yaml --scenario steps.yaml -o run.mcap
  frictool report run.mcap --spec spec.yaml --controller controller.yaml -o report.html
  frictool export controller.yaml --lang c -o c/

From bench logs of an actuator with dry friction, frictool identifies parameters, designs and
verifies a robust controller, exports it as C code, and judges it by a specification.

\b
Exit codes:
{EXIT_CODES}
"""


@click.group(
    cls=LazyGroup,
    table=COMMANDS,
    help=EXAMPLE,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110},
)
@click.option("--debug", is_flag=True, help="Show the traceback of an error.")
@click.option("-q", "--quiet", is_flag=True, help="No progress and no remarks on stderr.")
@click.option("-v", "--verbose", is_flag=True, help="Progress on stderr, also without a terminal.")
@click.version_option(
    None,
    *("-V", "--version"),
    package_name="frictool",
    message=f"%(prog)s %(version)s, Python {sys.version.split()[0]}",
)
def group(debug: bool, quiet: bool, verbose: bool) -> None:
    """Set the verbosity of all commands."""
    if quiet and verbose:
        raise click.UsageError("--quiet and --verbose exclude each other.")
    Verbosity.quiet, Verbosity.verbose = quiet, verbose


def main() -> None:
    """Run the command line; the entry point of `frictool`."""
    debug = "--debug" in sys.argv[1:]
    _prepare()
    with (
        _terminated_as_interrupted(),
        notifications.receiving(
            compiling=_tell_of_compiling,
            remark=_remark,
            example_values=_warn_of_examples(),
            bench_values=_warn_of_bench_values,
            missing_effect=_warn_of_missing_effect,
        ),
    ):
        _run(debug)


@contextmanager
def _terminated_as_interrupted() -> Iterator[None]:
    """Make SIGTERM raise KeyboardInterrupt, as SIGINT does, so that no partial output remains."""
    if (
        threading.current_thread() is not threading.main_thread()
        or signal.getsignal(signal.SIGTERM) != signal.SIG_DFL
    ):
        yield  # a calling program keeps its own handler
        return
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, signal.SIG_DFL)


def _run(debug: bool) -> None:
    try:
        group(prog_name="frictool", standalone_mode=True)
        sys.stdout.flush()
    except FrictoolError as error:
        if debug:
            raise
        _complain(str(error))
        sys.exit(error.exit_code)
    except BrokenPipeError:  # the reader has closed the pipe
        abandon_stdout()
        sys.exit(EXIT_INPUT)
    except MemoryError:
        if debug:
            raise
        _complain("out of memory; cut the log or use a machine with more memory")
        sys.exit(EXIT_INPUT)
    except OSError as error:
        if debug:
            raise
        if error.filename is None:
            abandon_stdout()
        _complain(f"{error.filename or 'stdout'}: {error.strerror or error}")
        sys.exit(EXIT_INPUT)


def _warn_of_examples() -> Callable[[str, tuple[str, ...]], None]:
    said: set[str] = set()

    def warn(path: str, keys: tuple[str, ...]) -> None:
        examples = [key for key in keys if key.removeprefix("bench.") not in said]
        said.update(key.removeprefix("bench.") for key in examples)
        if examples:
            click.echo(printable(f"warning: {examples_words({path: examples})}"), err=True)

    return warn


def _warn_of_bench_values(path: str, reason: str) -> None:
    click.echo(printable(f"warning: {bench_values_words(path, reason)}"), err=True)


def _warn_of_missing_effect(path: str, text: str) -> None:
    click.echo(printable(f"warning: {path}: {text}"), err=True)


def _prepare() -> None:
    """Prepare the process: one thread for linear algebra, robust streams, few garbage collections.

    With several threads, linear algebra would sum in another order and change the last digits.
    stdout and stderr are replaced if they are closed, and escape characters that the terminal's
    encoding lacks. A garbage collection would only search the many objects of imported packages.
    """
    gc.set_threshold(GARBAGE, *gc.get_threshold()[1:])
    atexit.register(gc.freeze)
    os.environ.update(OPENBLAS_NUM_THREADS="1", MKL_NUM_THREADS="1")
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: SIM115  # open as long as the process
        stream = getattr(sys, name)
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")


def _tell_of_compiling() -> None:
    from frictool.cli.progress import note_compiling

    note_compiling()


def _remark(text: str) -> None:
    if not Verbosity.quiet:
        note(text)


def _complain(message: str) -> None:
    line = printable(message).replace("\n", "\\n")
    click.echo(click.style("error: ", fg="red", bold=True) + line, err=True, color=_colours())


def _colours() -> bool | None:
    return False if os.environ.get("NO_COLOR") else None


if __name__ == "__main__":
    main()
