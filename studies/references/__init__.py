"""Slow independent solutions, with which the engine and the solvers are compared."""
