"""Checks of an installation: versions, compiled kernels, solver, C compiler and machine.

Each check runs a part of the installation.
"""
