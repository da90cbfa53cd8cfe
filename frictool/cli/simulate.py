"""`frictool simulate`: simulation of a model or mechanism in a scenario; writes a log."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from frictool.cli.common_options import FiniteRange, NamedPath, existing, json_option, output_option
from frictool.cli.console_output import note, note_changes, note_temperature, print_json, say
from frictool.cli.output_files import check_targets, command_line, refuse_inputs, replacing
from frictool.cli.position_loop_options import LAW, ServoGains, servo_options
from frictool.cli.progress import note_compiling, show_count
from frictool.cli.simulate_as_bench import as_bench_log
from frictool.cli.simulate_inputs import compile_target, recorded_log, with_observer_option
from frictool.cli.simulate_mechanism import (
    EventsOutput,
    is_mechanism,
    mechanism_plant,
    on_bench,
    open_log,
)
from frictool.cli.simulate_summary import bench_summary, bench_text, run_text, summary
from frictool.runtime import notifications

if TYPE_CHECKING:
    from frictool.documents.controller import ProgramNumber
    from frictool.logs.log import Log
    from frictool.simulate.mechanism_bench import MechanismBenchPlant

HELP = f"""\b
Example:
  frictool simulate model.yaml --controller controller.yaml --scenario steps.yaml -o run.mcap
  frictool simulate model.yaml --controller controller.yaml --scenario steps.yaml --target c/ \\
    -o target.mcap
  frictool simulate model.yaml --excitation sines.mcap --position-gain 30 --speed-gain 0.1 \\
    -o bench_log.mcap
  frictool simulate --as-bench truth.yaml test.mcap -o bench_log.mcap
  frictool simulate mechanism.yaml --controller controller.yaml --scenario steps.yaml \\
    --events events.csv -o run.mcap
  frictool simulate mechanism.yaml --scenario torques.yaml -o run.mcap

Simulate a scenario with a model or a whole mechanism under its controller, and write the log that a
bench would record. docs/reference/documents.md lists the keys of scenario.yaml.

The engine steps from event to event (stop, breakaway, backlash contact, knee, end stop). An axis at
rest below its breakaway does not move at all. The controller is sampled, reads the position through
the encoder, and acts after the bench's computational delay.

The log contains position, reference, drive and effort, the speed that the controller used
(velocity_estimated), and signals that only a simulation knows: position_true, velocity,
load_position, the true drive, command. Each plant is a stream: /axis is the model, /axis/NAME a
vertex or a drawn plant.

The log of a mechanism also has the stream /mechanism: position, velocity and stick state of every
block, the side of every contact, the drive of each source. Without --controller, `sources` of the
scenario drive the mechanism. The summary contains the energy balance; --events lists every
breakaway, stick, contact and impact.

--observer replaces the controller's speed signal by an observer's speed estimate. The loop with the
observer is verified at the vertices first; exit code 4 if it is unstable. `frictool observe loop`
writes the controller that contains the observer.

--number runs the controller in float or fixed point as on the target; --target runs the exported C
code, compiled here.

--excitation plays a test of `frictool excite` as the bench would. Ramps follow the rule stored in
the test. For a test with a reference, the bench's position controller is simulated: {LAW}.

--as-bench MODEL TEST does the same without further options: the gains follow from the bench's delay
and encoder, the loop adds the column feedforward of TEST or a feedforward with the bench's values,
and the measured drive has a noise of 0.2 % of the drive limit. TEST may be a CSV of a reference.
"""


@click.command("simulate", help=HELP)
@click.argument(
    "model", help="Model of the axis (model.yaml), or mechanism (mechanism.yaml).", type=existing
)
@click.argument(
    "test", required=False, help="With --as-bench: test of `frictool excite`.", type=existing
)
@click.option(
    "--as-bench",
    is_flag=True,
    help="Play TEST on the model as its bench would, with gains and noise of a usual bench.",
)
@click.option("--controller", type=existing, help="Controller (controller.yaml).")
@click.option("--scenario", type=existing, help="Scenario to simulate (scenario.yaml).")
@click.option(
    "--observer",
    type=existing,
    help="Observer that provides the speed to the controller (observer.yaml).",
)
@click.option(
    "--target",
    type=existing,
    help=("Folder of `frictool export --lang c`, whose compiled code runs as the controller."),
)
@click.option(
    "--number",
    type=click.Choice(["double", "float", "q31"]),
    help="Number format in which the controller runs. [default: double]",
)
@click.option(
    "--excitation", type=existing, help="Test of `frictool excite` (.mcap), instead of a scenario."
)
@servo_options
@click.option(
    "--drive-noise",
    type=FiniteRange(0.0),
    help=(
        "With --excitation: standard deviation of the measured drive [A | V]. [default: 0; "
        "--as-bench: 0.2 % of the drive limit]"
    ),
)
@click.option(
    "--seed",
    type=click.IntRange(0),
    help=("With --excitation: seed of the noise and of the encoder's zero. [default: 0]"),
)
@click.option(
    "--events",
    type=NamedPath(writes=("CSV",)),
    help="For a mechanism: write the times of all events to this file (CSV).",
)
@output_option(writes=("MCAP",))
@json_option
def command(
    model: Path,
    test: Path | None,
    as_bench: bool,
    controller: Path | None,
    scenario: Path | None,
    observer: Path | None,
    target: Path | None,
    number: ProgramNumber | None,
    excitation: Path | None,
    output: Path,
    as_json: bool,
    drive_noise: float | None,
    seed: int | None,
    events: Path | None,
    **servo: Any,
) -> None:
    if events is not None and (not is_mechanism(model) or excitation is not None):
        raise click.UsageError("--events works with a mechanism and a scenario only.")
    if as_bench != (test is not None) or (as_bench and excitation is not None):
        raise click.UsageError(
            "--as-bench needs MODEL and TEST, and no --excitation; without --as-bench, leave out "
            "TEST."
        )
    excitation = excitation or test
    inputs = [
        path for path in (model, controller, scenario, observer, excitation) if path is not None
    ]
    check_targets({"-o": output, "--events": events}, inputs)
    # of all kernels, the engine takes the longest time to compile
    compiling = notifications.receiving(compiling=partial(note_compiling, everywhere=True))
    click.get_current_context().with_resource(compiling)
    form = "simulate/1"
    view = summary
    text = run_text
    gains = ServoGains(servo["position_gain"], servo["speed_gain"], servo["integral_gain"])
    if excitation is not None:
        if any(option is not None for option in (controller, scenario, observer, target, number)):
            names = "--controller, --scenario, --observer, --target and --number"
            raise click.UsageError(f"--excitation does not work with {names}; leave these out.")
        if as_bench:
            if gains.closed:
                raise click.UsageError(
                    "--as-bench chooses the gains of the position loop; leave out the gain options."
                )
            log = as_bench_log(model, excitation, drive_noise, seed, output)
            _save(log, output, inputs)
        else:
            log = _bench_test(model, excitation, gains, drive_noise, seed, output)
        form = "simulate-bench/1"
        view = bench_summary
        text = bench_text
    elif scenario is None:
        raise click.UsageError(
            "give either --controller and --scenario, or --excitation; for a mechanism, --scenario "
            "is enough."
        )
    elif gains.closed or drive_noise is not None or seed is not None:
        raise click.UsageError(
            "gains, --drive-noise and --seed belong to --excitation, not to a scenario."
        )
    elif target is not None and number is not None:
        raise click.UsageError(
            "the code in --target determines the number format; leave out --number."
        )
    elif target is not None and observer is not None:
        raise click.UsageError(
            "the code in --target computes the speed signal itself; export the controller of "
            "`frictool observe loop`, and leave out --observer."
        )
    elif controller is None:
        if not is_mechanism(model):
            raise click.UsageError("give --controller or --excitation; an axis needs one of them.")
        if any(option is not None for option in (observer, target, number)):
            raise click.UsageError("--observer, --target and --number belong to --controller.")
        listed = EventsOutput(events)
        log, inputs = open_log(model, scenario, output, _progress, listed)
        _save(log, output, inputs, listed)
    else:
        log = _step_test(
            model, controller, scenario, observer, target, number, output, EventsOutput(events)
        )
    if as_json:
        print_json(form, view(log), output)
    else:
        say(text(log), output)


def _bench_test(
    model: Path,
    excitation: Path,
    gains: ServoGains,
    noise: float | None,
    seed: int | None,
    output: Path,
) -> Log:
    from frictool.documents.model import Model
    from frictool.documents.provenance import provenance_of_command
    from frictool.documents.registry import load
    from frictool.simulate.bench_experiment import bench_test, is_ramps, read_excitation

    closed = gains.closed
    test = read_excitation(excitation)
    plant: Model | MechanismBenchPlant
    if is_mechanism(model):
        plant, servo = on_bench(model, gains)
    else:
        plant = load(model, Model)
        note_temperature(model, plant)
        servo = gains.servo(plant.bench)
    if is_ramps(test) == closed:
        raise click.UsageError(
            f"{excitation.name} contains ramps of the drive, which need no position loop; "
            "leave out the gains."
            if closed
            else (
                f"{excitation.name} contains a reference; give --position-gain and --speed-gain "
                "of the bench's position loop."
            )
        )
    named = {f"--{name}-gain": getattr(gains, name) for name in ("position", "speed", "integral")}
    words = {"model": model, "--excitation": excitation, **named}
    provenance = provenance_of_command(
        command_line("simulate", words | {"--drive-noise": noise, "--seed": seed}),
        [model, excitation],
    )
    log = bench_test(plant, test, servo, noise or 0.0, seed or 0, provenance)
    _save(log, output, [model, excitation])
    return log


def _step_test(
    model: Path,
    controller: Path,
    scenario: Path,
    observer: Path | None,
    target: Path | None,
    number: ProgramNumber | None,
    output: Path,
    events: EventsOutput,
) -> Log:
    from frictool.documents.controller import Controller
    from frictool.documents.model import Model
    from frictool.documents.provenance import provenance_of_command
    from frictool.documents.registry import load
    from frictool.documents.scenario import Scenario

    plant = mechanism_plant(model, events) if is_mechanism(model) else load(model, Model)
    documents = (
        plant,
        with_observer_option(load(controller, Controller), observer),
        load(scenario, Scenario),
    )
    replay = documents[2].reference
    recorded = None if replay is None else scenario.parent / replay.log
    inputs = [
        model,
        controller,
        scenario,
        *(one for one in (observer, recorded) if one is not None),
    ]
    refuse_inputs(output, inputs)
    from frictool.simulate.closed_loop import SimulationRequest
    from frictool.simulate.document_agreement import DocumentNames
    from frictool.simulate.simulation import simulate

    log = (
        None
        if recorded is None
        else recorded_log(
            recorded, scenario, plant.bench if isinstance(plant, Model) else documents[1].bench
        )
    )
    code = None if target is None else compile_target(target, controller, documents[1])
    inputs += [] if code is None else code.sources
    words = {
        "model": model,
        "--controller": controller,
        "--scenario": scenario,
        "--observer": observer,
        "--target": target,
    }
    provenance = provenance_of_command(
        command_line("simulate", words | {"--number": number}), inputs
    )
    names = DocumentNames(str(model), str(controller), str(scenario))
    played = simulate(
        *documents,
        SimulationRequest(log, number or "double", code),
        provenance=provenance,
        names=names,
        progress=_progress,
    )
    _save(played, output, inputs, events)
    note_changes(controller, documents[1])
    return played


def _save(log: Log, output: Path, inputs: list[Path], events: EventsOutput | None = None) -> None:
    from frictool.logs.canonical.mcap_format import write_mcap

    for warning in log.warnings:
        note(f"warning: {warning}")
    with replacing(output, inputs) as stream:
        write_mcap(log, stream)
    if events is not None:
        events.save(inputs)


def _progress(done: int, total: int) -> None:
    if done > 0:
        show_count("simulated", done, total)
