"""Friction from motion with the drive off: a coast-down, or a free oscillation.

    0 = inertia a + viscous v + coulomb sign(v) + offset + declared loads

Here a is the acceleration and v the velocity. With zero effort, the motion determines only the
ratio of each parameter to the inertia. The inertia is taken from the bench, and its interval widens
the intervals of the other parameters. The ratios do not depend on the bench and are reported as
well.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from frictool.documents.bench import Bench
from frictool.documents.laws import Laws
from frictool.documents.quantity import si_unit
from frictool.identify.fit_result import Interval, SlidingFit, UnusableLogs
from frictool.identify.force_error import SlipRows, Values
from frictool.identify.methods import REFERENCE, IdentificationSettings, run
from frictool.identify.motion_record import MotionRecord
from frictool.identify.rows.slip_fit import known_inertia

# largest rms effort of a drive that is off, divided by smallest inertia times rms acceleration
LARGEST_EFFORT = 0.05
# largest deviation of the effort from its median that counts as noise, divided by the effort at the
# drive's limit
LARGEST_NOISE = 0.1
# largest share of the effort's variance that the motion explains if the effort is noise
LARGEST_EXPLAINED = 0.5
LARGEST_MISFIT = 0.5  # largest rms residual, divided by inertia times rms acceleration
DRIVE_OFF = "the drive was off; such a log shows friction relative to the inertia only"


def drive_was_off(rows: Sequence[SlipRows], bench: Bench) -> bool:
    """Return True if the effort is noise, and too small to have caused the acceleration.

    An effort is too small if its rms is below 5 % of the rms acceleration times the smallest
    inertia in bench.yaml. A driven axis can have such a small effort, too, if the inertia
    in bench.yaml is far too large or the unit of the current is wrong, but then the effort is not
    noise.
    """
    if not rows:
        return False
    efforts = np.concatenate([one.effort for one in rows])
    limit = bench.actuator.limit.value * bench.actuator.constant.value
    if float(np.max(np.abs(efforts - np.median(efforts)))) > LARGEST_NOISE * limit:
        return False
    effort = float(np.sqrt(sum(np.sum(one.effort**2) for one in rows)))
    acceleration = float(np.sqrt(sum(np.sum(one.acceleration**2) for one in rows)))
    small = effort < LARGEST_EFFORT * bench.mechanics.inertia.interval[0] * acceleration
    return small and not _follows_motion(rows)


def _follows_motion(rows: Sequence[SlipRows]) -> bool:
    """Return True if the motion explains more of the effort's variance than LARGEST_EXPLAINED."""
    effort = np.concatenate([one.effort for one in rows])
    velocity = np.concatenate([one.velocity for one in rows])
    acceleration = np.concatenate([one.acceleration for one in rows])
    columns = np.column_stack((acceleration, velocity, np.sign(velocity), np.ones(effort.size)))
    size = np.linalg.norm(columns, axis=0)
    columns /= np.where(size > 0.0, size, 1.0)
    left = effort - columns @ np.linalg.lstsq(columns, effort, rcond=None)[0]
    return float(np.var(left)) < (1.0 - LARGEST_EXPLAINED) * float(np.var(effort))


def coast_down(
    records: list[MotionRecord],
    rows: Sequence[SlipRows],
    bench: Bench,
    settings: IdentificationSettings,
) -> SlidingFit:
    """Fit friction and declared loads to motion with the drive off.

    Raises UnusableLogs if friction and declared loads do not explain the deceleration, or if the
    viscous or Coulomb friction is certainly negative, because another force then drove the axis.
    """
    inertia = known_inertia(bench)
    exact = Interval(inertia.value, inertia.value, inertia.value)
    ratios = run(REFERENCE, records, bench, _with_inertia(settings, exact))
    fit = run(REFERENCE, records, bench, _with_inertia(settings, inertia))
    values = {"offset": 0.0, "viscous": 0.0, "coulomb": 0.0, "inertia": inertia.value}
    values |= {name: one.value for name, one in fit.parameters.items()}
    misfit = inertial_error(rows, values, fit.laws)
    if misfit > LARGEST_MISFIT:
        for name in ("coulomb", "viscous"):
            if name in fit.refused:  # the misfit contains this friction
                raise UnusableLogs(fit.refused[name])
        raise UnusableLogs(
            f"the drive was off; friction leaves {100.0 * misfit:.3g} % of the deceleration "
            f"unexplained (at most {100.0 * LARGEST_MISFIT:g} %); leave the axis free, or "
            "declare load.terms: [offset, spring] or [offset, gravity]"
        )
    for name in ("viscous", "coulomb"):
        if name in ratios.parameters and ratios.parameters[name].high < 0.0:
            raise UnusableLogs(
                f"the drive was off, and the log gives a negative {name} friction: something else, "
                "such as a hand, moved the axis; log the drive's effort, or let the axis coast"
            )
    shown = _ratios(ratios, inertia.value, bench)
    return replace(
        fit,
        parameters={name: _scaled(one, inertia) for name, one in ratios.parameters.items()},
        refused={**fit.refused, "inertia": f"{DRIVE_OFF}: {shown}"},
        residual=misfit,
        held_out_residual=None,
        method=REFERENCE,
        why="the drive was off; the bench's inertia is used",
        fixed={"inertia": inertia},
    )


def inertial_error(rows: Sequence[SlipRows], values: Values, laws: Laws | None) -> float:
    """Return the rms error of the modelled effort, divided by inertia times rms acceleration."""
    left = sum(float(np.sum((one.effort - one.modelled_effort(values, laws)) ** 2)) for one in rows)
    size = sum(float(np.sum((values["inertia"] * one.acceleration) ** 2)) for one in rows)
    return float(np.sqrt(left / size))


def _with_inertia(settings: IdentificationSettings, inertia: Interval) -> IdentificationSettings:
    return replace(settings, fixed={**settings.fixed, "inertia": inertia})


def _scaled(one: Interval, inertia: Interval) -> Interval:
    """Return the interval `one`, fitted for `inertia.value`, widened by the range of `inertia`."""
    factors = inertia.low / inertia.value, inertia.high / inertia.value
    return Interval(
        one.value,
        min(factor * one.low for factor in factors),
        max(factor * one.high for factor in factors),
    )


def _ratios(fit: SlidingFit, inertia: float, bench: Bench) -> str:
    acceleration = si_unit("acceleration", bench.axis)
    units = {"viscous": "1/s", "coulomb": acceleration, "offset": acceleration}
    shown = [
        f"{name} {one.value / inertia:.5g} {units[name]} "
        f"[{one.low / inertia:.5g}, {one.high / inertia:.5g}]"
        for name, one in fit.parameters.items()
        if name in units
    ]
    return ", ".join(shown) or "no friction was identified"
