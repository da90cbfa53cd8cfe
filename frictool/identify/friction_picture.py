"""SVG picture of the identified friction over speed, over position, and over both.

- over speed: mean |effort| of the middle of each stroke over its mean speed, and the law (figures
  4.9, 4.10). If friction depends on position, the deviation of each stroke's positions from the
  mean friction is subtracted. A stroke whose speeds lie on both sides of a knee appears above the
  law at its mean speed.
- over position, with ramps: each breakaway, and the polynomials with the intervals of their levels
  (figure 4.12)
- over both, if friction depends on position and strokes give its level: friction in slip (figure
  4.13)
"""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from frictool.documents.model import Model
from frictool.documents.quantity import si_unit
from frictool.friction.speed_regimes import knee_force, regimes_from
from frictool.identify.axis_logs import RAMP_LOG, without_load
from frictool.identify.breakaway.breakaway import Breakaway
from frictool.identify.breakaway.friction_map import shape_along
from frictool.identify.estimators.sines import StrokeRows, stroke_rows
from frictool.identify.fit_result import UnusableLogs
from frictool.identify.from_logs import IdentifiedModel
from frictool.presentation.svg import drawing, render
from frictool.typing import Vector

FORWARD, BACKWARD = "#1f5fa8", "#c0392b"
SIDES = ((1.0, FORWARD, "forward"), (-1.0, BACKWARD, "backward"))
WIDTH, HEIGHT = 7.0, 3.2  # inches, size of each axes
# points of a curve, colour levels, and most intervals of the colour scale
POINTS, LEVELS, TICKS = (201, 15, 8)
REACH = 1.1  # largest speed drawn, relative to the mean speed of the fastest stroke


def picture_of(outcome: IdentifiedModel) -> str:
    """Return the picture of strokes that can be averaged, of breakaways, and of the laws."""
    model, result = outcome.model, outcome.result
    sliding = [record for record in outcome.records if result.kinds[record.name] != RAMP_LOG]
    if result.laws is not None:
        sliding = [without_load(record, result.laws) for record in sliding]
    try:
        rows = stroke_rows(sliding, model.bench)
    except UnusableLogs:
        rows = None  # no stroke is long enough: only the law is drawn
    return picture(model, rows, result.ramp)


def picture(model: Model, rows: StrokeRows | None, ramp: Breakaway | None) -> str:
    """Return the `<svg>` element; equal identifications give identical bytes."""
    mapped = (
        model.laws is not None
        and model.laws.position is not None
        and model.parameters.coulomb.source == "identified"
    )
    with drawing("identify"):
        count = 1 + (ramp is not None) + mapped
        figure = Figure(figsize=(WIDTH, HEIGHT * count), layout="constrained")
        axes = iter(figure.subplots(count, 1, squeeze=False)[:, 0])
        _over_speed(next(axes), model, rows, ramp)
        if ramp is not None:
            _over_position(next(axes), model, ramp)
        if mapped:
            _over_both(figure, next(axes), model, rows)
        return render(figure, f"{model.name}: friction over speed and position")


def friction_over_speed(model: Model, speed: Vector, direction: float) -> Vector:
    """Return the mean friction in slip (n,), N m | N, at speeds (n,) >= 0 in a direction (+-1).

    The Stribeck fall at low speeds is left out.
    """
    today, laws = model.parameters, model.laws
    backward = None if laws is None or direction > 0.0 else laws.backward
    coulomb = (backward.coulomb if backward is not None else None) or today.coulomb
    first = (backward.viscous if backward is not None else None) or today.viscous
    knees = []
    before = first.value
    for regime in () if laws is None else laws.regimes:
        slope = ((regime.backward if direction < 0.0 else None) or regime.viscous).value
        knees.append((regime.above.value, slope - before))
        before = slope
    kinks = regimes_from(knees)
    return np.asarray(
        coulomb.value
        + first.value * speed
        + np.array([knee_force(float(v), kinks) for v in speed]),
        dtype=np.float64,
    )


def _fastest(model: Model, rows: StrokeRows | None) -> float:
    """Return the largest speed of the pictures, rad/s | m/s."""
    if rows is not None:
        return REACH * float(rows.means.mean(rows.means.speed).max())
    top = model.bench.mechanics.top_speed
    return top.value if top is not None else 1.0


def _over_speed(ax: Axes, model: Model, rows: StrokeRows | None, ramp: Breakaway | None) -> None:
    speed = np.linspace(0.0, _fastest(model, rows), POINTS)
    effort = si_unit("effort", model.axis)
    velocity = si_unit("velocity", model.axis)
    for side, colour, name in SIDES:
        ax.plot(
            speed, friction_over_speed(model, speed, side), color=colour, linewidth=1.2, label=name
        )
        if rows is not None:
            chosen = rows.means.sign == side
            inertial = (
                model.parameters.inertia.value * rows.acceleration + model.parameters.offset.value
            )
            measured = side * (rows.means.effort - inertial) - _excess_over_mean(
                model, rows, ramp, side
            )
            ax.plot(
                rows.means.mean(rows.means.speed)[chosen],
                measured[chosen],
                "x",
                color=colour,
                markersize=4,
                alpha=0.6,
            )
    ax.set_xlabel(f"speed, {velocity}")
    ax.set_ylabel(f"friction in slip, {effort}")
    ax.set_ylim(bottom=0.0)
    ax.grid(True)
    ax.legend(loc="lower right")


def _excess_over_mean(
    model: Model, rows: StrokeRows, ramp: Breakaway | None, side: float
) -> Vector | float:
    """Return the excess (m,) of friction at each stroke's positions over the mean of the travel."""
    if (
        ramp is None
        or ramp.by_position is None
        or model.laws is None
        or model.laws.position is None
    ):
        return 0.0
    level = float(friction_over_speed(model, np.zeros(1), side)[0])
    return level * (rows.means.mean(shape_along(rows, ramp.by_position)) - 1.0)


def _over_position(ax: Axes, model: Model, ramp: Breakaway) -> None:
    law = ramp.by_position
    for index, (side, colour, name) in enumerate(SIDES):
        chosen = ramp.direction == side
        ax.plot(
            ramp.position[chosen],
            ramp.friction[chosen],
            "x",
            color=colour,
            markersize=4,
            label=f"breakaways {name}",
        )
        if law is None:
            level = ramp.interval
            curve = np.ones(2)
            x = np.array([ramp.position.min(), ramp.position.max()])
            curve = level.value * curve
        else:
            level = (law.forward, law.backward)[index]
            x = np.linspace(law.low, law.high, POINTS)
            curve = np.polynomial.polynomial.polyval(x, np.array(law.powers[index]))
        ax.plot(x, curve, color=colour, linewidth=1.2)
        ax.fill_between(
            x,
            curve * level.low / level.value,
            curve * level.high / level.value,
            color=colour,
            alpha=0.25,
            linewidth=0.0,
        )
    ax.set_xlabel(f"position, {si_unit('position', model.axis)}")
    ax.set_ylabel(f"breakaway, {si_unit('effort', model.axis)}")
    ax.set_ylim(bottom=0.0)
    ax.grid(True)
    ax.legend(loc="lower right")


def _over_both(figure: Figure, ax: Axes, model: Model, rows: StrokeRows | None) -> None:
    """Draw friction in slip over position and signed speed: speed level times position shape."""
    assert model.laws is not None
    assert model.laws.position is not None
    law = model.laws.position
    fastest = _fastest(model, rows)
    x = np.linspace(law.over.low, law.over.high, POINTS)
    speed = np.linspace(0.0, fastest, POINTS)
    parts = []
    for side, powers in (
        (-1.0, law.coulomb.backward or law.coulomb.forward),
        (1.0, law.coulomb.forward),
    ):
        curve = np.polynomial.polynomial.polyval(x, np.array(powers))
        level = friction_over_speed(model, speed, side)
        parts.append(level[0] * (curve / np.mean(curve))[None, :] + (level - level[0])[:, None])
    lowest, highest = min(part.min() for part in parts), max(part.max() for part in parts)
    colours = np.linspace(lowest, highest, LEVELS)
    drawn = [
        ax.contourf(x, side * speed, part, levels=colours)
        for side, part in zip((-1.0, 1.0), parts, strict=True)
    ]
    figure.colorbar(
        drawn[0],
        ax=ax,
        ticks=MaxNLocator(TICKS),
        label=f"friction in slip, {si_unit('effort', model.axis)}",
    )
    ax.set_xlabel(f"position, {si_unit('position', model.axis)}")
    ax.set_ylabel(f"velocity, {si_unit('velocity', model.axis)}")
