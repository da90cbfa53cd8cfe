"""Synthesis methods by name: the keys of a design that each method reads, and help texts.

This module contains one record for each method. Designs, schemas and help texts take all facts on a
method from its record. The method itself is a function with the name of the method, in a module of
the same name in `synth/`. That module is imported when the method is used.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import groupby
from typing import TYPE_CHECKING, Literal

from frictool.documents.pid_gains import check_gains
from frictool.documents.weights import Weights

if TYPE_CHECKING:
    from frictool.documents.design import Design


def check_search(design: Design) -> None:
    """Raise ValueError if a design with method `auto` has weights."""
    if design.weights != Weights():
        raise ValueError("weights: method auto searches them; write weights: {}")


@dataclass(frozen=True)
class SynthesisMethod:
    """Description of a synthesis method.

    - problem: problem that the method solves, as help text
    - use: case for which the method is suited, as help text
    - reads: keys of a design that this method reads, but some other methods do not read
    - structures: controller structures for which the method works
    - check: function that raises ValueError if a design with this method contradicts itself
    - searched: True if `synth` searches structure, gains and weights by simulation; the design may
      contain blocks, which the search keeps
    - provided_gains: True if the design contains the gains. The integral of such a controller stops
      while the drive is limited. In a cascade, the input of the controller is the speed error. The
      method needs no weights
    - more_margin: advice if the loop has too little margin
    - less_noise: advice if the encoder's noise is amplified too much
    """

    problem: str
    use: str
    reads: tuple[str, ...]
    structures: tuple[str, ...] = ("position", "speed_cascade")
    check: Callable[[Design], None] = lambda design: None
    searched: bool = False
    provided_gains: bool = False
    more_margin: str = "raise weights.command or weights.noise, or lower weights.bandwidth_rad_s"
    less_noise: str = "raise weights.command or weights.noise"


SEARCH = ("domain", "order", "integrator", "relax")  # read by each method that searches
INEQUALITIES = (*SEARCH, "poles", "recentring")

METHODS: dict[str, SynthesisMethod] = {
    "lpv": SynthesisMethod(
        "matrix inequalities with one Lyapunov function for all vertices; `synth` stores the "
        "controller of the plant that the key `frozen_at` selects",
        "to judge weights: a design takes seconds, and its gamma (bound of the H-infinity norm)"
        " shows how demanding the weights are",
        (*INEQUALITIES, "schedule", "vertices", "frozen_at", "scheduled", "ease"),
    ),
    "lft": SynthesisMethod(
        "matrix inequalities for the plant in the centre of the box; a second input and output "
        "(uncertainty channel) represent the parameter errors",
        "to reproduce published results; its bound does not hold at every corner of the box",
        (*INEQUALITIES, "channel_effort", "ease"),
    ),
    "lft_lpv": SynthesisMethod(
        "as `lft`, but the controller is scheduled by the friction or other parameters; the "
        "uncertainty channel represents the remaining parameters",
        "if the friction varies more than the other parameters",
        (*INEQUALITIES, "schedule", "scheduled", "channel_effort", "ease"),
    ),
    "lpv_grid": SynthesisMethod(
        "as `lpv`, but the Lyapunov function depends on the parameters, which are constant or "
        "vary slowly. The inequalities hold on a grid and are checked on a finer grid",
        "if the gamma of `lpv` is too large because `lpv` allows parameters that jump",
        (*INEQUALITIES, "schedule", "vertices", "frozen_at", "scheduled", "grid"),
    ),
    "minimax": SynthesisMethod(
        "one constant controller of a specified order; its largest norm at any vertex is as "
        "small as possible",
        "for the controller that will run on the target hardware; a design takes a minute",
        (*SEARCH, "pole_bound_rad_s"),
    ),
    "rst": SynthesisMethod(
        "pole placement for a position controller of order 5",
        "as a reference for comparisons",
        SEARCH,
        structures=("position",),
    ),
    "pid": SynthesisMethod(
        "no synthesis: `synth` verifies the gains in the key `pid` of the design, which has "
        "`weights: {}`",
        "for a loop whose gains are known",
        ("pid",),
        check=check_gains,
        provided_gains=True,
        more_margin="lower the gain, or raise integral_time_s",
        less_noise="lower the gain, or filter_ratio",
    ),
    "auto": SynthesisMethod(
        "search for the simplest controller that meets the specification in simulation; the "
        "design has `weights: {}`",
        "if you do not know the weights (default); the search adds the blocks that the design "
        "does not contain",
        (),
        structures=("speed_cascade",),
        check=check_search,
        searched=True,
    ),
}

READ_BY: dict[str, tuple[str, ...]] = {  # key -> methods that read it
    key: tuple(name for name, method in METHODS.items() if key in method.reads)
    for row in METHODS.values()
    for key in row.reads
}


def readers() -> str:
    """Return text that lists the keys of READ_BY and the methods that read them."""
    groups = groupby(READ_BY, key=READ_BY.__getitem__)
    return "; ".join(
        f"{', '.join(f'`{key}`' for key in keys)} ({', '.join(names)})" for names, keys in groups
    )


if TYPE_CHECKING:
    MethodName = str
    StoredMethod = str
else:
    MethodName = Literal[tuple(METHODS)]
    StoredMethod = Literal[(*METHODS, "own")]  # `own`: designed with another tool
