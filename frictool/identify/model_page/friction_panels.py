"""Panels of friction over speed, position and temperature.

- Over speed: every slipping sample, and the curve of the model with the interval of friction. If
  friction depends on position, this dependence is subtracted from the samples.
- Over position, if there are ramps: each breakaway, and for each direction the polynomial fitted to
  the breakaways. The interval of the polynomial's mean is drawn as a band.
- Over position and speed, if friction depends on position: friction of the model in slip.
- Over temperature, if friction depends on the temperature: factors of viscous and Coulomb friction.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.ticker import AutoLocator

from frictool.adapters.temperature_factors import temperature_factors
from frictool.documents.laws import FrictionOverTemperature
from frictool.documents.model import Model
from frictool.documents.quantity import Estimate, si_unit
from frictool.identify.breakaway.breakaway import Breakaway
from frictool.identify.model_page.evidence import SlipSamples, friction_over_speed
from frictool.identify.model_page.panel import BACKWARD, FORWARD, FigurePanel, scatter
from frictool.typing import Vector

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# the second curve is dashed, so that a curve below it stays visible
SIDES = ((1.0, FORWARD, "forward", "-"), (-1.0, BACKWARD, "backward", (0, (4, 2))))
POINTS = 201  # number of points of a curve
LEVELS = 15  # number of colours of the map
REACH = 1.05  # largest speed of a curve, relative to the fastest sample
MARGIN = 0.03  # margin of a plot around the data, relative to the range of the data


def friction_panels(
    model: Model, samples: SlipSamples | None, ramp: Breakaway | None
) -> list[FigurePanel]:
    """Return the friction panels for which model, samples and ramps contain data."""
    laws = model.laws
    mapped = (
        laws is not None
        and laws.position is not None
        and model.parameters.coulomb.source == "identified"
    )
    panels = [_over_speed(model, samples)]
    if ramp is not None:
        panels.append(_over_position(model, ramp))
    if mapped:
        panels.append(_over_both(model, samples))
    if laws is not None and laws.temperature is not None:
        panels += _over_temperature(laws.temperature)
    return panels


def band_half_width(model: Model, samples: SlipSamples | None, speed: Vector) -> Vector:
    """Return the half width (n,) [N m | N] of the friction's interval at speeds (n,).

    The half width follows from the intervals of Coulomb and viscous friction, and from the
    correlation of the two estimates. This correlation is -mean(v)/rms(v), with the speed v of the
    samples.
    """
    coulomb, viscous = (_half(getattr(model.parameters, name)) for name in ("coulomb", "viscous"))
    correlation = 0.0
    if samples is not None:
        speeds = np.abs(samples.velocity)
        correlation = -float(np.mean(speeds) / np.sqrt(np.mean(speeds**2)))
    square = coulomb**2 + 2.0 * correlation * coulomb * viscous * speed + (viscous * speed) ** 2
    return np.asarray(np.sqrt(np.maximum(square, 0.0)))


def _half(estimate: Estimate) -> float:
    low, high = estimate.interval
    return 0.5 * (high - low)


def _fastest(model: Model, samples: SlipSamples | None) -> float:
    if samples is not None:
        return REACH * float(np.abs(samples.velocity).max())
    top = model.bench.mechanics.top_speed
    return top.value if top is not None else 1.0


def _over_speed(model: Model, samples: SlipSamples | None) -> FigurePanel:
    effort = si_unit("effort", model.axis)
    fastest = _fastest(model, samples)
    speed = np.linspace(0.0, fastest, POINTS)
    half = band_half_width(model, samples, speed)

    def draw(axes: Axes) -> None:
        for side, colour, name, style in SIDES:
            curve = friction_over_speed(model, speed, side)
            if samples is not None:
                chosen = np.flatnonzero(np.sign(samples.velocity) == side)
                scatter(
                    axes,
                    np.abs(samples.velocity[chosen]),
                    samples.friction[chosen],
                    colour,
                    f"samples {name}",
                )
            axes.fill_between(
                speed,
                curve - half,
                curve + half,
                color=colour,
                alpha=0.22,
                linewidth=0.0,
                label="_interval",
                zorder=3.0,
            )
            axes.plot(speed, curve, color=colour, linestyle=style, label=name, zorder=4.0)
        axes.set(
            xlabel=f"speed [{si_unit('velocity', model.axis)}]",
            ylabel=f"friction in slip [{effort}]",
            xlim=(-MARGIN * fastest, fastest * (1.0 + MARGIN)),
        )
        _from_zero(axes)

    count = 0 if samples is None else samples.velocity.size
    caption = f"The {count} samples that certainly slip" if count else "No sample certainly slips"
    return FigurePanel(
        "Friction over speed",
        f"{caption}; the lines are the model, dashed for backward motion. The band is the joint "
        "interval of Coulomb and viscous friction.",
        draw,
    )


def _over_temperature(law: FrictionOverTemperature) -> list[FigurePanel]:
    changes = (("viscous", law.viscous, FORWARD), ("Coulomb", law.coulomb, BACKWARD))
    known = [(name, one, colour) for name, one, colour in changes if one is not None]
    temperature = np.linspace(law.over.low, law.over.high, POINTS)
    excess = temperature - law.reference.value
    factors = dict(zip(("viscous", "Coulomb"), temperature_factors(law, temperature), strict=True))

    def draw(axes: Axes) -> None:
        for name, change, colour in known:
            curvature = 0.0 if change.curvature is None else _half(change.curvature)
            spread = np.exp(np.hypot(_half(change.slope) * excess, curvature * excess**2))
            curve = factors[name]
            axes.fill_between(
                temperature,
                curve / spread,
                curve * spread,
                color=colour,
                alpha=0.22,
                linewidth=0.0,
                label="_interval",
            )
            style = "-" if name == "viscous" else SIDES[1][3]
            axes.plot(temperature, curve, color=colour, linestyle=style, label=f"{name} friction")
        axes.plot([law.reference.value], [1.0], "o", color="black", label="reference")
        axes.margins(MARGIN)
        axes.set(xlabel="temperature [degC]", ylabel="friction relative to the reference [1]")
        _from_zero(axes)

    caption = (
        f"Factors of viscous and Coulomb friction, relative to {law.reference.value:.4g} degC, at "
        "which the parameters hold. The bands are the intervals of the changes."
    )
    return [FigurePanel("Friction over temperature", caption, draw)] if known else []


def _from_zero(axes: Axes) -> None:
    axes.relim()
    axes.autoscale_view(scalex=False)
    low, high = axes.get_ylim()
    low, high = min(low, 0.0), max(high, 0.0)
    axes.set_ylim(low - MARGIN * (high - low), high + MARGIN * (high - low))


def _over_position(model: Model, ramp: Breakaway) -> FigurePanel:
    law = ramp.by_position

    def draw(axes: Axes) -> None:
        for index, (side, colour, name, style) in enumerate(SIDES):
            chosen = ramp.direction == side
            axes.plot(
                ramp.position[chosen],
                ramp.friction[chosen],
                "x",
                color=colour,
                markersize=4,
                label=f"breakaways {name}",
            )
            if law is None:
                level = ramp.interval
                x = np.array([ramp.position.min(), ramp.position.max()])
                curve = level.value * np.ones(2)
            else:
                level = (law.forward, law.backward)[index]
                x = np.linspace(law.low, law.high, POINTS)
                curve = np.polynomial.polynomial.polyval(x, np.array(law.powers[index]))
            axes.plot(x, curve, color=colour, linestyle=style, label=name)
            axes.fill_between(
                x,
                curve * level.low / level.value,
                curve * level.high / level.value,
                color=colour,
                alpha=0.22,
                linewidth=0.0,
                label="_interval",
            )
        axes.margins(MARGIN)
        axes.set(
            xlabel=f"position [{si_unit('position', model.axis)}]",
            ylabel=f"breakaway [{si_unit('effort', model.axis)}]",
        )
        _from_zero(axes)

    return FigurePanel(
        "Breakaway over position",
        f"Each of the {ramp.onsets} breakaways. The curves are the model, dashed for backward "
        "motion; the bands are the intervals of the curves' means.",
        draw,
    )


def _over_both(model: Model, samples: SlipSamples | None) -> FigurePanel:
    assert model.laws is not None
    assert model.laws.position is not None
    law = model.laws.position
    fastest = _fastest(model, samples)
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
    lowest = min(float(part.min()) for part in parts)
    highest = max(float(part.max()) for part in parts)
    colours = np.linspace(lowest, highest, LEVELS)

    def draw(axes: Axes) -> None:
        drawn = [
            axes.contourf(x, side * speed, part, levels=colours)
            for side, part in zip((-1.0, 1.0), parts, strict=True)
        ]
        figure = axes.get_figure()
        assert figure is not None
        figure.colorbar(
            drawn[0],
            ax=axes,
            ticks=AutoLocator(),
            label=f"friction in slip [{si_unit('effort', model.axis)}]",
        )
        axes.set(
            xlabel=f"position [{si_unit('position', model.axis)}]",
            ylabel=f"velocity [{si_unit('velocity', model.axis)}]",
        )

    return FigurePanel("Friction over position and velocity", "Friction of the model.", draw)
