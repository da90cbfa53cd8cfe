"""Estimation of wear from ordinary moves, by the weak form of the equation of motion."""
