"""`export --lang fmu` of a model: the unit is valid, compiles strictly, and moves as the engine."""

from __future__ import annotations

import shutil
import subprocess
import zipfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from msgspec.structs import replace

from frictool.adapters.axis_model import axis_of, load_of
from frictool.documents.bench import Bench, Winding
from frictool.documents.laws import (
    Backward,
    Dwell,
    FrictionOverPosition,
    Gravity,
    Laws,
    Load,
    Polynomial,
    Regime,
    Ripple,
)
from frictool.documents.model import Model
from frictool.documents.quantity import Quantity, Span
from frictool.documents.registry import load
from frictool.engine.axis_motion import advance, drive_range
from frictool.engine.closed_loop import PARTS, measure
from frictool.engine.status_codes import OK
from frictool.export.axis_fmu import EVENTS, MODES, axis_fmu
from frictool.plant import axis as ax
from frictool.plant.axis import AxisParameters, rest
from frictool.plant.axis_friction_laws import AxisFrictionLevels
from frictool.plant.position_load import with_load
from tests.support.axis_events import events_of
from tests.support.compiled_c import COMPILERS, ORIGIN, STRICT, needs_compiler
from tests.support.export_models import BENCH, estimate, known_model
from tests.support.fmi_units import Unit, extracted, source_files

GOLDEN = Path(__file__).parent / "golden"
PERIOD = 1e-3
AGREES = 1e-9  # rad
GRID = 32  # parts of a period in which at most one event is expected unless the mode changes
INSTANT = 1e-10  # s, events that are closer together count as simultaneous
# events between two modes, if all of them are simultaneous or the only ones
TURNS = {(0, 1): 1, (0, 2): 1, (1, 0): 1, (2, 0): 1, (2, 1): 1, (1, -2): 2, (1, -1): 2, (2, -2): 2}


def per(value: float) -> Any:
    return Quantity(value, unit="rad")


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> Model:
    """Coulomb friction with a breakaway, an offset, and a backlash."""
    path = tmp_path_factory.mktemp("known") / "bench.yaml"
    path.write_text(BENCH)
    bench = load(path, Bench)
    mechanics = replace(bench.mechanics, backlash=per(0.05), backlash_coulomb=Quantity(0.1))
    actuator = replace(bench.actuator, loop_time_constant_s=2e-3)
    model = known_model(replace(bench, mechanics=mechanics, actuator=actuator))
    breakaway = estimate(0.32, "N m", 0.02)
    return replace(model, parameters=replace(model.parameters, breakaway=breakaway))


@pytest.fixture(scope="module")
def plain_folder(plain: Model, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The extracted unit of the plain model."""
    (content,) = axis_fmu(plain, ORIGIN, ())[0].values()
    return extracted(content, tmp_path_factory.mktemp("plain") / "unit")


def with_laws(model: Model, **laws: Any) -> Model:
    return replace(model, laws=Laws(**laws))


def with_travel(model: Model) -> Model:
    mechanics = replace(model.bench.mechanics, travel=Span(-0.7, 0.9, "rad"))
    return replace(model, bench=replace(model.bench, mechanics=mechanics))


def with_stribeck(model: Model, velocity: float = 0.5) -> Model:
    parameters = replace(model.parameters, stribeck_velocity=estimate(velocity, "rad/s", 0.1))
    return replace(model, law="stribeck", parameters=parameters)


def with_winding(model: Model) -> Model:
    actuator = replace(model.bench.actuator, winding=Winding(resistance_ohm=1.5, voltage_v=6.0))
    return replace(model, bench=replace(model.bench, actuator=actuator))


BACKWARD = Backward(estimate(0.012, "N m s/rad"), estimate(0.2, "N m"), estimate(0.29, "N m"))
REGIMES = (Regime(Quantity(2.0), estimate(0.03, "N m s/rad")), Regime(
    Quantity(6.0), estimate(0.001, "N m s/rad"), estimate(0.02, "N m s/rad")
))  # fmt: skip
OVER_POSITION = FrictionOverPosition(
    Span(-1.0, 1.5, "rad"),
    Polynomial((1.0, 0.2, -0.1), (1.2, -0.3)),
    Polynomial((1.3, 0.2), (1.5,)),
)
DWELL = Dwell(0.8, 5e-3)
GRAVITY = Gravity(estimate(0.3, "N m"), estimate(-0.1, "N m"))
RIPPLE = Ripple(7.0, per(6.283), estimate(0.03, "N m"), estimate(0.02, "N m"))
LOAD = Load(estimate(0.4, "N m/rad"), GRAVITY, RIPPLE, (replace(RIPPLE, cycles=14.0),))
CASES: dict[str, Callable[[Model], Model]] = {
    "plain": lambda model: model,
    "directions": lambda model: with_laws(model, backward=BACKWARD),
    "regimes": lambda model: with_laws(model, backward=BACKWARD, regimes=REGIMES),
    "end stops": lambda model: with_travel(with_laws(model, restitution=0.6)),
    "stribeck": with_stribeck,
    "other exponent": lambda model: with_stribeck(with_laws(model, stribeck_exponent=1.3), 0.8),
    "dwell": lambda model: with_laws(model, dwell=DWELL),
    "position": lambda model: with_laws(model, position=OVER_POSITION, backward=BACKWARD),
    "load": lambda model: with_laws(model, load=LOAD),
    "winding": with_winding,
    "all": lambda model: with_winding(
        with_travel(
            with_stribeck(
                with_laws(
                    model,
                    backward=BACKWARD,
                    regimes=REGIMES,
                    position=OVER_POSITION,
                    dwell=DWELL,
                    restitution=0.3,
                    load=LOAD,
                )
            )
        )
    ),
}


class Built(NamedTuple):
    """A case, its model, and its extracted unit."""

    case: str
    model: Model
    folder: Path


# laws that the case "all" has too
LONG = ("directions", "regimes", "stribeck", "dwell", "end stops", "position", "load", "winding")


@pytest.fixture(
    scope="module",
    params=[
        pytest.param(case, marks=pytest.mark.accept) if case in LONG else case for case in CASES
    ],
)
def built(
    request: pytest.FixtureRequest, plain: Model, tmp_path_factory: pytest.TempPathFactory
) -> Built:
    if request.param == "plain":
        return Built("plain", plain, request.getfixturevalue("plain_folder"))
    model = CASES[request.param](plain)
    (content,) = axis_fmu(model, ORIGIN, ())[0].values()
    return Built(request.param, model, extracted(content, tmp_path_factory.mktemp("unit") / "unit"))


class Plant:
    """The engine under held commands, with the events that its modes show."""

    def __init__(self, axis: AxisParameters, model: Model) -> None:
        self.p = with_load(axis.as_array(), load_of(model).as_array())
        self.state = rest()
        self.parts = PARTS if axis.resistance > 0.0 else 1

    def step(self, command: float, duration: float) -> None:
        for _ in range(self.parts):
            assert advance(self.state, command, self.p, duration / self.parts) == OK

    def events(self, command: float, duration: float) -> int:
        """Number of events of a step, which is taken."""
        count = 0
        for _ in range(self.parts):
            held, p = self._held(command)
            part = duration / self.parts / GRID
            count += sum(self._events(held, p, part) for _ in range(GRID))
        return count

    def _held(self, command: float) -> tuple[float, np.ndarray[Any, Any]]:
        """The command within the winding's limit at this speed, and a plant without this limit."""
        p = self.p.copy()
        if p[ax.RESISTANCE] > 0.0:
            low, high = drive_range(p, self.state[ax.VELOCITY])
            limit = p[ax.DRIVE_LIMIT]
            command = float(np.clip(np.clip(command, -limit, limit), low, high))
            self.state[ax.DRIVE] = np.clip(self.state[ax.DRIVE], low, high)
            p[ax.RESISTANCE] = 0.0
        return command, p

    def _events(self, command: float, p: np.ndarray[Any, Any], duration: float) -> int:
        """Number of events of a part of a step, by bisection until at most one is possible."""
        before = self.state.copy()
        assert advance(self.state, command, p, duration) == OK
        first, last = int(before[ax.MODE]), int(self.state[ax.MODE])
        if first == last:
            return 0
        if duration >= INSTANT:
            self.state = before
            return sum(self._events(command, p, duration / 2) for _ in range(2))
        sign = -1 if first < 0 or (first == 0 and last < 0) else 1
        return TURNS[sign * first, sign * last]


def drawn(model: Model, rng: np.random.Generator) -> tuple[AxisParameters, dict[str, float]]:
    """A plant with other parameters than the model, and the settings that make the unit the same.

    The breakaway is above the Coulomb friction at every position, as the engine requires.
    """
    base = axis_of(model)
    backward = base.laws.backward or AxisFrictionLevels(base.viscous, base.coulomb, base.breakaway)
    ends = (1.0, 1.4) if base.laws.shape is None else (1.6, 1.8)
    names = ("inertia", "constant", "viscous", "coulomb")
    changed = {name: getattr(base, name) * float(rng.uniform(0.8, 1.25)) for name in names}
    changed["breakaway"] = changed["coulomb"] * float(rng.uniform(*ends))
    changed["offset"] = float(rng.uniform(-0.1, 0.1))
    changed["lag"] = float(rng.choice([0.0, 4e-4, 5e-3]))
    changed["backlash"] = float(rng.choice([0.0, 0.03, 0.4]))
    coulomb = backward.coulomb * float(rng.uniform(0.8, 1.25))
    opposite = backward._replace(coulomb=coulomb, breakaway=coulomb * float(rng.uniform(*ends)))
    axis = base._replace(**changed, laws=base.laws._replace(backward=opposite))
    settings = {}
    for name, value in changed.items():
        by_direction = name in AxisFrictionLevels._fields
        settings[f"{name}_forward" if by_direction else name] = value
    settings |= {f"{name}_backward": value for name, value in opposite._asdict().items()}
    return axis.checked(), settings


def commands(rng: np.random.Generator, count: int, hold: int) -> np.ndarray[Any, Any]:
    """Commands that are held for some periods; some are below breakaway, some at the limit."""
    levels = rng.choice([0.0, 3.0, 5.0, 8.0, 25.0], size=count) * rng.uniform(-1.0, 1.0, count)
    return np.repeat(levels, rng.integers(1, hold, count))


def test_fmpy_finds_no_fault_in_the_description(plain: Model, tmp_path: Path) -> None:
    validation = pytest.importorskip("fmpy.validation", reason="fmpy is not installed")
    for name, case in CASES.items():
        path = tmp_path / f"{name}.fmu"
        (content,) = axis_fmu(case(plain), ORIGIN, ())[0].values()
        path.write_bytes(content)
        assert validation.validate_fmu(str(path)) == []


@pytest.mark.parametrize(
    ("built", "seeds"),
    [
        *((case, (1, 3, 5)) for case in CASES if case not in LONG),
        *(pytest.param(case, range(6), marks=pytest.mark.accept) for case in CASES),
    ],
    indirect=["built"],
)
def test_random_plants_move_as_in_the_engine(built: Built, seeds: Sequence[int]) -> None:
    """At communication steps of a period, with the same modes and events."""
    modes, counted, bounced = set[int](), 0, 0
    for seed in seeds:
        rng = np.random.default_rng([2026, seed, list(CASES).index(built.case)])
        axis, settings = drawn(built.model, rng)
        plant, unit = Plant(axis, built.model), Unit(built.folder, **settings)
        events, hits, played = 0, 0, commands(rng, 12, 60)
        stops = axis.laws.stops[0] > -np.inf
        if stops and seed == 3:  # swings up to the stops, in the resonance of the spring
            played = np.append(played, np.tile(np.repeat([25.0, -25.0], 220), 2))
        states, by_slips = events_of(plant.p, played, PERIOD) if stops else ([], [])
        for k, command in enumerate(played):
            unit.set(command=command)
            unit.step(PERIOD)
            if stops:
                plant.step(command, PERIOD)
                assert states[k] == pytest.approx(plant.state, rel=1e-12, abs=1e-12)
                events, hits = by_slips[k]
            else:
                events += plant.events(command, PERIOD)
            assert_same(unit, plant)
            mode, counted_by_unit = unit.get("mode", "events")
            assert counted_by_unit == events
            modes.add(mode)
        counted += events
        bounced += hits
    assert modes == set(MODES.values())
    assert counted > 3 * len(seeds)
    assert bounced > 0 or not stops


def test_other_communication_steps_give_the_same_motion(built: Built) -> None:
    """Commands change every ten periods; the engine moves by periods. The limit of a winding is
    computed four times per period, so that other fractions of a period would move the limit."""
    axis = axis_of(built.model)
    for ratio in (0.25, 5.0) if axis.resistance > 0.0 else (0.25, 0.37, 5.0):
        rng = np.random.default_rng([28, list(CASES).index(built.case)])
        axis, settings = drawn(built.model, rng)
        plant, unit = Plant(axis, built.model), Unit(built.folder, **settings)
        for command in commands(rng, 40, 2):
            unit.set(command=command)
            left = 10.0
            while left > 0.0:
                part = min(ratio, left)
                unit.step(part * PERIOD)
                left = left - part if left - part > 1e-3 * part else 0.0
            for _ in range(10):
                plant.step(command, PERIOD)
            assert_same(unit, plant)
        assert unit.get("events")[0] >= 5


def assert_same(unit: Unit, plant: Plant) -> None:
    """Assert that the unit has the state of the engine."""
    state = plant.state
    names = ("position", "load_position", "velocity", "drive", "measured_position")
    position, load_position, velocity, drive, measured = unit.get(*names)
    assert position == pytest.approx(state[ax.POSITION], abs=AGREES, rel=0.0)
    assert load_position == pytest.approx(state[ax.LOAD_POSITION], abs=AGREES, rel=0.0)
    assert velocity == pytest.approx(state[ax.VELOCITY], abs=1e-7, rel=0.0)
    assert drive == pytest.approx(state[ax.DRIVE], abs=1e-9, rel=0.0)
    assert measured == measure(position, plant.p[ax.ENCODER_STEP])
    assert unit.get("mode") == [state[ax.MODE]]


def test_parameters_that_change_between_steps_act_from_then_on(
    plain: Model, plain_folder: Path
) -> None:
    """Friction and inertia drift while the axis moves, sticks and runs through its backlash."""
    unit = Unit(plain_folder)
    base = axis_of(plain)
    plant = Plant(base, plain)
    rng = np.random.default_rng(1128)
    for k, command in enumerate(commands(rng, 30, 40)):
        if k % 7 == 0:
            inertia, coulomb = rng.uniform(0.5, 2.0, 2) * (base.inertia, base.coulomb)
            unit.set(inertia=inertia, coulomb_forward=coulomb, coulomb_backward=coulomb)
            plant.p[[ax.INERTIA, ax.COULOMB]] = inertia, coulomb
            plant.p[ax.BREAKAWAY] = max(base.breakaway, coulomb)
        unit.set(command=command)
        unit.step(PERIOD)
        plant.step(command, PERIOD)
        assert_same(unit, plant)
    assert unit.get("events")[0] > 10


@pytest.mark.parametrize("axis", ["rotary", "linear"])
@pytest.mark.parametrize("drive", ["current", "voltage"])
def test_units_of_every_axis_are_defined(
    axis: Any, drive: Any, plain: Model, tmp_path: Path
) -> None:
    validation = pytest.importorskip("fmpy.validation", reason="fmpy is not installed")
    model = with_travel(with_stribeck(with_laws(plain, backward=BACKWARD, load=LOAD)))
    actuator = replace(model.bench.actuator, drive=drive)
    bench = replace(model.bench, axis=axis, actuator=actuator)
    (content,) = axis_fmu(replace(model, axis=axis, bench=bench), ORIGIN, ())[0].values()
    (tmp_path / "unit.fmu").write_bytes(content)
    assert validation.validate_fmu(str(tmp_path / "unit.fmu")) == []
    from fmpy import read_model_description

    description = read_model_description(str(tmp_path / "unit.fmu"))
    units = {one.name: one.unit for one in description.modelVariables}
    effort, drive_unit = {"rotary": "N m", "linear": "N"}[axis], drive[0].upper()
    drive_unit = {"C": "A", "V": "V"}[drive_unit]
    assert units["constant"] == f"{effort}/{drive_unit}"
    assert units["command"] == drive_unit
    assert units["coulomb_forward"] == effort


def test_an_hour_below_breakaway_moves_by_nothing(plain: Model, plain_folder: Path) -> None:
    start = 0.1234567
    hold = (plain.parameters.breakaway.value - plain.parameters.offset.value) / 0.1
    for backlash, most in ((0.0, hold), (0.05, 0.1 * hold)):
        unit = Unit(plain_folder, start_position=start, backlash=backlash)
        rng = np.random.default_rng(3600)
        for command in rng.uniform(-most, most, 3600):
            unit.set(command=command)
            unit.step(1.0)
        unit.step(3600.0)
        assert unit.get("position", "load_position", "velocity") == [start, start, 0.0]
        assert unit.get("mode", "events", "last_event") == [MODES["stuck"], 0, EVENTS["none"]]
    unit.set(command=1.01 * (hold + 1.0))
    unit.step(1.0)
    assert unit.get("position")[0] > start + 0.1


def test_the_last_event_has_a_name(plain: Model, tmp_path: Path) -> None:
    (content,) = axis_fmu(with_travel(plain), ORIGIN, ())[0].values()
    unit = Unit(extracted(content, tmp_path / "unit"), lag=0.0)
    named = []
    for command in (0.5, 3.0, 5.0, 0.0, 20.0):
        unit.set(command=command)
        for _ in range(200):
            unit.step(PERIOD)
            named.append(unit.get("last_event")[0])
    names = {value: name for name, value in EVENTS.items()}
    changes = [names[one] for k, one in enumerate(named) if k == 0 or one != named[k - 1]]
    assert changes[:3] == ["none", "breakaway", "contact"]
    assert changes[-1] == "stop"
    assert unit.get("position")[0] == 0.9
    assert unit.get("load_position")[0] == pytest.approx(0.875, abs=1e-12)


def test_a_stored_state_continues_with_the_same_bits(built: Built) -> None:
    unit = Unit(built.folder, start_position=0.05)
    rng = np.random.default_rng(7)
    levels = commands(rng, 12, 30)

    def played(values: Any) -> list[Any]:
        out = []
        for command in values:
            unit.set(command=command)
            unit.step(PERIOD)
            out += unit.get("position", "velocity", "drive") + unit.get("mode", "events")
        return out

    played(levels[:60])
    state = unit.slave.getFMUState()
    stored = unit.slave.serializeFMUState(state)
    once = played(levels[60:])
    unit.set(inertia=1.0)
    unit.slave.setFMUState(unit.slave.deserializeFMUState(stored))
    assert played(levels[60:]) == once
    assert len(set(once)) > 10
    with pytest.raises(Exception, match="fmi3DeserializeFMUState failed"):
        unit.slave.deserializeFMUState(stored[:-1])
    unit.slave.reset()
    assert unit.get("position", "velocity", "drive") == [0.0, 0.0, 0.0]
    unit.slave.freeInstance()


def test_wrong_requests_are_errors_and_change_nothing(built: Built) -> None:
    unit = Unit(built.folder)
    unit.set(command=5.0)
    unit.step(0.05)
    before = unit.get("position", "velocity", "drive", "inertia", "offset", "backlash")
    for step in (0.0, -1e-3, float("nan"), float("inf")):
        with pytest.raises(Exception, match="fmi3DoStep failed"):
            unit.slave.doStep(unit.time, step)
    wrong = {"inertia": [0.0, -1.0, float("nan"), float("inf")], "coulomb_forward": [-0.1]}
    wrong |= {
        "offset": [float("nan"), float("inf")],
        "backlash": [0.02],
        "start_position": [0.0],
        "position": [0.0],
    }
    for name, values in wrong.items():
        for value in values:
            with pytest.raises(Exception, match="fmi3SetFloat64 failed"):
                unit.set(**{name: value})
    for command in (float("nan"), float("inf")):
        unit.set(command=command)
        with pytest.raises(Exception, match="fmi3DoStep failed"):
            unit.step(PERIOD)
    assert before == unit.get("position", "velocity", "drive", "inertia", "offset", "backlash")
    for getter in (unit.slave.getFloat64, unit.slave.getInt64):
        with pytest.raises(Exception, match="failed"):
            getter([999])
    unit.set(command=5.0, inertia=4e-3)
    unit.step(PERIOD)
    assert unit.get("inertia") == [4e-3]


def test_a_unit_starts_with_its_own_description_only(built: Built) -> None:
    from fmpy.fmi3 import FMU3Slave

    unit = Unit(built.folder)
    identifier = unit.description.coSimulation.modelIdentifier
    other = FMU3Slave(
        guid="0", unzipDirectory=str(built.folder), modelIdentifier=identifier, instanceName="other"
    )
    with pytest.raises(Exception, match="instantiate"):
        other.instantiate()
    slave = FMU3Slave(
        guid=unit.description.guid,
        unzipDirectory=str(built.folder),
        modelIdentifier=identifier,
        instanceName="early",
    )
    slave.instantiate()
    with pytest.raises(Exception, match="fmi3DoStep failed"):
        slave.doStep(0.0, PERIOD)


DRIVER = """
#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

void *fmi3InstantiateCoSimulation(
    const char *, const char *, const char *, bool, bool, bool, bool, const uint32_t[], size_t,
    void *, void *, void *);
int fmi3ExitInitializationMode(void *);
int fmi3SetFloat64(void *, const uint32_t[], size_t, const double[], size_t);
int fmi3GetFloat64(void *, const uint32_t[], size_t, double[], size_t);
int fmi3DoStep(void *, double, double, bool, bool *, bool *, bool *, double *);
void fmi3FreeInstance(void *);

int main(void)
{
    const uint32_t command = 1, position = 2;
    void *unit = fmi3InstantiateCoSimulation(
        "a", "TOKEN", "", false, false, false, false, NULL, 0, NULL, NULL, NULL);
    double drive, x = 0.0, last;
    bool event, end, early;
    int k;

    fmi3ExitInitializationMode(unit);
    for (k = 0; k < 2000; k++) {
        drive = 12.0 * sin(0.003 * k * sin(0.0007 * k));
        if (fmi3SetFloat64(unit, &command, 1, &drive, 1) != 0 ||
            fmi3DoStep(unit, k * 1e-3, 1e-3, false, &event, &end, &early, &last) != 0) {
            return 1;
        }
    }
    fmi3GetFloat64(unit, &position, 1, &x, 1);
    printf("%.17g\\n", x);
    fmi3FreeInstance(unit);
    return 0;
}
"""


@needs_compiler
@pytest.mark.parametrize(
    "built", [pytest.param("plain", marks=pytest.mark.accept), "all"], indirect=True
)
def test_every_compiler_gives_the_same_motion_without_undefined_behaviour(
    built: Built, tmp_path: Path
) -> None:
    (tmp_path / "main.c").write_text(DRIVER.replace("TOKEN", ORIGIN.sha256))
    ends = []
    checks = ["-fsanitize=undefined,address", "-fno-sanitize-recover=all"]
    files = [*source_files(built.folder), str(tmp_path / "main.c")]
    ways = [(compiler, ["-O3"]) for compiler in COMPILERS]
    for compiler, options in [*ways, (COMPILERS[0], ["-O0"]), (COMPILERS[0], ["-O1", *checks])]:
        program = tmp_path / f"program{len(ends)}"
        subprocess.run([compiler, *STRICT, *options, *files, "-o", str(program), "-lm"], check=True)
        done = subprocess.run([program], capture_output=True, text=True, check=False)
        assert (done.returncode, done.stderr) == (0, "")
        ends.append(float(done.stdout))
    assert abs(ends[0]) > 1e-3
    assert ends == pytest.approx([ends[0]] * len(ends), abs=AGREES, rel=0.0)


@pytest.mark.skipif(shutil.which("cppcheck") is None, reason="there is no cppcheck on the PATH")
@pytest.mark.parametrize("built", ["plain", "all"], indirect=True)
def test_cppcheck_finds_nothing(built: Built) -> None:
    checks = [
        "--enable=all",
        "--inconclusive",
        "--suppress=missingIncludeSystem",
        "--suppress=unusedFunction",  # the importing tool calls the functions of FMI
        "--std=c99",
        "--quiet",
        "--error-exitcode=1",
    ]
    done = subprocess.run(
        ["cppcheck", *checks, *source_files(built.folder)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")


@needs_compiler
def test_fmpy_builds_the_unit(plain: Model, tmp_path: Path) -> None:
    build = pytest.importorskip("fmpy.build", reason="fmpy is not installed")
    if shutil.which("cmake") is None:
        pytest.skip("cmake is not on the PATH")
    (content,) = axis_fmu(plain, ORIGIN, ())[0].values()
    (tmp_path / "unit.fmu").write_bytes(content)
    zipfile.ZipFile(tmp_path / "unit.fmu").extractall(tmp_path / "unit")
    (tmp_path / "build").mkdir()
    build.build_platform_binary(tmp_path / "unit", tmp_path / "build")
    assert len(list((tmp_path / "unit/binaries").rglob("*.so"))) == 1


def test_description_is_that_of_the_folder(plain: Model, tmp_path: Path) -> None:
    """The identified values are the starts, and the descriptions state the intervals."""
    for case in ("plain", "all"):
        (content,) = axis_fmu(CASES[case](plain), ORIGIN, ())[0].values()
        (tmp_path / "unit.fmu").write_bytes(content)
        with zipfile.ZipFile(tmp_path / "unit.fmu") as archive:
            text = archive.read("modelDescription.xml").decode()
        assert text == (GOLDEN / f"axis_{case}.xml").read_text()
