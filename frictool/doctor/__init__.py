"""Checks of an installation: versions, compiled kernels, solver, C compiler and machine.

Each part is run; its presence alone does not pass a check.
"""
