"""Metrics of a step test, one per file: response time, overshoot, reversals, energy and others.

Each function takes the samples of one hold of the reference (`reference_holds.py`) as arrays in SI.
`origin` and `target` are the reference before and after the step. `resolution` is the step of the
position sensor, 0 if it is not known. docs/metrics.md has the definitions.
"""
