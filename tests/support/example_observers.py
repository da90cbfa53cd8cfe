"""Observer documents for tests, their gains by hand or drawn: what runs is asked for, not whether
it is any good."""

from __future__ import annotations

import functools
from pathlib import Path
from typing import Literal

import numpy as np

from frictool.documents.model import Model
from frictool.documents.observer import FrictionMap, Mode, Observer, Switched
from frictool.documents.provenance import Provenance
from frictool.documents.quantity import Quantity
from frictool.documents.registry import load

NONLINEAR = Path(__file__).parents[2] / "configs/clutch/nonlinear.yaml"
CURVES = ((0.08, 0.007, -2.5e-4, 2.6e-6), (0.1, -0.012, 1.2e-3, -3.0e-5, 2.3e-7))  # N m


@functools.cache
def clutch() -> Model:
    """The non-linear clutch."""
    return load(NONLINEAR, Model)


def drawn_observer(
    seed: int,
    wear: Literal["multiplicative", "additive"],
    kept: float = 1.0,
    viscous: float = 0.0,
    offset: float = 0.0,
    cells: int = 3,
) -> Observer:
    """Gains around (0.8, 300, +-0.5), drawn from `seed`; friction levels too."""
    draw = np.random.Generator(np.random.PCG64([seed, 77]))
    modes = [_mode(0, 0, draw)]
    for direction in (1, -1):
        edges = np.linspace(0.0, 63.0, cells + 1)
        for index in range(1, cells + 1) if wear == "multiplicative" else (1,):
            over = (
                (float(edges[index - 1]), float(edges[index])) if wear == "multiplicative" else None
            )
            modes.append(_mode(direction * index, direction, draw, over))
    indices = [mode.index for mode in modes]
    switched = Switched(
        wear=wear,
        switch_speed=Quantity(value=10.0, unit="rad/s"),
        weights=(1.0, 100.0, 0.001),
        modes=tuple(modes),
        transitions=tuple((i, j) for i in indices for j in indices),
        gamma=1.0,
        stuck_speed=kept,
    )
    bench = clutch().bench
    return Observer(
        format="observer/1",
        name="drawn",
        axis="rotary",
        sample_period_s=bench.sample_period_s,
        inertia=Quantity(value=1.32e-5, unit="kg m^2"),
        friction=FrictionMap(
            over=clutch().bench.mechanics.travel,
            forward=CURVES[0],
            backward=CURVES[1],
            viscous=viscous,
            offset=offset,
        ),
        bench=bench,
        provenance=Provenance(command="written for a test", frictool="0"),
        switched=switched,
    )


def _mode(
    index: int,
    direction: Literal[-1, 0, 1],
    draw: np.random.Generator,
    over: tuple[float, float] | None = None,
) -> Mode:
    one, two, three = (float(value) for value in draw.uniform((0.6, 200.0, 0.2), (1.0, 400.0, 0.8)))
    gains = ((one,), (two,), (-direction * three,))
    if direction == 0:
        gains = ((one, 0.0), (two, 0.0), (0.0, 1.0))
    return Mode(
        index=index,
        direction=direction,
        gains=gains,
        spectral_radius=0.5,
        over=over,
        friction=abs(direction) * float(draw.uniform(0.07, 0.2)),
    )
