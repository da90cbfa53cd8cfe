"""Loops of the thesis's table 5.1: independent and frictool's simulation, published values."""
