"""Checks of an installation: versions, compiled kernels, solver, C compiler and machine.

Each part is run, not only looked for.
"""
