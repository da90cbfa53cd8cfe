"""Checks of an installation: versions, compiled kernels, solver, C compiler and machine.

A check does not only look for a part of the installation, but runs it.
"""
