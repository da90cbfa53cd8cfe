"""`frictool simulate`: simulation of a model or a mechanism in a scenario, as a log."""

from __future__ import annotations

import sys
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from frictool.cli.bench_servo import LAW, ServoGains, servo_options
from frictool.cli.output import (
    FiniteRange,
    NamedPath,
    check_targets,
    command_line,
    existing,
    json_option,
    note,
    note_changes,
    output_option,
    print_json,
    refuse_inputs,
    replacing,
    say,
)
from frictool.cli.progress import note_compiling
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
    from frictool.documents.controller import Number
    from frictool.logs.log import Log
    from frictool.simulate.mechanism_bench import MechanismBenchPlant

KEYS = """\b
scenario.yaml, key by key (quantities are {value, unit}; docs/formats.md has an example of each):
  start          position at rest before it begins
  steps          parts of the reference, one after another; each is one of
                   {reference: .., duration_s: ..}  held      {ramp_to: .., duration_s: ..}  at constant speed
                   {sine: {amplitude, frequency_hz, phase_deg, centre}, duration_s: ..}
                   {hold_s: ..}  what was there is kept, 15 s or more: limit cycles show late
  reference      in place of steps {log, channel, from_s, to_s, shift, hold_s}: a measured reference is replayed; raw logs are read by
                 the columns of the model's bench
  variants       nominal: the model; vertices: also the corners of its ranges; random: also `plants` drawn plants;
                 given: in its place one plant
  plants         how many plants are drawn from the ranges of model and bench, or from those of the mechanism's own quantities
  given          what that plant differs in, by name: {coulomb: {value, unit}, ..}, {links.belt.stiffness: ..} of a mechanism
  disturbances   efforts on the axis {kind: step | pulse | sine, effort, at_s, duration_s, frequency_hz, phase_deg}; on: a mechanism's block
  drifts         wear, warmth: {friction, viscous, constant: [{at_s, factor}, ..]}, straight lines between the points
  sensor_faults  {kind: lost_counts, counts, at_s}, {kind: encoder_stuck | encoder_invalid, at_s, until_s},
                 {kind: drive_offset, offset, at_s, until_s}, {kind: drive_gain, gain_error, at_s, until_s}
  sources        of a mechanism, by name, what each is asked for: {motor: [{kind: step | pulse | ramp | sine, level, at_s, ..}, ..]}
  duration_s     how long, in place of steps: a test without a controller
  spread         what `frictool campaign` varies beside the plant: {wear, temperature, start, sensor_faults, ..}; here it is left out
  drive          current or voltage, which the quantities of the drive are in
  drive_noise    standard deviation of the measured drive, A or V
  seed           of the noise and of the drawn plants
  examples       keys whose values `frictool init` made up and nobody has replaced; commands and verdicts warn of them
"""

HELP = f"""\b
Example:
  frictool simulate model.yaml --controller controller.yaml --scenario scenarios/steps.yaml -o run.mcap
  frictool simulate nonlinear.yaml --controller controller.yaml --scenario scenarios/random.yaml -o plants.mcap
  frictool simulate model.yaml --controller controller.yaml --scenario scenarios/steps.yaml --target c/ -o target.mcap
  frictool simulate model.yaml --controller controller.yaml --observer observer.yaml --scenario scenarios/steps.yaml -o observed.mcap
  frictool simulate model.yaml --excitation sines.mcap --position-gain 30 --speed-gain 0.1 -o bench_log.mcap
  frictool simulate mechanism.yaml --controller controller.yaml --scenario scenarios/mechanism.yaml --events events.csv -o run.mcap
  frictool simulate mechanism.yaml --scenario torques.yaml -o run.mcap

Play a scenario to the model, or to a whole mechanism, under its controller and write what a bench would have logged.

The engine moves from event to event (stop, breakaway, backlash contact, knee, end stop), in closed form where there is one: an axis at
rest below its breakaway stays where it is, exactly. The controller is sampled, sees the position through the encoder, and acts after
the bench's computational delay.
The log holds what a bench would have (position, reference, drive, effort), velocity_estimated, which the controller took for the speed, and
what only a simulation knows (position_true, velocity, load_position, the true drive, command). Each plant is a stream: /axis is the model,
/axis/NAME a vertex or a drawn plant.
Of a mechanism the log has the stream /mechanism too: position, velocity and stick of every block, the side of every contact, what flows in
each source; load_position is that of the block at the far end of the links, seen at the sensor. random draws every quantity of the file
that has low and high. Without --controller its sources follow the scenario's `sources`. The summary holds the energy balance; --events
lists every breakaway, stick, contact and impact.
With --observer the controller's speed is that of an observer (frictool observe design), whose loop is verified at the vertices first: exit
4 where it is unstable; `frictool observe loop` writes that controller for export.
With --number the controller runs in float or in fixed point as on the target; with --target the exported C itself runs, compiled here.

{KEYS}
With --excitation a test that `frictool excite` wrote as MCAP is played as the bench would play it: ramps by their rule, a reference under
the bench's own position loop,  {LAW},  on the encoder's counts. The log holds what the bench would have logged.
"""


@click.command("simulate", help=HELP)
@click.argument(
    "model", help="Model of the axis (model.yaml), or mechanism (mechanism.yaml).", type=existing
)
@click.option("--controller", type=existing, help="The controller (controller.yaml).")
@click.option("--scenario", type=existing, help="What is played: keys above (scenario.yaml).")
@click.option(
    "--observer", type=existing, help="What the controller takes for the speed (observer.yaml)."
)
@click.option(
    "--target",
    type=existing,
    help=(
        "The folder of `frictool export --lang c`: its code, compiled, in place of the "
        "simulation's."
    ),
)
@click.option(
    "--number",
    type=click.Choice(["double", "float", "q31", "q15"]),
    help="Number format the controller runs in. [default: double]",
)
@click.option("--excitation", type=existing, help="Instead: a test of `frictool excite` (.mcap).")
@servo_options
@click.option(
    "--drive-noise",
    type=FiniteRange(0.0),
    help="--excitation: standard deviation of the measured drive [A | V]. [default: 0]",
)
@click.option(
    "--seed",
    type=click.IntRange(0),
    help="--excitation: of the noise, and of the encoder's zero within a count. [default: 0]",
)
@click.option(
    "--events",
    type=NamedPath(writes=("CSV",)),
    help="Of a mechanism: where to write what happens when, as CSV.",
)
@output_option(writes=("MCAP",))
@json_option
def command(
    model: Path,
    controller: Path | None,
    scenario: Path | None,
    observer: Path | None,
    target: Path | None,
    number: Number | None,
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
    inputs = [
        path for path in (model, controller, scenario, observer, excitation) if path is not None
    ]
    check_targets({"-o": output, "--events": events}, inputs)
    # the engine takes longest of all to compile
    compiling = notifications.receiving(compiling=partial(note_compiling, everywhere=True))
    click.get_current_context().with_resource(compiling)
    gains = ServoGains(servo["position_gain"], servo["speed_gain"], servo["integral_gain"])
    if excitation is not None:
        if any(given is not None for given in (controller, scenario, observer, target, number)):
            names = "--controller, --scenario, --observer, --target and --number"
            raise click.UsageError(f"--excitation is played by the bench: leave out {names}.")
        log = _bench_test(model, excitation, gains, drive_noise, seed, output)
        views = bench_summary, bench_text
    elif scenario is None:
        raise click.UsageError(
            "give --controller and --scenario, or --excitation; of a mechanism, --scenario alone."
        )
    elif gains.given or drive_noise is not None or seed is not None:
        raise click.UsageError(
            "gains, --drive-noise and --seed belong to --excitation; a scenario has its own."
        )
    elif target is not None and number is not None:
        raise click.UsageError(
            "the sources in --target say their number format: leave out --number."
        )
    elif target is not None and observer is not None:
        raise click.UsageError(
            "the sources in --target are of one controller: write it with `frictool "
            "observe loop`, and leave out --observer."
        )
    elif controller is None:
        if not is_mechanism(model):
            raise click.UsageError(
                "give --controller, or --excitation: a model is one axis, which a "
                "controller drives."
            )
        if any(given is not None for given in (observer, target, number)):
            raise click.UsageError("--observer, --target and --number belong to --controller.")
        listed = EventsOutput(events)
        log, inputs = open_log(model, scenario, output, _progress, listed)
        _save(log, output, inputs, listed)
        views = summary, run_text
    else:
        log = _step_test(
            model, controller, scenario, observer, target, number, output, EventsOutput(events)
        )
        views = summary, run_text
    if as_json:
        print_json(views[0](log), output)
    else:
        say(views[1](log), output)


def _bench_test(
    model: Path,
    excitation: Path,
    gains: ServoGains,
    noise: float | None,
    seed: int | None,
    output: Path,
) -> Log:
    """Simulate a bench test, save its log and return it."""
    from frictool.documents.model import Model
    from frictool.documents.provenance import provenance_of_command
    from frictool.documents.registry import load
    from frictool.simulate.bench_experiment import bench_test, is_ramps, read_excitation

    closed, test = gains.given, read_excitation(excitation)
    plant: Model | MechanismBenchPlant
    if is_mechanism(model):
        plant, servo = on_bench(model, gains)
    else:
        plant = load(model, Model)
        servo = gains.servo(plant.bench)
    if is_ramps(test) == closed:
        raise click.UsageError(
            f"{excitation.name} holds ramps of the drive, which no gains follow; leave them out."
            if closed
            else (
                f"{excitation.name} holds a reference; give --position-gain and "
                "--speed-gain of the loop that follows it."
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
    number: Number | None,
    output: Path,
    events: EventsOutput,
) -> Log:
    """Simulate a scenario, save its log and return it."""
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
    """Print `simulated 3 of 17` on a terminal, overwriting the line."""
    if done > 0 and total > 1 and sys.stderr.isatty():
        click.echo(
            f"\rsimulated {done} of {total}" + ("\n" if done == total else ""), err=True, nl=False
        )
