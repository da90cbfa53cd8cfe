"""Rigs, experiments, figures and the reproduction of the thesis, which imports frictool alone.

Tests, benchmarks and the Makefiles of configs use them.
"""
