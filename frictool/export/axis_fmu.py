"""Identified axis as a Functional Mock-up Unit, whose C code simulates the axis event by event.

    command ──▶ limit, lag, constant ──▶ inertia, friction, backlash, end stops ──▶ encoder

The C code has the parameters of frictool's simulation (plant/axis.py, plant/axis_friction_laws.py,
plant/position_load.py). Each parameter of the model is a parameter of the Functional Mock-up Unit,
with its interval in the description.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from itertools import chain

import numpy as np

from frictool.adapters.axis_model import axis_of, load_of
from frictool.documents.laws import Load, Ripple
from frictool.documents.model import Model
from frictool.documents.quantity import Quantity, drive_dimension, si_unit
from frictool.engine.closed_loop import PARTS
from frictool.export.c_identifier import c_identifier
from frictool.export.export_origin import ExportOrigin
from frictool.export.fmi_unit import FmiUnit, FmiVariable, functions_text
from frictool.export.model_features import FEATURES, without_features
from frictool.friction.position_polynomial import normalised_coefficients
from frictool.plant import axis as ax
from frictool.plant import axis_friction_laws as al
from frictool.plant.position_load import TERM_SIZE, LoadHarmonic, with_load

HELD = frozenset(FEATURES) - {"presliding", "resonances"}
STIFFNESS, HARMONICS = al.EXTENDED_SIZE, al.EXTENDED_SIZE + 1
PLAIN = (
    "INERTIA OFFSET CONSTANT LAG DRIVE_LIMIT BACKLASH BACKLASH_COULOMB BACKLASH_BREAKAWAY "
    "ENCODER_STEP RESISTANCE SUPPLY"
)
LAWS = (
    "RESTITUTION STRIBECK_VELOCITY STRIBECK_EXPONENT LAYER FRESH RISE_TIME MAPPED MAP_LOW MAP_HIGH "
    "REGIMES COULOMB_MAPS BREAKAWAY_MAPS"
)
PAIRS = "VISCOUS COULOMB BREAKAWAY STOP"  # one value for each direction
INDICES = {  # in the simulation's array of parameters
    **{name: getattr(ax, name) for name in PLAIN.split()},
    **{name: getattr(al, f"{name}_PAIR") for name in PAIRS.split()},
    **{name: getattr(al, name) for name in LAWS.split()},
    "STIFFNESS": STIFFNESS,
    "HARMONICS": HARMONICS,
}
FIRST_PARAMETER = 16  # value reference of the parameter with index 0
REFERENCES = {
    "command": 1,
    "position": 2,
    "velocity": 3,
    "drive": 4,
    "measured_position": 5,
    "load_position": 6,
    "mode": 7,
    "events": 8,
    "last_event": 9,
}
MODES = {
    "stuck": 0,
    "slipping_forward": 1,
    "slipping_backward": -1,
    "inside_backlash_forward": 2,
    "inside_backlash_backward": -2,
}
EVENTS = {"none": 0, "breakaway": 1, "stop": 2, "contact": 3, "end_stop": 4}
NO_HARMONIC = LoadHarmonic(0.0, 0.0, 0.0)
SMALLEST = sys.float_info.min  # smallest value of a parameter that must be above 0
LARGEST = sys.float_info.max
FINITE = (-LARGEST, LARGEST)
POSITIVE = (SMALLEST, LARGEST)


@dataclass(frozen=True)
class AxisSetting:
    """Parameter of the Functional Mock-up Unit.

    - name: name of the variable
    - index: index in the array of parameters
    - unit: SI unit; empty for a ratio
    - text: meaning, for the description
    - least, most: smallest and largest allowed value
    - tunable: True if the parameter may change during a simulation
    - quantity: value and interval in the model document; the description states the interval
    """

    name: str
    index: int
    unit: str
    text: str
    least: float = 0.0
    most: float = LARGEST
    tunable: bool = True
    quantity: Quantity | None = None


def axis_fmu(
    model: Model, origin: ExportOrigin, without: Collection[str]
) -> tuple[dict[str, bytes], list[str]]:
    """Return the files (contents by name) of a model's Functional Mock-up Unit, and notes.

    Raises NoSolutionError if the model has a feature that an FMU cannot represent and that is not
    in `without`.
    """
    model, notes = without_features(model, "the FMU", HELD, without)
    starts = _starts(model)
    settings = list(_settings(model, len(starts) - 1))
    variables = (*_signals(model, len(starts) - 1), *_parameters(model, settings, starts))
    references = {
        name: reference
        for name, reference in REFERENCES.items()
        if name != "load_position" or _has_backlash(model)
    }
    functions = functions_text(
        "fmi3_axis.c.jinja",
        origin,
        ["GetInt64"],
        document="the model",
        id=c_identifier(model.name),
        name=model.name,
        regimes=al.MAX_REGIMES,
        terms=al.MAX_TERMS,
        harmonics=(len(starts) - 2 - HARMONICS) // TERM_SIZE,
        indices={**INDICES, "LOADED": len(starts) - 2, "START_POSITION": len(starts) - 1},
        starts=starts,
        settings=settings,
        references=references,
        first_parameter=FIRST_PARAMETER,
        part=repr(model.bench.sample_period_s / PARTS),
    )
    unit = FmiUnit(
        model.name,
        "model",
        origin,
        model.bench.sample_period_s,
        variables,
        functions,
        enumerations={"Mode": MODES, "Event": EVENTS},
    )
    return unit.files(), [*notes, _summary(model, settings)]


def _summary(model: Model, settings: list[AxisSetting]) -> str:
    names = ", ".join(one.name for one in settings)
    return f"{len(settings)} parameters: {names}"


def _has_backlash(model: Model) -> bool:
    return FEATURES["backlash"].present(model)


def _starts(model: Model) -> list[float]:
    axis, load = axis_of(model), load_of(model)
    harmonics = load.harmonics or (NO_HARMONIC,)
    out = with_load(axis.as_array(), np.array([load.stiffness, *chain.from_iterable(harmonics)]))
    shape = axis.laws.shape
    if shape is not None:
        for row, terms in enumerate((*reversed(shape.coulomb), *reversed(shape.breakaway))):
            factors = normalised_coefficients(terms, shape.low, shape.high)
            first = al.COULOMB_MAPS + al.MAX_TERMS * row
            out[first : first + len(factors)] = factors
    return [*map(float, out), 0.0, 0.0]


def _settings(model: Model, start_position: int) -> Iterator[AxisSetting]:
    bench, today, kind = model.bench, model.parameters, model.axis
    actuator, mechanics = bench.actuator, bench.mechanics
    effort, position = si_unit("effort", kind), si_unit("position", kind)
    drive = si_unit(actuator.drive, kind)
    constant = si_unit(drive_dimension(actuator.drive, constant=True), kind)
    yield AxisSetting(
        "inertia",
        ax.INERTIA,
        si_unit("inertia", kind),
        "inertia reflected to the actuator",
        *POSITIVE,
        quantity=today.inertia,
    )
    yield from _levels(model)
    yield AxisSetting(
        "offset",
        ax.OFFSET,
        effort,
        "constant effort that opposes a positive drive",
        *FINITE,
        quantity=today.offset,
    )
    yield AxisSetting(
        "constant",
        ax.CONSTANT,
        constant,
        "effort per unit of the drive",
        *POSITIVE,
        quantity=actuator.constant,
    )
    yield AxisSetting("lag", ax.LAG, "s", "time constant of the drive's loop")
    yield AxisSetting(
        "drive_limit", ax.DRIVE_LIMIT, drive, "largest magnitude of the drive", *POSITIVE
    )
    yield AxisSetting(
        "encoder_step", ax.ENCODER_STEP, position, "size of an encoder count; 0: no quantisation"
    )
    if actuator.winding is not None:
        yield AxisSetting("resistance", ax.RESISTANCE, "ohm", "resistance of the winding")
        yield AxisSetting("supply", ax.SUPPLY, "V", "voltage of the winding's supply", *POSITIVE)
    if _has_backlash(model):
        yield AxisSetting(
            "backlash",
            ax.BACKLASH,
            position,
            "full width of the backlash",
            tunable=False,
            quantity=mechanics.backlash,
        )
        yield AxisSetting(
            "backlash_coulomb",
            ax.BACKLASH_COULOMB,
            effort,
            "Coulomb friction inside the backlash",
            quantity=mechanics.backlash_coulomb,
        )
        yield AxisSetting(
            "backlash_breakaway", ax.BACKLASH_BREAKAWAY, effort, "breakaway inside the backlash"
        )
    yield from _law_settings(model)
    yield from _load_settings(model)
    yield AxisSetting(
        "start_position",
        start_position,
        position,
        "position at the start",
        *FINITE,
        tunable=False,
    )


def _levels(model: Model) -> Iterator[AxisSetting]:
    texts = {
        "viscous": ("viscous", al.VISCOUS_PAIR, "viscous friction"),
        "coulomb": ("effort", al.COULOMB_PAIR, "Coulomb friction"),
        "breakaway": ("effort", al.BREAKAWAY_PAIR, "breakaway after a long rest"),
    }
    backward = model.laws.backward if model.laws else None
    for name, (dimension, index, text) in texts.items():
        unit = si_unit(dimension, model.axis)
        forward = getattr(model.parameters, name)
        opposite = getattr(backward, name, None) or forward
        for side, quantity in ((1, forward), (0, opposite)):
            direction = ("backward", "forward")[side]
            yield AxisSetting(
                f"{name}_{direction}",
                index + side,
                unit,
                f"{text}, {('negative', 'positive')[side]} direction",
                quantity=quantity,
            )


def _law_settings(model: Model) -> Iterator[AxisSetting]:
    laws, velocity = model.laws, model.parameters.stribeck_velocity
    for number, regime in enumerate(laws.regimes if laws else (), start=1):
        for side, quantity in ((1, regime.viscous), (0, regime.backward or regime.viscous)):
            yield AxisSetting(
                f"viscous_{('backward', 'forward')[side]}_{number}",
                al.REGIMES + al.REGIME_SIZE * (number - 1) + 1 + side,
                si_unit("viscous", model.axis),
                f"viscous friction above {regime.above.value:g} {si_unit('velocity', model.axis)}, "
                f"{('negative', 'positive')[side]} direction",
                quantity=quantity,
            )
    if velocity is not None:
        yield AxisSetting(
            "stribeck_velocity",
            al.STRIBECK_VELOCITY,
            si_unit("velocity", model.axis),
            "speed scale of the fall from the breakaway to the Coulomb friction",
            quantity=velocity,
        )
        yield AxisSetting(
            "stribeck_exponent",
            al.STRIBECK_EXPONENT,
            "",
            "exponent of the Stribeck curve",
            0.5,
            4.5,
        )
    if laws is not None and laws.dwell is not None:
        yield AxisSetting(
            "fresh",
            al.FRESH,
            "",
            "breakaway just after a stop, divided by the breakaway after a long rest",
            SMALLEST,
            1.0,
        )
        yield AxisSetting(
            "rise_time", al.RISE_TIME, "s", "time at rest until half of the rise of the breakaway"
        )
    if model.bench.mechanics.travel is not None:
        unit = si_unit("position", model.axis)
        yield AxisSetting("stop_low", al.STOP_PAIR, unit, "lower end stop", *FINITE)
        yield AxisSetting("stop_high", al.STOP_PAIR + 1, unit, "upper end stop", *FINITE)
        yield AxisSetting(
            "restitution",
            al.RESTITUTION,
            "",
            "speed after an impact on an end stop, relative to the speed before",
            0.0,
            math.nextafter(1.0, 0.0),
        )


def _load_settings(model: Model) -> Iterator[AxisSetting]:
    load = (model.laws.load if model.laws else None) or Load()
    effort = si_unit("effort", model.axis)
    if load.stiffness is not None:
        yield AxisSetting(
            "stiffness",
            STIFFNESS,
            si_unit("stiffness", model.axis),
            "stiffness of the spring load",
            quantity=load.stiffness,
        )
    gravity = [] if load.gravity is None else [("gravity", load.gravity)]
    ripples = [(f"ripple_{number}", one) for number, one in enumerate(load.ripples, start=1)]
    for row, (name, harmonic) in enumerate([*gravity, *ripples]):
        text = (
            f"ripple load with {harmonic.cycles:g} periods in {harmonic.per.value:.6g} "
            f"{si_unit('position', model.axis)}"
            if isinstance(harmonic, Ripple)
            else "gravity load"
        )
        for column, word in ((1, "sine"), (2, "cosine")):
            yield AxisSetting(
                f"{name}_{word}",
                HARMONICS + TERM_SIZE * row + column,
                effort,
                f"{text}, {word}",
                *FINITE,
                quantity=getattr(harmonic, word),
            )


def _signals(model: Model, start_position: int) -> Iterator[FmiVariable]:
    position, velocity = si_unit("position", model.axis), si_unit("velocity", model.axis)
    drive = si_unit(model.bench.actuator.drive, model.axis)
    time = {"name": "time", "causality": "independent", "unit": "s", "variability": "continuous"}
    yield FmiVariable(0, "Float64", time)
    command = {"name": "command", "causality": "input", "start": "0.0", "unit": drive}
    command |= {"variability": "discrete"}
    held = "command of the drive, constant in a communication step"
    yield FmiVariable(REFERENCES["command"], "Float64", {**command, "description": held})
    at_start = (FIRST_PARAMETER + start_position,)
    measured = (*at_start, FIRST_PARAMETER + ax.ENCODER_STEP)
    texts = {
        "position": ("continuous", position, "position of the motor", at_start),
        "velocity": ("continuous", velocity, "velocity of the motor", None),
        "drive": ("continuous", drive, "drive that acts at the end of the step", None),
        "measured_position": (
            "discrete",
            position,
            "encoder counts times the size of a count",
            measured,
        ),
    }
    if _has_backlash(model):
        texts["load_position"] = ("continuous", position, "position behind the backlash", at_start)
    for name, (variability, unit, text, depends_on) in texts.items():
        yield FmiVariable(
            REFERENCES[name],
            "Float64",
            {
                "name": name,
                "causality": "output",
                "variability": variability,
                **_initial(depends_on),
                "unit": unit,
                "description": text,
            },
            depends_on or (),
        )
    counted = {"causality": "output", "variability": "discrete", "initial": "exact", "start": "0"}
    yield FmiVariable(
        REFERENCES["mode"],
        "Enumeration",
        {"name": "mode", "declaredType": "Mode", **counted, "description": "mode of the motion"},
    )
    yield FmiVariable(
        REFERENCES["events"],
        "Int64",
        {"name": "events", **counted, "description": "number of events since the start"},
    )
    yield FmiVariable(
        REFERENCES["last_event"],
        "Enumeration",
        {"name": "last_event", "declaredType": "Event", **counted, "description": "last event"},
    )


def _initial(depends_on: tuple[int, ...] | None) -> dict[str, str]:
    if depends_on is None:
        return {"initial": "exact", "start": "0.0"}
    return {"initial": "calculated"}


def _parameters(
    model: Model, settings: list[AxisSetting], starts: list[float]
) -> Iterator[FmiVariable]:
    for one in settings:
        words = {
            "name": one.name,
            "causality": "parameter",
            "variability": "tunable" if one.tunable else "fixed",
            "initial": "exact",
            "start": repr(starts[one.index]),
            **({"unit": one.unit} if one.unit else {}),
            **({"min": repr(one.least)} if one.least > -LARGEST else {}),
            **({"max": repr(one.most)} if one.most < LARGEST else {}),
            "description": one.text + _interval(one.quantity, model),
        }
        yield FmiVariable(FIRST_PARAMETER + one.index, "Float64", words)


def _interval(quantity: Quantity | None, model: Model) -> str:
    if quantity is None or quantity.interval[0] == quantity.interval[1]:
        return ""
    low, high = quantity.interval
    identified = getattr(quantity, "source", None) == "identified"
    confidence = f", confidence {model.confidence:g}" if identified else ""
    return f"; interval {low:.6g} to {high:.6g}{confidence}"
