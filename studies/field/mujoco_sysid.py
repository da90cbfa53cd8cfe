"""MuJoCo's system identification (`mujoco.sysid`) of one axis.

The model has one joint with inertia (`armature`), damping, frictionloss and a constant force. If
the bench declares gravity, it has a body whose centre of mass is beside the joint. The records are
divided into windows. Each window is simulated from its measured position and speed, driven by the
recorded effort. MuJoCo's least squares minimises the errors of the simulated positions. The
intervals are those of `mujoco.sysid.calculate_intervals`.
"""

from __future__ import annotations

import contextlib
import importlib
import io
import itertools
from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np
from scipy.signal import savgol_filter

from frictool.documents.bench import Bench
from frictool.identify.fit_result import Interval
from frictool.identify.motion_record import MotionRecord
from studies.field.scores import GRAVITY, PLAYED, FieldFit, fit_of, has_gravity

WINDOW_S = 1.0  # duration of a simulation
MOST_WINDOWS = 60  # number of windows, evenly spaced over all records
FEWEST = 20  # samples of a window
SMOOTHED = 11  # samples of the cubic that gives the speed at the beginning of a window
LONGEST_STEP_S = 2e-3  # time step of the simulation; 2e-3 s is MuJoCo's default
WIDE = 10.0  # factor by which the search may leave the ranges of the bench
LEAST = 1e-3  # least start value, relative to the upper end of the bench's range
# kg and m/s^2; on a rotary axis, the heavy body at a small radius adds no inertia
MASS, G = 1e4, 10.0
LIGHT = 1e-9  # kg, mass of the body on a linear axis, whose inertia is in the joint
CONFIDENCE = 0.95
XML = """
<mujoco>
  <option timestep="{step}" integrator="implicitfast" gravity="0 0 -{gravity}">
    <flag contact="disable"/>
  </option>
  <worldbody>
    <body name="load">
      <inertial pos="0 0 0" mass="{mass}" diaginertia="1e-12 1e-12 1e-12"/>
      <joint name="axis" type="{joint}" axis="{direction}"/>
      <geom type="sphere" size="0.01" mass="0"/>
    </body>
  </worldbody>
  <actuator>
    <general name="drive" joint="axis" gaintype="fixed" biastype="affine"/>
  </actuator>
  <sensor><jointpos name="position" joint="axis"/></sensor>
</mujoco>
"""


def mujoco_sysid(
    records: Sequence[MotionRecord], bench: Bench, start: dict[str, float]
) -> FieldFit | str:
    """Return the fit of `mujoco.sysid`, or the reason why there is none.

    start: values of the parameters [SI] at which the search begins
    """
    mujoco, sysid = (importlib.import_module(name) for name in ("mujoco", "mujoco.sysid"))
    importlib.import_module("absl.logging").set_verbosity("error")
    windows = _windows(records)
    if not windows:
        return f"no record has {FEWEST} consecutive samples"
    step = min(LONGEST_STEP_S, *(one.period for one in records))
    joint, direction, mass = (
        ("hinge", "0 1 0", MASS) if bench.axis == "rotary" else ("slide", "1 0 0", LIGHT)
    )
    spec = mujoco.MjSpec.from_string(
        XML.format(step=step, gravity=G, mass=mass, joint=joint, direction=direction)
    )
    parameters = sysid.ParameterDict()
    for name, (value, low, high) in _ranges(bench, records, start).items():
        modifier = partial(_modify, name=name)
        parameters.add(sysid.Parameter(name, value, low, high, modifier=modifier))
    sequences = _sequences(sysid, spec, windows)
    residual = sysid.build_residual_fn(models_sequences=[sequences])
    with contextlib.redirect_stdout(io.StringIO()):
        fitted, result = sysid.optimize(
            parameters, residual, verbose=False, x_scale="jac", optimizer="scipy"
        )
    residuals = residual(fitted.as_vector(), fitted)[0]
    half = sysid.calculate_intervals(residuals, result.jac, 1.0 - CONFIDENCE)[1]
    intervals = {
        name: Interval.around(float(value), float(reach))
        for name, value, reach in zip(parameters.keys(), fitted.as_vector(), half, strict=True)
    }
    return fit_of(intervals)


def _windows(records: Sequence[MotionRecord]) -> list[MotionRecord]:
    """Return at most MOST_WINDOWS parts of the records, without gaps, each of WINDOW_S."""
    windows = []
    for record in records:
        edges = np.flatnonzero(np.diff(record.piece)) + 1
        size = max(FEWEST, round(WINDOW_S / record.period))
        for first, last in itertools.pairwise((0, *edges.tolist(), record.time.size)):
            windows += [
                record.part(slice(start, start + size))
                for start in range(first, last - size + 1, size)
            ]
    chosen = np.unique(np.linspace(0, len(windows) - 1, MOST_WINDOWS).round().astype(int))
    return [windows[k] for k in chosen.tolist()] if windows else []


def _ranges(
    bench: Bench, records: Sequence[MotionRecord], start: dict[str, float]
) -> dict[str, tuple[float, float, float]]:
    """Return name -> (start, least, largest) of the parameters in SI units."""
    effort = max(float(np.max(np.abs(one.effort))) for one in records)
    ranges = {}
    for name in PLAYED[:3]:
        low, high = (float(one) for one in getattr(bench.mechanics, name).interval)
        least, largest = max(low, LEAST * high) / WIDE, high * WIDE
        ranges[name] = (min(max(start.get(name, 0.0), least), largest), least, largest)
    for name in (PLAYED[3], *(GRAVITY if has_gravity(bench) else ())):
        ranges[name] = (start.get(name, 0.0), -2.0 * effort, 2.0 * effort)
    return ranges


def _modify(spec: Any, parameter: Any, name: str) -> None:
    """Write a parameter into the model of MuJoCo."""
    value = float(parameter.value[0])
    joint, body = spec.joint("axis"), spec.body("load")
    if name == "inertia":
        joint.armature = value
    elif name == "viscous":
        joint.damping = [value, 0.0, 0.0]  # factors of v, v |v|, ...
    elif name == "coulomb":
        joint.frictionloss = value
    elif name == "offset":
        spec.actuator("drive").biasprm[0] = -value
    else:
        body.ipos[2 if name == "sine" else 0] = -value / (MASS * G)


def _sequences(sysid: Any, spec: Any, windows: Sequence[MotionRecord]) -> Any:
    """Return the windows as measured sequences of `mujoco.sysid`."""
    model = spec.compile()
    names, states, controls, sensors = [], [], [], []
    for number, window in enumerate(windows):
        time = window.time - window.time[0]
        speed = window.velocity
        if speed is None:
            speed = savgol_filter(window.position, SMOOTHED, 3, deriv=1, delta=window.period)
        names.append(f"window {number}")
        states.append(sysid.create_initial_state(model, window.position[:1], speed[:1]))
        controls.append(sysid.TimeSeries(time, window.effort[:, None]))
        sensors.append(sysid.TimeSeries.from_names(time, window.position[:, None], model))
    return sysid.ModelSequences("axis", spec, names, states, controls, sensors)
