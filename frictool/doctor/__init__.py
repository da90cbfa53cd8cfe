"""Checks of an installation: versions, compiled kernels, solver, C compiler and machine.

A check runs a part of the installation; the presence of the part is not sufficient.
"""
