"""Plot of the resistance against position (as figure 2.14 of the thesis), and its polynomials."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from frictool.documents.model import Model
from frictool.documents.quantity import si_unit
from frictool.presentation.colours import INK, MUTED
from frictool.presentation.svg import drawing, render
from frictool.reduce.reduction_chain import ReductionChain
from frictool.reduce.residual_load import ResidualLoad

WIDTH, HEIGHT = 7.0, 6.4  # inches
FORWARD, BACKWARD = "#1f5fa8", "#c0392b"


def picture(chain: ReductionChain, model: Model) -> str:
    """Return an `<svg>` element that plots friction and load against position."""
    with drawing("reduce"):
        return render(
            figure(chain, model),
            f"{model.name}: resistance as a function of the position in each direction, "
            "and its polynomials",
        )


def figure(chain: ReductionChain, model: Model) -> Figure:
    """Return a figure of resistance and load, with the error of the polynomials below."""
    one = chain.one
    unit = si_unit("position", model.axis)
    effort = si_unit("effort", model.axis)
    drawn = Figure(figsize=(WIDTH, HEIGHT))
    drawn.subplots_adjust(left=0.13, right=0.97, top=0.94, bottom=0.09, hspace=0.32)
    upper, lower = drawn.subplots(2, 1, height_ratios=[2, 1], sharex=True)
    x = one.positions
    load = one.residual.at(x)
    for side, sign, colour, name in (
        (one.forward, 1.0, FORWARD, "forward"),
        (one.backward, -1.0, BACKWARD, "backward"),
    ):
        fitted = np.polynomial.Polynomial(side.coulomb.coefficients)(x)
        curve, rest = (
            np.where(side.met, values, np.nan) for values in (side.curve, side.breakaway)
        )
        upper.plot(x, load + sign * curve, color=colour, linewidth=1.6, label=f"{name}, mechanism")
        upper.plot(x, load + sign * fitted, color=INK, linewidth=0.9, linestyle="--")
        upper.plot(
            x,
            load + sign * rest,
            color=colour,
            linewidth=0.8,
            linestyle=":",
            label=f"{name}, breakaway",
        )
        lower.plot(x, fitted - curve, color=colour, linewidth=1.2)
    if one.residual != ResidualLoad():
        upper.plot(x, load, color=MUTED, linewidth=1.0, label="load")
    if one.play.width > 0.0:
        upper.axhspan(
            -one.inside,
            one.inside,
            color=MUTED,
            alpha=0.12,
            linewidth=0.0,
            label="inside the backlash",
        )
    upper.axhline(0.0, color=MUTED, linewidth=0.8)
    upper.set_ylabel(f"resisting effort, {effort}")
    upper.set_title(
        f"{model.name}: C_r(position, direction), dashed: the polynomials of the model",
        fontsize=10,
        color=INK,
    )
    upper.legend(loc="best", fontsize="x-small", frameon=False)
    lower.set_ylabel(f"polynomial minus curve, {effort}")
    lower.set_xlabel(f"position, {unit}")
    return drawn
