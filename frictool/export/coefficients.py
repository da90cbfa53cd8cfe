"""Coefficients with their sign conventions, as JSON and as variables of a MATLAB file."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from typing import Any

import msgspec
import numpy as np

from frictool import __version__
from frictool.adapters.controller_composition import controller_program
from frictool.control.coefficient_words import BITS, coefficient
from frictool.control.program import Program, ProgramNode
from frictool.documents.controller import Controller, Number
from frictool.documents.observer import Observer
from frictool.documents.quantity import si_unit
from frictool.export.c_identifier import c_identifier
from frictool.export.c_names import CNames, NamedArray
from frictool.export.encoder_reading import reading_notes
from frictool.export.encoder_wrap import encoder_wrap
from frictool.export.export_origin import ExportOrigin
from frictool.export.rounded_loop import RoundedLoop
from frictool.logs.arrays.mat_writer import Value, pieces
from frictool.verify.coefficient_rounding import coefficient_rounder, rounded_linear

FORMAT = "coefficients/1"
CONVENTIONS = {
    "a": (
        "x[k+1] = a x[k] + b e[k] + l (limited drive - drive), drive = c x[k] + d e[k]: no "
        "sign is reversed; matrices in rows"
    ),
    "sos": (
        "rows b0 b1 b2 a0 a1 a2, a0 = 1, H = (b0 + b1/z + b2/z^2)/(1 + a1/z + a2/z^2): a1 "
        "and a2 are subtracted"
    ),
    "drive": "a positive drive moves the axis forward",
    "delay": (
        "the loop was verified for a drive that acts delay_samples samples after the "
        "position was sampled"
    ),
    "units": "SI: s, rad or m, A or V",
    "not_contained": (
        "the order of the operations, the drive's limit with its anti-windup, the modes of the "
        "band, and the guard that holds the last valid inputs for measurement_hold_samples "
        "samples and then sets the drive to 0. Without this guard a NaN stays in the states. "
        "frictool export --lang c exports all these parts"
    ),
}
BLOCKS = (
    "position_law",
    "prefilter",
    "profile",
    "feedforward",
    "velocity",
    "limiter",
    "friction_compensation",
    "schedule",
)


def json_files(
    controller: Controller, number: Number, loop: RoundedLoop, origin: ExportOrigin
) -> dict[str, str]:
    """Return the JSON file (text by name); docs/formats.md defines every key."""
    content = {
        "format": FORMAT,
        "name": controller.name,
        "number": number,
        "sha256": origin.sha256,
        "provenance": {"command": origin.command, "frictool": __version__},
        "conventions": _conventions(controller) | {"e": _entering(controller)},
        "axis": controller.axis,
        "structure": controller.structure,
        "drive": controller.drive,
        "units": {
            "position": si_unit("position", controller.axis),
            "drive": si_unit(controller.drive, controller.axis),
        },
        "sample_period_s": controller.sample_period_s,
        "delay_samples": controller.delay_samples,
        "drive_limit": controller.drive_limit,
        "measurement_hold_samples": controller.measurement_hold_samples,
        "linear": _linear(controller, number),
        "blocks": {
            name: _whole(block)
            for name in BLOCKS
            if (block := getattr(controller, name)) is not None
        },
        "program": _program(controller_program(controller), number),
        "rounded": {
            "modulus_margin": loop.modulus_margin,
            "at": loop.at,
            "norm": loop.norm,
            "norm_at": loop.norm_at or None,
        },
    }
    return {
        f"{c_identifier(controller.name)}.json": json.dumps(
            content, indent=1, ensure_ascii=False, allow_nan=False
        )
        + "\n"
    }


def _conventions(controller: Controller) -> dict[str, str]:
    wrap = encoder_wrap(controller)
    wraps = {} if wrap is None else {"wraps": wrap.requirement}
    return CONVENTIONS | wraps | reading_notes(controller)


def _whole(block: Any) -> Any:
    if isinstance(block, Observer):
        return _observer(block)
    if isinstance(block, msgspec.Struct):
        return {key: _whole(value) for key, value in msgspec.structs.asdict(block).items()}
    return [_whole(one) for one in block] if isinstance(block, tuple) else block


def _observer(observer: Observer) -> dict[str, Any]:
    record = {
        key: _whole(getattr(observer, key)) for key in ("sample_period_s", "inertia", "friction")
    }
    return record | {
        "kind": observer.kind,
        **_whole(observer.tracking if observer.switched is None else observer.switched),
    }


def _entering(controller: Controller) -> str:
    if controller.structure == "position":
        return "filtered reference - position"
    return (
        "integral(speed reference) - position"
        if controller.linear.input == "eta"
        else "speed reference - speed"
    )


def _linear(controller: Controller, number: Number) -> dict[str, Any]:
    linear = rounded_linear(controller.linear, number)
    space = linear.discrete
    return {
        "input": "error" if controller.structure == "position" else linear.input,
        "form": linear.form,
        "a": space.a,
        "b": [row[0] for row in space.b],
        "c": space.c[0],
        "d": space.d[0][0],
        "anti_windup": linear.anti_windup,
        "sos": linear.sos,
        "sos_anti_windup": linear.sos_anti_windup,
        "conditional": linear.conditional,
    }


def _program(program: Program, number: Number) -> dict[str, Any]:
    """Return every named coefficient of the program, by its name in the exported C.

    In fixed point, each coefficient also has its integer and its number of fraction bits.
    """
    tables = CNames(program).constants
    hold = coefficient_rounder(number)
    record: dict[str, Any] = {
        "coefficients": {
            table.name: _nested(table, lambda node: hold(node.value), 0.0) for table in tables
        }
    }
    if number in BITS:
        bits = BITS[number]
        record["words"] = {
            table.name: _nested(table, lambda node: coefficient(node.value, bits)[0], 0)
            for table in tables
        }
        record["fractions"] = {
            table.name: _nested(table, lambda node: coefficient(node.value, bits)[1], 0)
            for table in tables
        }
    record["states"] = {
        name: {
            "low": node.low if math.isfinite(node.low) else None,
            "high": node.high if math.isfinite(node.high) else None,
            "start": program.starts.get(node.index, node.value),
            "set_by_caller": node.index not in program.updates,
        }
        for name, node in program.states.items()
    }
    return record


def _nested(table: NamedArray, value: Callable[[ProgramNode], float], nothing: float) -> Any:
    shape = table.shape
    if not shape:
        return value(table.nodes[()])
    flat = [nothing if node is None else value(node) for _, node in table.elements()]
    if len(shape) == 1:
        return flat
    return [flat[k : k + shape[1]] for k in range(0, len(flat), shape[1])]


def matlab_files(
    controller: Controller, number: Number, loop: RoundedLoop, origin: ExportOrigin
) -> dict[str, bytes]:
    """Return the MATLAB file (bytes by name), version 5; docs/formats.md lists the variables."""
    linear = rounded_linear(controller.linear, number)
    space = linear.discrete
    n = linear.order
    values: dict[str, Value] = {
        "a": np.array(space.a, dtype=np.float64).reshape(n, n),
        "b": np.array(space.b, dtype=np.float64).reshape(n, 1),
        "c": np.array(space.c, dtype=np.float64).reshape(1, n),
        "d": np.array(space.d, dtype=np.float64).reshape(1, 1),
        "l": np.array(linear.anti_windup, dtype=np.float64).reshape(n, 1),
        "sos": np.array(linear.sos, dtype=np.float64).reshape(len(linear.sos), 6),
        "Ts": np.array([[controller.sample_period_s]]),
        "delay_samples": np.array([[float(controller.delay_samples)]]),
        "drive_limit": np.array([[controller.drive_limit]]),
        "measurement_hold_samples": np.array([[float(controller.measurement_hold_samples)]]),
        "modulus_margin": np.array([[loop.modulus_margin]]),
        "names": {
            "input": _entering(controller),
            "output": controller.drive,
            "controller": controller.name,
            "structure": controller.structure,
        },
        "units": {
            "position": si_unit("position", controller.axis),
            "drive": si_unit(controller.drive, controller.axis),
        },
        "conventions": _conventions(controller),
        "notes": {
            "sha256": origin.sha256,
            "command": origin.command,
            "frictool": __version__,
            "number": number,
        },
    }
    for name, key in (
        ("prefilter", "prefilter"),
        ("profile", "profile"),
        ("feedforward", "feedforward"),
        ("law", "position_law"),
        ("velocity", "velocity"),
        ("limiter", "limiter"),
    ):
        block = getattr(controller, key)
        if block is not None:
            values[name] = _variable(_whole(block))
    if controller.friction_compensation is not None:
        values["compensation"] = _variable(_whole(controller.friction_compensation))
    return {f"{c_identifier(controller.name)}.mat": b"".join(pieces(values))}


def _variable(block: dict[str, Any]) -> Value:
    return {
        key: np.array([[float(value)]]) if isinstance(value, int | float) else str(value)
        for key, value in block.items()
        if value is not None and not isinstance(value, dict)
    }
