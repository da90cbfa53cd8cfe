"""Page with figures 2.12 to 2.14 of the thesis, from a mechanism.yaml of the clutch.

    python -m studies.clutch.mechanism_figures MECHANISM PAGE.html

`make -C configs/clutch mechanism` runs this command. The figures show

- 2.12: forces of both springs on the cart, F_s2 and F_s1 tan(alpha), and mu_c F_s1, over the
  position of the cart
- 2.13: resistance of the cart F_r5 in both directions (2.28); it never drives if the mechanism is
  self-locking (2.27)
- 2.14: friction at the rotor in both directions, C_r2 + r/eta F_r5, and the identified friction
  (4.42), (4.44)
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from string import Template
from typing import TypeVar

import numpy as np
from matplotlib.figure import Figure

from frictool.documents.mechanism import (
    Cam,
    Curve,
    FrictionOf,
    Hydraulic,
    Link,
    Mechanism,
    Rack,
    Spring,
)
from frictool.documents.registry import load
from frictool.plant.mechanism.curves import monotone_cubic
from frictool.presentation.svg import drawing, render
from frictool.typing import Vector
from studies.clutch.mechanism_curves import rotor_torque

Element = TypeVar("Element", bound=Link)
Line = tuple[Vector, str, str]  # values, colour, label
Points = tuple[Vector, str]

FORWARD, BACKWARD, THIRD = "#1f5fa8", "#c0392b", "#2e7d5b"
POINTS = 631
TEXT = Template("""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>Figures 2.12 to 2.14</title>
<style>
body { font: 15px/1.5 sans-serif; color: #1d2733; max-width: 52rem; margin: 2rem auto;
  padding: 0 1rem }
svg { width: 100%; height: auto }
</style>
</head><body>
<h1>The clutch's forces and torques: figures 2.12 to 2.14</h1>
<p>Computed from <code>$source</code>. The thesis only draws these curves. Here
the data of the springs and of the profile are plausible values, chosen so that the friction at the
rotor is that of the real clutch. Table 4.7 publishes this friction, which figure 2.14 shows.</p>
$figures
</body></html>
""")


@dataclass(frozen=True)
class Forces:
    """Forces (n,) at the positions x (n,) [m] of the cart, and constants of the clutch.

    The forces are F_s2, F_s1 tan(alpha) and mu_c F_s1 [N]; the constants are r [m/rad], eta and
    C_r2 [N m].
    """

    x: Vector
    clutch: Vector
    compensation: Vector
    friction: Vector
    ratio: float
    efficiency: float
    brushes: float

    @property
    def cart(self) -> tuple[Vector, Vector]:
        """Return the resistance F_r5 forward and backward [N] (2.28)."""
        return (
            self.clutch - self.compensation + self.friction,
            self.clutch - self.compensation - self.friction,
        )

    @property
    def rotor(self) -> tuple[Vector, Vector]:
        """Return the friction C_r at the rotor forward and backward [N m] (2.29)."""
        forward, backward = self.cart
        scale = self.ratio / self.efficiency
        return self.brushes + scale * forward, self.brushes - scale * backward


def forces(mechanism: Mechanism) -> Forces:
    """Return the forces on the cart of the clutch's mechanism.

    Raises KeyError if `mechanism` is not the clutch.
    """
    rack, areas, cam = (
        _link(mechanism, "rack", Rack),
        _link(mechanism, "hydraulics", Hydraulic),
        _link(mechanism, "compensation", Cam),
    )
    clutch, brushes = _link(mechanism, "clutch", Spring), _link(mechanism, "brushes", FrictionOf)
    assert clutch.force is not None
    ratio = areas.area_a.value / areas.area_b.value
    x = np.linspace(cam.force.position.values[0], cam.force.position.values[-1], POINTS)
    pressing = _at(cam.force, x)
    return Forces(
        x=x,
        clutch=ratio * _at(clutch.force, ratio * x),  # (2.16)
        compensation=pressing * np.tan(_at(cam.angle, x)),
        friction=cam.friction_coefficient * pressing,
        ratio=rack.radius.value,
        efficiency=rack.efficiency,
        brushes=brushes.parameters["coulomb"].value,
    )


def _link(mechanism: Mechanism, name: str, kind: type[Element]) -> Element:
    link = mechanism.links[name]
    if not isinstance(link, kind):
        raise KeyError(name)
    return link


def _at(curve: Curve, x: Vector) -> Vector:
    return monotone_cubic(curve.position.values, curve.value.values).value(x)


def figures(found: Forces) -> list[str]:
    """Return the three figures as `<svg>` elements."""
    way, theta = 1e3 * found.x, found.x / found.ratio
    springs = (
        (found.clutch, FORWARD, "F_s2, the clutch"),
        (found.compensation, BACKWARD, "F_s1 tan(alpha), the compensation"),
        (found.friction, THIRD, "mu_c F_s1, friction"),
    )
    cart = tuple(zip(found.cart, (FORWARD, BACKWARD), ("forward", "backward"), strict=True))
    rotor = tuple(zip(found.rotor, (FORWARD, BACKWARD), ("forward", "backward"), strict=True))
    published = tuple(zip(rotor_torque(theta[::30]), (FORWARD, BACKWARD), strict=True))
    with drawing("clutch"):
        return [
            _figure("Figure 2.12: forces on the cart", ("cart x, mm", "N"), way, springs),
            _figure("Figure 2.13: resistance of the cart", ("cart x, mm", "N"), way, cart),
            _figure(
                "Figure 2.14: friction torque at the rotor; crosses: identified (4.42)",
                ("rotor, rad", "N m"),
                theta,
                rotor,
                published,
            ),
        ]


def _figure(
    title: str,
    labels: tuple[str, str],
    x: Vector,
    lines: tuple[Line, ...],
    points: tuple[Points, ...] = (),
) -> str:
    figure = Figure(figsize=(7.6, 3.4))
    figure.subplots_adjust(left=0.1, right=0.98, bottom=0.15, top=0.9)
    axes = figure.subplots()
    for values, colour, label in lines:
        axes.plot(x, values, color=colour, label=label)
    for values, colour in points:
        axes.plot(x[::30], values, "x", color=colour)
    axes.set_title(title, loc="left")
    axes.set_xlabel(labels[0])
    axes.set_ylabel(labels[1])
    axes.legend(frameon=False)
    return render(figure, title)


def main(arguments: list[str]) -> int:
    if len(arguments) != 2:
        print(__doc__, file=sys.stderr)
        return 2
    source, target = Path(arguments[0]), Path(arguments[1])
    target.parent.mkdir(parents=True, exist_ok=True)
    found = forces(load(source, Mechanism))
    target.write_text(TEXT.substitute(source=source.name, figures="\n".join(figures(found))))
    share = np.abs(found.clutch - found.compensation) / found.friction
    at, most = 1e3 * found.x[share.argmax()], 100.0 * share.max()
    print(
        f"(2.27): the springs leave at most {most:.0f} % of the slideway's friction, at {at:.2f} "
        "mm of the cart"
    )
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
