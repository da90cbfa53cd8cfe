"""Guard of the inputs: it keeps NaN and infinity out of the states of the controller.

    valid sample     the inputs pass unchanged
    invalid sample   each invalid input keeps its last valid value, for at most `hold_samples`
                     invalid samples in a row
    later            fault: the drive is 0 until the controller restarts at a valid position

The state `holds_left` is the number of further invalid samples that do not yet set the fault; it is
-1 in the fault state. A valid sample before the fault resets `holds_left` to `hold_samples`. In
fixed point, one word stands for every value that is not finite (`INVALID` of
control/fixed_point_kernel.py). A start at an invalid position sets the fault immediately.
"""

from __future__ import annotations

from collections.abc import Mapping

from frictool.control.program import GuardNodes, Program, ProgramNode

FAULT = -1.0  # value of `holds_left` in the fault


def write_guard(
    program: Program, inputs: Mapping[str, ProgramNode], hold_samples: int
) -> GuardNodes:
    """Write the guard as the first operations of a program and return its nodes.

    - inputs: inputs by name
    - hold_samples: largest number of invalid samples in a row before the fault

    The controller must use the values `GuardNodes.used` in place of the inputs, and set the drive
    to 0 while `GuardNodes.fault` is true.
    """
    program.block(
        f"an input that is not a number keeps its last valid value for at most {hold_samples} "
        "samples; then the fault is set"
    )
    used = {}
    valid = None
    for name, measured in inputs.items():
        one = program.named(f"{name}_valid", program.valid(measured))
        before = program.state(
            f"{name}_before",
            measured.low,
            measured.high,
            start=0.0 if name == "velocity" else "position",
        )
        used[name] = program.named(
            f"{name}_used",
            program.node("select", one, measured, before, low=measured.low, high=measured.high),
        )
        program.update(f"{name}_before", used[name])
        valid = one if valid is None else valid & one
    assert valid is not None
    zero = program.constant(0.0)
    one_sample = program.constant(1.0)
    hold = program.constant(float(hold_samples), "hold_samples")
    left = program.state("holds_left", FAULT, float(hold_samples), start=float(hold_samples))
    counted = program.larger(left - one_sample, program.constant(FAULT))
    now = program.named("holds_left_now", program.select(valid & (left >= zero), hold, counted))
    program.update("holds_left", now)
    program.guard = GuardNodes(left, now, hold, used, program.named("fault", now < zero))
    return program.guard
