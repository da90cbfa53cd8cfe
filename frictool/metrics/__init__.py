"""Metrics of a step test: response time, overshoot, reversals, energy, one per file.

Each takes the samples of one hold of the reference (`reference_holds.py`) as arrays in SI. `origin`
and `target` are the reference before and after the step; `resolution` is the position sensor's
step, 0 where none is known. The definitions are in docs/metrics.md.
"""
