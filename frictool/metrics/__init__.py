"""Metrics of a step test: response time, overshoot, reversals, energy, one per file."""
