"""Checks of an installation: versions, compiled kernels, solver, C compiler and machine."""
