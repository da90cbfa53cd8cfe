"""Wear of the dry friction from the moves that an actuator makes anyway: the equation of motion in
weak form, move by move."""
