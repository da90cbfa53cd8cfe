"""Metrics of a step test, one per file, such as response time, overshoot and energy.

Each function takes the samples of one hold, a period of constant reference (`reference_holds.py`),
as arrays in SI units. `origin` and `target` are the reference before and after the step.
`resolution` is the step of the position sensor, 0 if unknown. docs/metrics.md has the definitions.
"""
