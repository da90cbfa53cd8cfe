"""Friction of a model as tables: over speed, over position, and for the compensation in drives.

    F(v) = F_c + (F_s - F_c) exp(-(v/v_s)^delta) + viscous(v)         (thesis 2.33 and 2.34)

F_c is the Coulomb friction, F_s the breakaway, v_s the Stribeck velocity and delta an exponent.
viscous(v) is piecewise linear (figure 4.10 of the thesis). The table against speed also contains
the lowest and the highest F(v) for all combinations of the parameters within their intervals. This
interval is wider than a confidence band of the curve.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence

import numpy as np

from frictool import __version__
from frictool.adapters.axis_model import load_law, load_of
from frictool.adapters.slip_curve import SlipCurve, bend_speeds, slip_curve
from frictool.documents.laws import Laws, Load, Ripple
from frictool.documents.model import Model
from frictool.documents.quantity import si_unit
from frictool.errors import NoSolutionError
from frictool.export.c_identifier import c_identifier
from frictool.export.export_origin import ExportOrigin
from frictool.export.model_features import FEATURES, without_features
from frictool.friction.position_polynomial import normalised_coefficients
from frictool.plant.position_load import PositionLoad
from frictool.typing import Vector

HELD = frozenset(FEATURES) - {"dwell", "presliding", "backlash", "resonances"}
SPEEDS, POSITIONS = 51, 101  # rows of the tables over speed and position
DRIVE_ROWS = 20  # largest number of rows of `frict_comp` (P-COMP-00062)
COGGING_ROWS, COGGING_LEVELS = 1024, 127  # number and largest value of the entries in moteus
NO_ODRIVE = "no ODrive map: ODrive measures its map itself, and publishes no way to load another"
WHOLE = 1e-9  # largest relative deviation of a number that is treated as whole


def table_files(
    model: Model, origin: ExportOrigin, without: Collection[str]
) -> tuple[Mapping[str, str | bytes], list[str]]:
    """Return the tables of a model (contents by file name), and notes.

    Raises NoSolutionError if the model has a feature that a table cannot represent, or no top
    speed.
    """
    model, notes = without_features(model, "a table", HELD, without)
    top = model.bench.mechanics.top_speed
    if top is None:
        raise NoSolutionError(
            f"{model.name}: the last speed of the table is missing; add mechanics.top_speed to "
            "the bench of the model"
        )
    name = c_identifier(model.name)
    sides = [slip_curve(model, forward=one) for one in (True, False)]
    head = (
        f"# {model.name}: {origin.command} (frictool {__version__}), model SHA-256 {origin.sha256}"
    )
    files: dict[str, str | bytes] = {
        f"{name}_friction.csv": _speed_table(model, sides, top.value, head)
    }
    position = _position_table(model, head)
    if position:
        files[f"{name}_position.csv"] = position
    if model.bench.actuator.drive == "current":
        text, note = _drive_table(model, sides, top.value, head)
        files[f"{name}_frict_comp.csv"] = text
        notes.append(note)
    else:
        notes.append("no frict_comp: it needs currents, but the drive is a voltage")
    ripples = model.laws.load.ripples if model.laws and model.laws.load else ()
    if ripples:
        cogging, note = _moteus_table(model, ripples)
        notes += [note, NO_ODRIVE]
        if cogging:
            files[f"{name}_moteus.cfg"] = cogging
    return files, notes


def _csv(head: str, columns: Mapping[str, Vector]) -> str:
    rows = zip(*columns.values(), strict=True)
    lines = [head, ",".join(columns), *(",".join(f"{x:.9g}" for x in row) for row in rows)]
    return "\n".join(lines) + "\n"


def _speed_table(model: Model, sides: list[SlipCurve], top: float, head: str) -> str:
    speed = _speeds(sides, top, SPEEDS)
    effort = si_unit("effort", model.axis)
    columns = {f"speed [{si_unit('velocity', model.axis)}]": speed}
    for name, side in zip(("forward", "backward"), sides, strict=True):
        low, high = side.band(speed)
        columns |= {
            f"{name} [{effort}]": side.friction(speed),
            f"{name} low [{effort}]": low,
            f"{name} high [{effort}]": high,
        }
    return _csv(head, columns)


def _speeds(sides: list[SlipCurve], top: float, number: int) -> Vector:
    inside = [speed for side in sides for speed in bend_speeds(side) if speed < top]
    return np.unique(np.concatenate((np.linspace(0.0, top, number), inside)))


def _position_table(model: Model, head: str) -> str | None:
    laws = model.laws or Laws()
    law = laws.position
    load = load_of(model)
    if law is None and load == PositionLoad():
        return None
    travel = model.bench.mechanics.travel
    ripples = laws.load.ripples if laws.load else ()
    if law is not None:
        ends = (law.over.low, law.over.high)
    elif travel is not None:
        ends = (travel.low, travel.high)
    else:
        ends = (0.0, ripples[0].per.value if ripples else 2.0 * math.pi)
    effort = si_unit("effort", model.axis)
    position = np.linspace(*ends, POSITIONS)
    columns = {f"position [{si_unit('position', model.axis)}]": position}
    if law is not None:
        for side in ("forward", "backward"):
            levels = slip_curve(model, forward=side == "forward")
            for key, curve in (("coulomb", law.coulomb), ("breakaway", law.breakaway)):
                powers = curve or law.coulomb
                shape = normalised_coefficients(
                    getattr(powers, side) or powers.forward, law.over.low, law.over.high
                )
                factor = np.polynomial.polynomial.polyval(position, np.asarray(shape))
                columns[f"{key} {side} [{effort}]"] = getattr(levels, key).value * factor
    if load != PositionLoad():
        columns[f"load [{effort}]"] = load.at(position)
    return _csv(head, columns)


def _drive_table(model: Model, sides: list[SlipCurve], top: float, head: str) -> tuple[str, str]:
    """Return a CSV table of currents that balance the friction, and a note on its accuracy.

    The table has up to 20 speeds. The drive uses the table for both directions, so that the table
    contains the mean of their friction. Rows are added where the straight line between two rows is
    farthest from the friction.
    """
    speed = _speeds(sides, top, 1001)
    friction = np.mean([side.friction(speed) for side in sides], axis=0)
    kept = [0, speed.size - 1]
    while True:
        error = np.abs(np.interp(speed, speed[kept], friction[kept]) - friction)
        worst = int(np.argmax(error))
        if len(kept) == DRIVE_ROWS or error[worst] <= 1e-6 * float(friction.max()):
            break
        kept = sorted([*kept, worst])
    constant, unit = model.bench.actuator.constant.value, si_unit("effort", model.axis)
    columns = {
        f"speed [{si_unit('velocity', model.axis)}]": speed[kept],
        f"current [{si_unit('current', model.axis)}]": friction[kept] / constant,
        f"friction [{unit}]": friction[kept],
    }
    apart = float(np.max(np.abs(np.subtract(*(side.friction(speed) for side in sides)))))
    note = (
        f"frict_comp: {len(kept)} rows, interpolation error at most {error[worst]:.3g} {unit}"
        + (f"; the directions differ by up to {apart:.3g} {unit}" if apart > 0.0 else "")
    )
    return _csv(head, columns), note


def _moteus_table(model: Model, ripples: Sequence[Ripple]) -> tuple[str | None, str]:
    if model.axis != "rotary" or model.bench.actuator.drive != "current":
        return None, "no moteus table: it needs a rotary axis with a current drive"
    for cycles in (2.0 * math.pi * one.cycles / one.per.value for one in ripples):
        if abs(cycles - round(cycles)) > WHOLE * cycles:
            return None, f"no moteus table: {cycles:.6g} cycles per turn; allowed: a whole number"
    angle = 2.0 * math.pi * np.arange(COGGING_ROWS) / COGGING_ROWS
    effort = load_law(Load(harmonics=tuple(ripples))).at(angle)
    current = effort / model.bench.actuator.constant.value
    scale = float(np.max(np.abs(current))) / COGGING_LEVELS
    if scale == 0.0:
        return None, "no moteus table: the ripple is 0"
    lines = [f"conf set motor.cogging_dq_scale {scale:.9g}"]
    lines += [
        f"conf set motor.cogging_dq_comp.{index} {round(value / scale)}"
        for index, value in enumerate(current)
    ]
    note = (
        f"moteus: {COGGING_ROWS} entries for one turn of the rotor, position 0 of the model at "
        f"entry 0, resolution {scale:.3g} A"
    )
    return "\n".join(lines) + "\n", note
