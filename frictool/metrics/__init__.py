"""Metrics of a step test, such as response time, overshoot and energy; one metric per file.

Most functions take the samples of one hold (phase of constant reference) as arrays in SI units.
`origin` and `target` are the reference before and after the step with which the hold begins.
`resolution` is the step of the position sensor, 0 if unknown. docs/metrics.md has the definitions.
"""
