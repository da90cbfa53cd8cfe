"""Rigs, experiments, figures and the reproduction of the thesis; they import frictool only.

Tests, benchmarks and the Makefiles of configs use them.
"""
